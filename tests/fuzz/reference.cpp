#include "aslio/io/reference.hpp"

#include "aslio/core/trajectory.hpp"
#include "fuzz/target.hpp"

namespace aslio::fuzz {
namespace {

/// What is read is a trajectory: finite, and each pose later than the one before.
void read(const io::ReferenceSpec& spec) {
  accepts([&] {
    const io::Reference reference = io::read_reference(spec);
    must(!reference.poses.empty(), "a reference has a pose");
    (void)Trajectory(reference.poses);
    for (const StampedPose& pose : reference.poses) {
      must((pose.T.R.transpose() * pose.T.R - Mat3::Identity()).norm() < 1e-9, "an orientation is a rotation");
      must(!reference.positions_only || pose.T.R == Mat3::Identity(), "positions alone have no orientation");
    }
  });
}

}  // namespace
}  // namespace aslio::fuzz

ASLIO_FUZZ_TARGET(reference) {
  io::ReferenceSpec spec = written("input.csv", bytes);
  read(spec);
  spec.times = spec.file;
  spec.min_spacing = 0.01;
  for (const auto format : {io::ReferenceFormat::tum, io::ReferenceFormat::euroc, io::ReferenceFormat::kitti}) {
    spec.format = format;
    read(spec);
  }
  spec = io::ReferenceSpec(std::filesystem::path(spec.file));
  spec.columns = {"t", "x", "y", "z", "qw", "qx", "qy", "qz"};
  spec.time_unit = io::TimeUnit::us;
  spec.time_offset = -1.5;
  read(spec);
  spec.columns = {"sec", "nsec", "x", "y", "z"};
  spec.positions_only = io::PositionsOnly::yes;
  read(spec);
  spec.format = io::ReferenceFormat::recording;
  spec.columns.clear();
  read(spec);
}
