// Lines and planes against the last sweep and the map: a room seen by a spinning sensor, a corridor that leaves a
// direction open, windows between those that are matched with the map.
#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <limits>
#include <numbers>
#include <random>

#include "aslio/core/errors.hpp"
#include "estimators/sweep_index.hpp"
#include "plugins/estimators/room_filter.hpp"

using namespace aslio;
using namespace aslio::test;
using plugins::SweepIndex;

namespace {

constexpr int kRings = 16, kColumns = 720;

double turn(const Pose& a, const Pose& b) { return log_so3(a.R.transpose() * b.R).norm(); }

/// One revolution of 16 rings within +-30 deg, every point measured from the pose of its own time; the first one at
/// rest, the motion begins behind it. `half` is that of the room; beams that meet its ends (x) at more than `blind_x`
/// [m] return nothing.
class RingWindow {
 public:
  RingWindow(std::uint32_t k, const TurningRoom& motion, const Vec3& half = Vec3(4, 3, 1.5), double blind_x = 1e9) {
    const TimeNs begin = kRoomEpoch + k * kTenth;
    for (int column = 0; column < kColumns; ++column) {
      const double azimuth = 2 * std::numbers::pi * column / kColumns;
      const TimeNs t = begin + (column + 1) * kTenth / kColumns;
      const Pose pose = k == 0 ? Pose{} : motion.at(t - kTenth);
      for (int ring = 0; ring < kRings; ++ring) {
        const double up = (ring - 7.5) * 4.0 * std::numbers::pi / 180.0;
        const Vec3 d(std::cos(up) * std::cos(azimuth), std::cos(up) * std::sin(azimuth), std::sin(up));
        const Vec3 in_W = pose.R * d;
        double range = 1e9;
        for (int axis = 0; axis < 3; ++axis) {
          if (std::abs(in_W[axis]) < 1e-12) continue;
          range = std::min(range, (std::copysign(half[axis], in_W[axis]) - pose.p[axis]) / in_W[axis]);
        }
        if (std::abs((range * in_W).x()) > blind_x) continue;
        TimedPoint point;
        point.x = static_cast<float>(range * d.x());
        point.y = static_cast<float>(range * d.y());
        point.z = static_cast<float>(range * d.z());
        point.t = t;
        point.line = static_cast<std::uint8_t>(ring);
        point.index = static_cast<std::uint32_t>(fresh.size());
        fresh.push_back(point);
      }
    }
    window.plan.history_begin = window.plan.fresh_begin = begin;
    window.plan.end = begin + kTenth;
    window.sequence = k + 1;
    window.fresh = fresh;
  }
  RingWindow(const RingWindow&) = delete;
  std::vector<TimedPoint> fresh;
  Window window;
};

/// A filter whose map grows with what it has seen.
struct Matcher {
  explicit Matcher(const std::string& keys = "")
      : filter({"estimator={type: scan_matcher, prediction: constant_velocity" + keys + "}"}) {
    filter.map = make_stage<Map>(built_in_stages(),
                                 "{type: feature_maps, lines: {type: voxel_hash, min_spacing: 0.05}, "
                                 "planes: {type: voxel_hash, min_spacing: 0.1}}",
                                 filter.environment.context());
    filter.add_sampler("curvature_features");
  }
  const Update& step(const RingWindow& sweep) {
    const Update& update = filter.estimator->update(sweep.window, {}, {filter.samplers, *filter.map, filter.history});
    if (update.insert) filter.map->insert(update.map_points, sweep.window.sequence);
    return update;
  }
  Filter filter;
};

}  // namespace

TEST_CASE("scan_matcher follows a spinning sensor through a room by lines and planes") {  // eqs. SWP-1, SWP-2
  const TurningRoom motion{.rate = Vec3(0, 0, 0.5), .drift = Vec3(0.4, 0.2, 0.05)};
  for (const std::string keys : {"", ", sweep_searches: 0"}) {
    CAPTURE(keys);
    Matcher matcher(keys);
    std::size_t lines = 0;
    for (std::uint32_t k = 0; k < 12; ++k) {
      const RingWindow sweep(k, motion);
      const Update& update = matcher.step(sweep);
      CAPTURE(k);
      CHECK(update.accepted == (k > 0));
      for (const WorldPoint& point : update.map_points) lines += point.feature == feature_class::line ? 1 : 0;
      if (k < 5) continue;
      const Pose truth = motion.at(sweep.window.plan.end - kTenth);
      CHECK((update.state.p - truth.p).norm() < 0.05);
      CHECK(turn(update.state.pose(), truth) < 0.02);
      CHECK((update.state.v - motion.drift).norm() < 0.2);
      CHECK(update.matches.size() == update.match_points.size());
      CHECK(update.fresh_matches > 1000);
    }
    CHECK(lines > 100);
  }
}

TEST_CASE("scan_matcher: the last sweep alone carries windows that are not matched with the map") {
  const TurningRoom motion{.rate = Vec3(0, 0, 0.3), .drift = Vec3(0.5, 0, 0)};
  Matcher matcher(", map_every: 4");
  for (std::uint32_t k = 0; k < 12; ++k) {
    const RingWindow sweep(k, motion);
    const std::size_t before = matcher.filter.map->size();
    const Update& update = matcher.step(sweep);
    CAPTURE(k);
    CHECK(update.insert == (k % 4 == 0));
    CHECK((matcher.filter.map->size() > before) == (k % 4 == 0));
    CHECK(update.accepted == (k > 0));
    if (k < 5) continue;
    const Pose truth = motion.at(sweep.window.plan.end - kTenth);
    CHECK((update.state.p - truth.p).norm() < 0.08);
    CHECK(turn(update.state.pose(), truth) < 0.03);
  }
}

TEST_CASE("scan_matcher: a direction that nothing holds keeps the prediction, and the status says so") {  // eq. SWP-3
  // A corridor along x whose ends return nothing.
  const Vec3 half(1e6, 1.5, 1.2);
  const TurningRoom rest{};
  for (const std::string keys : {"", ", sweep_searches: 0"}) {
    CAPTURE(keys);
    Matcher matcher(keys);
    for (std::uint32_t k = 0; k < 2; ++k) matcher.step(RingWindow(k, rest, half, 12.0));
    const TurningRoom aside{.drift = Vec3(0.6, 0.15, 0.0)};
    for (std::uint32_t k = 2; k < 5; ++k) {
      const RingWindow sweep(k, aside, half, 12.0);
      const Update& update = matcher.step(sweep);
      CAPTURE(k);
      REQUIRE(update.accepted);
      CHECK(update.status == UpdateStatus::degenerate);
      CHECK(std::abs(update.state.p.x()) < 0.01);  // nothing says that it moves along
      CHECK(update.state.p.y() == Approx(aside.at(sweep.window.plan.end - kTenth).p.y()).margin(0.02));
      CHECK(update.P(3, 3) > 20 * update.P(4, 4));
      // A filter that takes it for measured would vouch for its own prediction.
      if (!keys.empty()) CHECK(update.P(3, 3) > 1.0);
    }
  }
}

TEST_CASE("scan_matcher: a search in the map that finds too little says nothing of what the last sweep found") {
  const TurningRoom motion{.rate = Vec3(0, 0, 0.3), .drift = Vec3(0.4, 0, 0)};
  Matcher matcher;
  for (std::uint32_t k = 0; k < 4; ++k) matcher.step(RingWindow(k, motion));
  matcher.filter.map->clear();
  const WorldPoint far{.p_W = Vec3(50, 50, 0), .feature = feature_class::plane};
  matcher.filter.map->insert(std::vector<WorldPoint>(1, far), 1);
  REQUIRE(matcher.filter.map->size() == 1);
  const Update& update = matcher.step(RingWindow(4, motion));
  CHECK(update.accepted);
  CHECK(update.status == UpdateStatus::ok);
  CHECK(update.fresh_matches > 50);
}

TEST_CASE("scan_matcher refuses to match nothing in between") {
  CHECK_THROWS_WITH(Filter({"estimator={type: scan_matcher, map_every: 4, sweep_searches: 0}"}),
                    Catch::Matchers::Contains("map_every") && Catch::Matchers::Contains("sweep_searches"));
}

TEST_CASE("scan_matcher refuses a residual that takes surfaces from the map") {
  CHECK_THROWS_AS(Filter({"estimator={type: scan_matcher, planes: {type: point_to_plane, planes: map}}"}), ConfigError);
}

TEST_CASE("the last sweep: lines and planes as brute force finds them") {  // eq. SWP-1
  std::mt19937_64 random(5);
  const auto uniform = [&](double half) { return half * (static_cast<double>(random() % 200001) / 1e5 - 1.0); };
  for (const double origin : {0.0, -5e5}) {
    std::vector<WorldPoint> points;
    for (int i = 0; i < 600; ++i) {
      WorldPoint point;
      point.p_W = Vec3(origin + uniform(4), uniform(4), uniform(4));
      point.line = static_cast<std::uint8_t>(random() % 12);
      point.feature = i % 3 == 0 ? feature_class::line : feature_class::plane;
      points.push_back(point);
    }
    points.push_back({.p_W = Vec3::Constant(std::numeric_limits<double>::quiet_NaN()), .feature = 2});
    SweepIndex index({.distance = 2.5, .lines = 2});
    index.build(points, feature_class::plane);
    CHECK(index.size() == 400);
    const auto nearest = [&](const Vec3& q, const auto& admit) -> const WorldPoint* {
      const WorldPoint* best = nullptr;
      for (const WorldPoint& p : points) {
        if (p.feature != feature_class::plane || !((p.p_W - q).norm() <= 2.5) || !admit(p)) continue;
        if (best == nullptr || (p.p_W - q).norm() < (best->p_W - q).norm()) best = &p;
      }
      return best;
    };
    int lines = 0, planes = 0, none = 0;
    for (int i = 0; i < 400; ++i) {
      const Vec3 q(origin + uniform(6), uniform(6), uniform(6));
      const WorldPoint* a = nearest(q, [](const WorldPoint&) { return true; });
      const auto other = [&](const WorldPoint& p) { return p.line != a->line && std::abs(p.line - a->line) <= 2; };
      const WorldPoint* b = a == nullptr ? nullptr : nearest(q, other);
      const Surface line = index.line(q), plane = index.plane(q);
      REQUIRE(line.valid == (b != nullptr));
      if (b == nullptr) {
        ++none;
        REQUIRE_FALSE(plane.valid);
        continue;
      }
      ++lines;
      REQUIRE(line.anchor == a->p_W);
      REQUIRE(line.normal.cross(b->p_W - a->p_W).norm() < 1e-9);
      const WorldPoint* c = nearest(q, [&](const WorldPoint& p) { return &p != a && p.line == a->line; });
      if (c == nullptr) REQUIRE_FALSE(plane.valid);
      if (!plane.valid) continue;
      ++planes;
      REQUIRE(std::abs(plane.normal.dot(b->p_W - a->p_W)) < 1e-6);
      REQUIRE(std::abs(plane.normal.dot(c->p_W - a->p_W)) < 1e-6);
    }
    CHECK(lines > 200);
    CHECK(planes > 150);
    CHECK(none > 10);
  }
}

TEST_CASE("scan_matcher: what is not finite against the map is not hidden by the last sweep") {
  const TurningRoom motion{.rate = Vec3(0, 0, 0.3), .drift = Vec3(0.5, 0, 0)};
  Matcher matcher(", planes: unknown, map_every: 2");
  for (std::uint32_t k = 0; k < 6; ++k) {
    CAPTURE(k);
    const Update& update = matcher.step(RingWindow(k, motion));
    CHECK(update.accepted == (k % 2 == 1));
    if (k > 0 && k % 2 == 0) CHECK(update.status == UpdateStatus::non_finite);
    CHECK(update.state.R.allFinite());
    CHECK(update.P.allFinite());
  }
}
