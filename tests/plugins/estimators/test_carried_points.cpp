// Points of earlier updates move along with what later ones correct (eq. IESKF-12).
#include <catch2/catch.hpp>
#include <random>

#include "estimators/carried_points.hpp"
#include "plugins/estimators/room_filter.hpp"

using namespace aslio;
using namespace aslio::test;
using aslio::plugins::CarriedPoints;

namespace {

struct Correction {
  NavState prior, posterior;
};

Correction random_correction(std::mt19937& random, TimeNs t) {
  std::normal_distribution<double> normal;
  const auto vector = [&](double scale) -> Vec3 {
    return scale * Vec3(normal(random), normal(random), normal(random));
  };
  Correction c;
  c.prior.t = c.posterior.t = t;
  c.prior.R = exp_so3(vector(1));
  c.prior.p = vector(50);
  c.posterior = c.prior;
  c.posterior.R = c.prior.R * exp_so3(vector(0.01));
  c.posterior.p += vector(0.02);
  c.posterior.v += vector(0.1);
  return c;
}

}  // namespace

TEST_CASE("a point has gone through every correction since its own update, each by what it had not moved yet") {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-30, 30);
  CarriedPoints carried;
  std::vector<TimeNs> ends{kRoomEpoch};
  std::vector<Correction> corrections;
  for (int k = 0; k < 8; ++k) {
    const TimeNs end = ends.back() + (k % 3 + 1) * 8'000'000;
    corrections.push_back(random_correction(random, end));
    carried.correct(corrections.back().prior, corrections.back().posterior);
    carried.append(ends.back(), end);
    ends.push_back(end);
  }
  std::size_t hint = 0;
  for (TimeNs t = ends.front() + 1; t <= ends.back() + 1'000'000; t += 999'999) {
    const Vec3 p(uniform(random), uniform(random), uniform(random));
    Vec3 expected = p;
    for (std::size_t k = 0; k < corrections.size(); ++k) {
      if (t > ends[k]) continue;  // its own update, or one before it
      const auto& [prior, posterior] = corrections[k];
      expected = posterior.R * (prior.R.transpose() * (expected - prior.p)) + posterior.p -
                 to_seconds(prior.t - t) * (posterior.v - prior.v);
    }
    CAPTURE(t - kRoomEpoch);
    CHECK((carried.place(t, p, hint) - expected).norm() < 1e-9);
    CHECK((carried.place(WorldPoint{.p_W = p, .t = t}) - expected).norm() < 1e-9);
  }
}

TEST_CASE(
    "where nothing moved a point it stays to the last bit: of the newest update, of before the first, forgotten") {
  std::mt19937 random(8);
  CarriedPoints carried;
  const Vec3 p(1.1, -20.3, 0.7);
  std::size_t hint = 0;
  CHECK(carried.place(kRoomEpoch, p, hint) == p);
  const TimeNs first = kRoomEpoch + 10'000'000, second = first + 10'000'000;
  carried.append(kRoomEpoch, first);
  const Correction c = random_correction(random, second);
  carried.correct(c.prior, c.posterior);
  carried.append(first, second);
  CHECK(carried.place(kRoomEpoch, p, hint) == p);
  CHECK(carried.place(second, p, hint) == p);
  CHECK(carried.place(second + 1, p, hint) == p);
  CHECK(carried.place(first, p, hint) != p);
  carried.forget(first);
  CHECK(carried.place(first, p, hint) == p);
  CHECK(carried.place(second, p, hint) == p);
}

TEST_CASE("carry: points that were placed while the velocity was unknown come nearer to the walls they are of") {
  const TurningRoom motion{.rate = Vec3(0, 0, 0.5), .drift = Vec3(0.6, -0.4, 0)};
  constexpr TimeNs step = kTenth / 4;
  const auto errors = [&](bool carry) {
    Filter filter({carry ? "estimator.carry=true" : "estimator.carry=false"}, 1.0);
    filter.build_map(1);
    RoomWindow first(kRoomEpoch, step, motion, 2, 60);
    const Update& update = filter.update(first);
    REQUIRE(update.accepted);
    REQUIRE((update.revision != nullptr) == carry);
    const std::vector<WorldPoint> points(update.map_points.begin(), update.map_points.end());
    for (std::uint32_t k = 1; k < 4; ++k) {
      RoomWindow next(kRoomEpoch + k * step, step, motion, k + 2, 2000);
      next.window.plan.history_begin = kRoomEpoch;
      REQUIRE(filter.update(next).accepted);
    }
    double sum = 0;
    for (const WorldPoint& point : points) {
      const TimedPoint& measured = first.window.fresh[point.index];
      const Vec3 truth = motion.at(measured.t) * measured.p_L.cast<double>();
      sum += ((carry ? update.revision->place(point) : point.p_W) - truth).squaredNorm();
    }
    return std::sqrt(sum / static_cast<double>(points.size()));
  };
  const double carried = errors(true), left = errors(false);
  CAPTURE(carried, left);
  CHECK(carried < 0.7 * left);
}

TEST_CASE("carry: an old point is matched where the correction since has moved it") {
  // One look with a wrong prior corrects the pose by 2 cm; the points of before it, placed 2 cm off, come along.
  for (const bool carry : {false, true}) {
    CAPTURE(carry);
    Filter filter({carry ? "estimator.carry=true" : "estimator.carry=false", "estimator.sigma=0.05"}, 3.0);
    const Pose off{Mat3::Identity(), Vec3(0.02, 0.02, 0.02)};
    RoomWindow first(kRoomEpoch, kTenth / 2, off, 2);
    const Update& before_any_map = filter.update(first);  // over an empty map: placed at the prior
    REQUIRE(before_any_map.status == UpdateStatus::initialising);
    std::vector<HistoryPoint> old;
    for (const WorldPoint& p : before_any_map.match_points) old.push_back({.p_W = p.p_W, .t = p.t, .range = p.range});
    filter.build_map(1);
    RoomWindow second(kRoomEpoch + kTenth / 2, kTenth / 2, off, 3);
    second.window.plan.history_begin = kRoomEpoch;
    REQUIRE(filter.update(second).accepted);
    const Vec3 corrected = filter.estimator->state().p;
    REQUIRE((corrected - off.p).norm() < 0.01);
    // A window of so few points that the old ones decide: they hold the pose back unless they have come along.
    RoomWindow third(kRoomEpoch + kTenth, kTenth / 2, off, 4, 60);
    third.window.plan.history_begin = kRoomEpoch;
    const Update& update = filter.update(third, {.points = old, .max_stamp = 5});
    REQUIRE(update.accepted);
    CHECK(update.history_matches > 500);
    const double moved = (update.state.p - update.prior.p).norm();
    CAPTURE(moved);
    if (carry) CHECK(moved < 0.004);
    if (!carry) CHECK(moved > 0.008);
  }
}
