// When points enter the map, seen over whole runs: conservation, and that it makes no difference where windows do not
// overlap.
#include <algorithm>
#include <catch2/catch.hpp>

#include "aslio/core/errors.hpp"
#include "aslio/simulator/analytic_world.hpp"
#include "pipeline/runs.hpp"

using namespace aslio;
using namespace aslio::test;

namespace {

/// A map that refuses nothing, since none of its small voxels is ever full, and forgets nothing.
const std::vector<std::string> kKeepAll = {
    "map={type: voxel_hash, voxel: 0.25, min_spacing: 0, max_points: 4096, radius: 1000}",
    "estimator.residual={type: point_to_plane}",
    "samplers=[{type: range}, {type: stride, keep_every: 5}, {type: voxel, leaf: 0.3, uses: [map, match]}]"};

/// Counts what updates hand to the map, once and once per window it lies in.
class Offered final : public pipeline::UpdateObserver {
 public:
  void on_update(const pipeline::UpdateRecord& record) override {
    inserted += record.inserted.inserted;
    if (!record.update->insert) return;
    points += record.update->points(PointUse::map).size();
    for (const WorldPoint& p : record.update->points(PointUse::map)) times_.push_back(p.t);
    const auto inside = [&](TimeNs t) { return t > record.plan.history_begin; };
    in_windows += static_cast<std::size_t>(std::count_if(times_.begin(), times_.end(), inside));
  }
  std::size_t points = 0, in_windows = 0, inserted = 0;

 private:
  std::vector<TimeNs> times_;
};

struct Outcome {
  std::vector<std::uint64_t> digests;
  std::vector<Vec3> map;
  Offered offered;
  std::size_t map_before_end = 0;
};

Outcome play(const std::string& pipeline, std::vector<std::string> overrides) {
  overrides.insert(overrides.begin(), kKeepAll.begin(), kKeepAll.end());
  const simulator::AnalyticWorld world({.duration_scale = 0.5});
  const auto source = world.source();
  Outcome out;
  Run run(shipped(pipeline, overrides), world.sensor());
  run.odometry.add_observer(out.offered);
  for (const Measurement& measurement : record(*source, world.begin_time() + 4 * kSecond)) run.push(measurement);
  out.map_before_end = run.odometry.map().size();
  run.finish();
  out.digests = run.digests();
  run.odometry.map().visit([&](const Vec3& p) { out.map.push_back(p); });
  REQUIRE(out.digests.size() > 20);
  CAPTURE(pipeline, overrides);
  for (const auto& loss : run.odometry.losses()) FAIL_CHECK(loss.reason);
  return out;
}

}  // namespace

TEST_CASE("on_new and on_exit: after the end of the stream the map holds each point once") {
  for (const std::string insertion : {"on_new", "on_exit"}) {
    CAPTURE(insertion);
    const Outcome run = play("as_lio_plus", {"insertion=" + insertion});
    CHECK(run.map.size() == run.offered.points);
    if (insertion == "on_exit") {
      CHECK(run.map_before_end < run.map.size());  // the last window was still waiting
      CHECK(run.offered.inserted < run.map.size());
    } else {
      CHECK(run.offered.inserted == run.map.size());
    }
  }
}

TEST_CASE("where windows do not overlap on_exit and whole_window make the run of on_new, bit for bit") {
  const Outcome reference = play("fixed_window", {"insertion=on_new"});
  for (const std::string insertion : {"on_exit", "whole_window"}) {
    CAPTURE(insertion);
    const Outcome run = play("fixed_window", {"insertion=" + insertion});
    CHECK(run.digests == reference.digests);
    CHECK(run.map == reference.map);
  }
}

TEST_CASE("whole_window keeps the points of overlapping windows several times, unless the map refuses them") {
  const Outcome once = play("as_lio_plus", {"insertion=on_new"}),
                again = play("as_lio_plus", {"insertion=whole_window"});
  CHECK(again.map.size() == again.offered.in_windows);
  CHECK(again.map.size() > once.map.size() + 1000);
  const Outcome spaced = play("as_lio_plus", {"insertion=whole_window", "map.min_spacing=0.15"});
  CHECK(spaced.map.size() < once.map.size());
}

TEST_CASE("an insertion that asks for nearest points is refused over a map of surfaces") {
  for (const std::string insertion : {"min_distance", "cell_nearest"}) {
    const simulator::AnalyticWorld world;
    const std::vector<std::string> overrides = {"map={type: voxel_plane}",
                                                "estimator.residual={type: point_to_plane, planes: map}"};
    const auto with = [&](const std::string& name) {
      auto all = overrides;
      all.push_back("insertion=" + name);
      return shipped("as_lio_plus", all);
    };
    CHECK_NOTHROW(Run(with("on_exit"), world.sensor()));
    CHECK_THROWS_WITH(Run(with(insertion), world.sensor()),
                      Catch::Contains("insertion: '" + insertion + "'") && Catch::Contains("'voxel_plane'"));
    CHECK_THROWS_AS(Run(with(insertion), world.sensor()), ConfigError);
  }
}
