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
  c.prior.v = vector(2);
  c.posterior = c.prior;
  c.posterior.R = c.prior.R * exp_so3(vector(0.01));
  c.posterior.p += vector(0.02);
  c.posterior.v += vector(0.1);
  return c;
}

bool same_pose(const NavState& a, const NavState& b) { return a.p == b.p && a.R == b.R; }

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
                 to_seconds(prior.t - t) * (posterior.v - posterior.R * prior.R.transpose() * prior.v);
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

TEST_CASE("a path without force or turn, begun otherwise: points go where it would have seen them") {
  std::mt19937 random(9);
  constexpr TimeNs end = kRoomEpoch + 100'000'000;
  const Correction c = random_correction(random, end);
  CarriedPoints carried;
  carried.append(kRoomEpoch, end - 20'000'000);
  carried.correct(c.prior, c.posterior);
  const Vec3 seen(4, -2, 1);  // in I
  std::size_t hint = 0;
  for (TimeNs t = kRoomEpoch + 1; t < end - 20'000'000; t += 7'000'000) {
    const double before = to_seconds(end - t);
    const auto place = [&](const NavState& x) -> Vec3 { return x.R * seen + x.p - before * x.v; };
    CHECK((carried.place(t, place(c.prior), hint) - place(c.posterior)).norm() < 1e-9);
  }
}

TEST_CASE("a refused update moves nothing, nor does one whose motion nobody knows, and a new map lets go of all") {
  std::mt19937 random(10);
  const TimeNs first = kRoomEpoch + 10'000'000, second = first + 10'000'000;
  const WorldPoint point{.p_W = Vec3(3, 2, 1), .t = first};
  const Correction c = random_correction(random, second);
  const auto after = [&](auto&& change) -> Vec3 {
    CarriedPoints carried;
    carried.append(kRoomEpoch, first);
    carried.correct(c.prior, c.posterior);
    Update update;
    update.prior = c.prior;
    update.state = c.posterior;
    update.status = UpdateStatus::ok;
    update.accepted = true;
    change(update);
    WindowPlan plan;
    plan.history_begin = kRoomEpoch;
    plan.fresh_begin = first;
    plan.end = second;
    carried.follow(update, plan);
    return carried.place(point);
  };
  const Vec3 once = after([](Update& u) { u.accepted = false; });
  CHECK(once != point.p_W);
  CHECK(after([](Update&) {}) != once);
  CHECK(after([](Update& u) { u.restart_map = true; }) == point.p_W);
  CHECK(after([](Update& u) { u.status = UpdateStatus::non_finite; }) == once);
}

TEST_CASE("points from before a motion that nobody knows stay where they are, those after it move on") {
  std::mt19937 random(11);
  const TimeNs first = kRoomEpoch + 10'000'000, second = first + 10'000'000, third = second + 10'000'000;
  const Vec3 p(3, 2, 1);
  const auto follow = [](CarriedPoints& carried, UpdateStatus status, const Correction& c, TimeNs begin, TimeNs end) {
    Update update;
    update.prior = c.prior;
    update.state = c.posterior;
    update.status = status;
    update.accepted = status == UpdateStatus::ok;
    WindowPlan plan;
    plan.fresh_begin = begin;
    plan.end = end;
    carried.follow(update, plan);
  };
  CarriedPoints carried;
  const Correction known = random_correction(random, second), later = random_correction(random, third + 1);
  carried.append(kRoomEpoch, first);
  carried.correct(known.prior, known.posterior);
  std::size_t hint = 0;
  const Vec3 settled = carried.place(first, p, hint);
  follow(carried, UpdateStatus::non_finite, known, first, second);
  follow(carried, UpdateStatus::ok, later, second, third);
  CHECK(settled != p);
  CHECK(carried.place(first, p, hint) == settled);
  const Vec3 moved = carried.place(second, p, hint);
  CHECK(moved != p);
  carried.forget(first);  // one of those that have settled
  const Correction last = random_correction(random, third + 2);
  carried.correct(last.prior, last.posterior);
  CHECK(carried.place(second, p, hint) != moved);
  carried.clear();
  carried.append(kRoomEpoch, first);
  carried.correct(last.prior, last.posterior);
  CHECK(carried.place(first, p, hint) != p);
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
    const PointRevision* revision = update.revision;
    REQUIRE((revision != nullptr) == carry);
    const std::vector<WorldPoint> points(update.map_points.begin(), update.map_points.end());
    for (std::uint32_t k = 1; k < 4; ++k) {
      RoomWindow next(kRoomEpoch + k * step, step, motion, k + 2, 2000);
      next.window.plan.history_begin = kRoomEpoch;
      REQUIRE(filter.update(next).accepted);
    }
    double sum = 0;
    for (const WorldPoint& point : points) {
      const TimedPoint& measured = first.window.fresh[point.index];
      const Vec3 truth = motion.at(measured.t) * Vec3(measured.x, measured.y, measured.z);
      sum += ((carry ? revision->place(point) : point.p_W) - truth).squaredNorm();
    }
    return std::sqrt(sum / static_cast<double>(points.size()));
  };
  const double carried = errors(true), left = errors(false);
  CAPTURE(carried, left);
  CHECK(carried < 0.7 * left);
}

TEST_CASE("carry: an old point is matched where the corrections since have moved it") {
  const TurningRoom motion{.drift = Vec3(0.4, 0.4, 0.3)};
  constexpr TimeNs step = kTenth / 2;
  Filter carries({"estimator.carry=true"}, 3.0), leaves({"estimator.carry=false"}, 3.0),
      told({"estimator.carry=false"}, 3.0);
  std::vector<HistoryPoint> old;
  CarriedPoints by_hand;
  for (Filter* filter : {&carries, &leaves, &told}) {
    const Update& unmatched = filter->update(RoomWindow(kRoomEpoch, step, motion, 2));  // placed as if at rest
    REQUIRE(unmatched.status == UpdateStatus::initialising);
    old.clear();
    by_hand.clear();
    for (const WorldPoint& p : unmatched.match_points) old.push_back({.p_W = p.p_W, .t = p.t, .range = p.range});
    filter->build_map(1);
    RoomWindow next(kRoomEpoch + step, step, motion, 3);
    next.window.plan.history_begin = kRoomEpoch;
    const Update& corrected = filter->update(next);
    REQUIRE(corrected.accepted);
    by_hand.append(kRoomEpoch, kRoomEpoch + step);
    by_hand.correct(corrected.prior, corrected.state);
  }
  RoomWindow last(kRoomEpoch + 2 * step, step, motion, 4, 60);
  last.window.plan.history_begin = kRoomEpoch;
  const Update& carried = carries.update(last, {.points = old, .max_stamp = 5});
  REQUIRE(carried.history_matches > 500);
  const Update& left = leaves.update(last, {.points = old, .max_stamp = 5});
  CHECK_FALSE(same_pose(left.state, carried.state));
  // As if somebody had moved them before.
  std::size_t hint = 0;
  for (HistoryPoint& point : old) point.p_W = by_hand.place(point.t, point.p_W, hint);
  CHECK(same_pose(told.update(last, {.points = old, .max_stamp = 5}).state, carried.state));
}
