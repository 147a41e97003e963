#include "aslio/experiment/measure.hpp"
#include "aslio/io/writers.hpp"
#include "fuzz/target.hpp"

ASLIO_FUZZ_TARGET(tum) {
  const auto path = written("input.tum", bytes);
  accepts([&] {
    const std::vector<StampedPose> poses = io::read_tum(path);
    std::string text;
    for (const StampedPose& pose : poses) text += io::tum_line(pose);
    const auto copy = written("copy.tum", {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
    const std::vector<StampedPose> again = io::read_tum(copy);
    must(again.size() == poses.size(), "every pose is written");
    for (std::size_t i = 0; i < poses.size(); ++i) {
      must(again[i].t == poses[i].t && again[i].T.p == poses[i].T.p, "times and positions read back to the bit");
    }
    const Trajectory trajectory(poses);
    for (const auto rule : {evaluation::Rule::interpolated, evaluation::Rule::evo}) {
      (void)evaluation::evaluate(trajectory, trajectory, experiment::measuring_options(trajectory, rule));
    }
  });
}
