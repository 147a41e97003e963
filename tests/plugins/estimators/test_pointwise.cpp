// The filter that takes points one firing at a time: its transition, its sequential update, its trajectory, and what it
// makes of a room with a gyro at its limit and of a start in motion.
#include <Eigen/LU>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <random>
#include <tuple>

#include "estimators/knot_trajectory.hpp"
#include "estimators/pointwise_state.hpp"
#include "plugins/estimators/room_filter.hpp"

using namespace aslio;
using namespace aslio::test;
using namespace aslio::plugins;
namespace pw = aslio::plugins::pointwise;

namespace {

Vec3 some(std::mt19937_64& engine, double size) {
  const auto one = [&] { return size * (2.0 * static_cast<double>(engine() >> 11) * 0x1p-53 - 1.0); };
  const double x = one(), y = one();
  return {x, y, one()};
}

PointwiseState some_state(std::mt19937_64& engine) {
  PointwiseState x;
  x.t = kRoomEpoch;
  x.R = exp_so3(some(engine, 2.0));
  x.p = some(engine, 10);
  x.v = some(engine, 3);
  x.w = some(engine, 4);
  x.a = some(engine, 15);
  x.g = Vec3(0.1, -0.2, -9.8);
  x.b_w = some(engine, 0.01);
  x.b_a = some(engine, 0.1);
  return x;
}

pw::Vector difference(const PointwiseState& x, const PointwiseState& from) {
  pw::Vector d;
  d << log_so3(from.R.transpose() * x.R), x.p - from.p, x.v - from.v, x.w - from.w, x.a - from.a, x.g - from.g,
      x.b_w - from.b_w, x.b_a - from.b_a;
  return d;
}

pw::Matrix some_covariance(std::mt19937_64& engine) {
  pw::Matrix root;
  for (Eigen::Index i = 0; i < root.size(); i += 3) root.reshaped().segment<3>(i) = some(engine, 1.0);
  return root * root.transpose() + 0.01 * pw::Matrix::Identity();
}

/// Windows of a motion, each inserted into the map where the estimator places it.
void follow(Filter& filter, const TurningRoom& motion, std::uint32_t windows) {
  for (std::uint32_t k = 0; k < windows; ++k) {
    const RoomWindow room(kRoomEpoch + k * kTenth, kTenth, motion, k + 1);
    const Update& update = filter.update(room);
    if (update.restart_map) filter.map->clear();
    filter.map->insert(update.map_points, k + 1);
  }
}

}  // namespace

// eqs. PTW-1, PTW-2.
TEST_CASE("the transition of the pointwise filter is the derivative of its step") {
  std::mt19937_64 engine(4);
  for (int trial = 0; trial < 20; ++trial) {
    const PointwiseState x = some_state(engine);
    const TimeNs until = x.t + kSecond / 50;
    PointwiseState moved = x;
    moved.advance(until);
    const PointwiseTransition transition(x, 0.02);
    const pw::Matrix F = transition.dense();
    constexpr double h = 1e-5;
    for (int i = 0; i < pw::kDim; ++i) {
      PointwiseState plus = x, minus = x;
      plus.add(h * pw::Vector::Unit(i), false);
      minus.add(-h * pw::Vector::Unit(i), false);
      plus.advance(until);
      minus.advance(until);
      const pw::Vector numeric = (difference(plus, moved) - difference(minus, moved)) / (2 * h);
      REQUIRE((F.col(i) - numeric).norm() < 1e-7);
    }
    const PointwiseNoise noise;
    const pw::Matrix P = some_covariance(engine);
    pw::Matrix carried = P;
    transition.apply(noise, carried);
    pw::Vector Q = pw::Vector::Zero();
    Q.segment<3>(pw::v).setConstant(noise.velocity);
    Q.segment<3>(pw::w).setConstant(noise.rate);
    Q.segment<3>(pw::a).setConstant(noise.force);
    Q.segment<3>(pw::b_w).setConstant(noise.gyro_bias);
    Q.segment<3>(pw::b_a).setConstant(noise.acc_bias);
    pw::Matrix expected = F * P * F.transpose();
    expected.diagonal() += 0.02 * 0.02 * Q;
    REQUIRE((carried - expected).norm() < 1e-12 * expected.norm());
  }
}

// eq. PTW-3.
TEST_CASE("measurements taken one by one give what all at once give") {
  std::mt19937_64 engine(8);
  for (int trial = 0; trial < 20; ++trial) {
    const pw::Matrix P = some_covariance(engine);
    constexpr int points = 6, axes = 3, n = points + axes;
    Eigen::Matrix<double, n, pw::kDim> H = Eigen::Matrix<double, n, pw::kDim>::Zero();
    Eigen::Matrix<double, n, 1> r, variance;
    pw::Matrix sequential = P;
    SequentialUpdate update(sequential);
    for (int i = 0; i < n; ++i) {
      r[i] = some(engine, 0.2).x();
      variance[i] = 0.01 + std::abs(some(engine, 0.1).x());
      if (i < points) {
        Vec6 h;
        h << some(engine, 5.0), some(engine, 1.0);
        H.row(i).head<6>() = h.transpose();
        update.pose(h, r[i], variance[i]);
      } else {
        H(i, pw::w + i - points) = H(i, pw::b_w + i - points) = 1.0;
        update.sum(pw::w + i - points, pw::b_w + i - points, r[i], variance[i]);
      }
    }
    const Eigen::Matrix<double, n, n> S = H * P * H.transpose() + Eigen::Matrix<double, n, n>(variance.asDiagonal());
    const Eigen::Matrix<double, pw::kDim, n> K = P * H.transpose() * S.inverse();
    CHECK((update.delta() + K * r).norm() < 1e-9);
    CHECK((sequential - (P - K * H * P)).norm() < 1e-9 * P.norm());
    CHECK(std::abs(update.nis() - r.dot(S.inverse() * r)) < 1e-9);
    CHECK(sequential == sequential.transpose());
  }
}

// eq. TRJ-3.
TEST_CASE("the Jacobian of a trajectory of knots agrees with central differences") {
  std::mt19937_64 engine(2);
  std::vector<MotionSegment> knots;
  for (int i = 0; i < 4; ++i) {
    knots.push_back({kRoomEpoch + i * kTenth, 0.0, exp_so3(some(engine, 2)), some(engine, 5), some(engine, 3),
                     some(engine, 4), some(engine, 5)});
  }
  const auto trajectory_of = [](const std::vector<MotionSegment>& of) {
    KnotTrajectory out;
    for (const MotionSegment& knot : of) out.append(knot);
    return out;
  };
  const KnotTrajectory trajectory = trajectory_of(knots);
  CHECK(trajectory.pose(kRoomEpoch - kTenth).p == knots[0].p);
  for (const TimeNs t : {kRoomEpoch, kRoomEpoch + kTenth / 3, kRoomEpoch + 2 * kTenth, kRoomEpoch + 37 * kTenth / 10}) {
    const Pose pose = trajectory.pose(t);
    Eigen::MatrixXd jacobian;
    trajectory.jacobian(t, jacobian);
    REQUIRE(jacobian.cols() == trajectory.dof());
    constexpr double h = 1e-6;
    for (int i = 0; i < trajectory.dof(); ++i) {
      const auto moved = [&](double step) {
        auto other = knots;
        MotionSegment& knot = other[static_cast<std::size_t>(i / 6)];
        if (i % 6 < 3) knot.R = knot.R * exp_so3(step * Vec3::Unit(i % 6));
        if (i % 6 >= 3) knot.p += step * Vec3::Unit(i % 6 - 3);
        return trajectory_of(other).pose(t);
      };
      Vec6 numeric;
      const Pose plus = moved(h), minus = moved(-h);
      numeric << log_so3(pose.R.transpose() * plus.R) - log_so3(pose.R.transpose() * minus.R), plus.p - minus.p;
      REQUIRE((jacobian.col(i) - numeric / (2 * h)).norm() < 1e-7);
    }
  }
}

// eq. PTW-4.
TEST_CASE("the pointwise filter tells a state per firing, and places each point from its own") {
  Filter filter({"estimator={type: pointwise_eskf}"});
  filter.build_map(1);
  const TurningRoom motion{.rate = Vec3(0.1, 0, 1.5), .drift = Vec3(0.03, 0, 0)};
  for (std::uint32_t k = 0; k < 5; ++k) {
    const RoomWindow room(kRoomEpoch + k * kTenth, kTenth, motion, k + 2);
    const Update& update = filter.update(room);
    REQUIRE(update.accepted);
    REQUIRE(update.states.size() >= room.fresh.size());
    for (std::size_t i = 1; i < update.states.size(); ++i) REQUIRE(update.states[i - 1].t < update.states[i].t);
    CHECK(update.states.back().t == room.window.plan.end);
    if (k < 2) continue;
    CHECK(update.nis < 1.0);
    for (const NavState& state : update.states) {
      REQUIRE((state.p - motion.at(state.t).p).norm() < 0.02);
      REQUIRE(log_so3(state.R.transpose() * motion.at(state.t).R).norm() < 0.01);
    }
    // Placed along the path, the points of the whole turn lie on the walls.
    for (const WorldPoint& p : update.map_points) {
      const double outside = (p.p_W.cwiseAbs() - Vec3(4, 3, 1.5)).maxCoeff();
      REQUIRE(std::abs(outside) < 0.06);
    }
  }
}

// eq. PTW-5.
TEST_CASE("the pointwise filter turns on where the gyro is at its limit, unless it believes the limit") {
  const TurningRoom motion{.rate = Vec3(0, 0, 4.0)};
  double error[2] = {};
  for (const bool known : {false, true}) {
    Filter filter({"estimator={type: pointwise_eskf, gyro_saturation: " + std::string(known ? "2.0" : "0") + "}"});
    filter.build_map(1);
    for (std::uint32_t k = 0; k < 10; ++k) {
      RoomWindow room(kRoomEpoch + k * kTenth, kTenth, motion, k + 2);
      for (ImuSample& sample : room.imu) sample.gyro = sample.gyro.cwiseMax(-2.0).cwiseMin(2.0);
      const Update& update = filter.update(room);
      if (k < 5) continue;
      const double turn = log_so3(update.state.R.transpose() * motion.at(update.state.t).R).norm();
      error[known ? 1 : 0] = std::max(error[known ? 1 : 0], turn);
    }
  }
  CHECK(error[1] < 0.01);
  CHECK(error[0] > 2 * error[1]);
}

// eq. PTW-5.
TEST_CASE(
    "the pointwise filter keeps its velocity while the accelerometer is at its limit, unless it believes the limit") {
  const TurningRoom motion{.rate = Vec3(0, 0, 0.3), .drift = Vec3(0.2, 0, 0)};
  double error[2] = {};
  for (const bool known : {false, true}) {
    Filter filter({"estimator={type: pointwise_eskf, acc_saturation: " + std::string(known ? "8.0" : "0") + "}"}, 3.0);
    filter.build_map(1);
    for (std::uint32_t k = 0; k < 10; ++k) {
      RoomWindow room(kRoomEpoch + k * kTenth, kTenth, motion, k + 2);
      for (ImuSample& sample : room.imu) sample.acc = sample.acc.cwiseMax(-8.0).cwiseMin(8.0);  // gravity is beyond
      const Update& update = filter.update(room);
      if (k < 5) continue;
      error[known ? 1 : 0] = std::max(error[known ? 1 : 0], (update.state.v - motion.drift).norm());
    }
  }
  CHECK(error[1] < 0.1);
  CHECK(error[0] > 2 * error[1]);
}

namespace {

/// State after one window whose readings `change` has altered.
template <class Change>
std::uint64_t after(const std::string& keys, const Change& change) {
  Filter filter({"estimator={type: pointwise_eskf" + keys + "}"});
  filter.build_map(1);
  RoomWindow room(kRoomEpoch, kTenth, TurningRoom{.rate = Vec3(0, 0, 0.5)}, 2);
  change(room);
  room.window.imu = room.imu;
  return pipeline::state_digest(filter.update(room).state);
}

}  // namespace

// eq. PTW-5.
TEST_CASE("the pointwise filter takes readings alone, not what was interpolated at the end of a window") {
  const auto last = [](double turn, bool read) {
    return after("", [=](RoomWindow& room) {
      room.imu.back().gyro.z() += turn;
      room.window.imu_read_at_end = read;
    });
  };
  CHECK(last(0, false) == last(0.3, false));
  CHECK(last(0, true) != last(0.3, true));
  CHECK(last(0, true) != last(0, false));
}

// eq. PTW-5.
TEST_CASE("the pointwise filter believes nothing between a reading at the limit and another") {
  const auto next = [](const std::string& keys, double rate) {
    return after(keys, [=](RoomWindow& room) {
      ImuSample begin = room.imu.front(), end = room.imu.back();
      begin.gyro.z() = 2.0;  // clipped
      end.gyro.z() = rate;
      room.imu = {begin, end};
      room.window.imu_read_at_end = false;
    });
  };
  CHECK(next(", gyro_saturation: 2.0", 1.0) == next(", gyro_saturation: 2.0", 0.5));
  CHECK(next("", 1.0) != next("", 0.5));
}

// eq. PTW-6.
TEST_CASE("the pointwise filter finds the velocity of a start in motion") {
  const TurningRoom motion{.rate = Vec3(0, 0, 0.3), .drift = Vec3(1.5, -0.8, 0)};
  Filter filter({"estimator={type: pointwise_eskf}"});
  InitialState initial;
  initial.state.t = kRoomEpoch;
  initial.mode = InitialMode::dynamic_start;
  initial.sigma_velocity = 3.0;
  initial.sigma_gyro_bias = 0.02;
  initial.sigma_tilt = 0.17;
  filter.estimator->reset(initial);
  follow(filter, motion, 10);
  const NavState& state = filter.estimator->state();
  CHECK((state.v - motion.drift).norm() < 0.1);
}

TEST_CASE("the pointwise filter records the length of a residual of several rows") {
  Filter filter({"estimator={type: pointwise_eskf, residual: {type: point_to_point}}"});
  filter.build_map(1);
  const Update& found = filter.update(RoomWindow(kRoomEpoch, kTenth, Pose{}, 2));
  REQUIRE(found.accepted);
  // Nearest points of a wall lie to any side, so that a length is above a single component nearly everywhere.
  std::size_t negative = 0, accepted = 0;
  for (const MatchRecord& m : found.matches) {
    accepted += m.accepted;
    negative += m.accepted && m.residual < 0;
  }
  CHECK(accepted == 1000);
  CHECK(negative == 0);
  CHECK(found.nis < 3.0);
}

TEST_CASE("the pointwise filter takes means of cubes at their mean time, but a first map of all points") {  // eq. PTW-7
  const std::string estimator = "estimator={type: pointwise_eskf, mean_leaf: 1, first_map: all}";
  Filter filter({estimator});
  const RoomWindow first(kRoomEpoch, kTenth, TurningRoom{}, 1), second(kRoomEpoch + kTenth, kTenth, TurningRoom{}, 2);
  const Update& start = filter.update(first);
  REQUIRE(start.status == UpdateStatus::initialising);
  CHECK(start.map_points.size() == first.fresh.size());
  filter.map->insert(start.map_points, 1);

  const Update& update = filter.update(second);
  REQUIRE(update.accepted);
  std::map<std::tuple<double, double, double>, std::vector<const TimedPoint*>> cubes;
  for (const TimedPoint& p : second.fresh) cubes[{std::floor(p.x), std::floor(p.y), std::floor(p.z)}].push_back(&p);
  CHECK(cubes.size() < second.fresh.size() / 10);
  const auto placed = update.points(PointUse::map);
  REQUIRE(placed.size() == cubes.size());
  CHECK(std::is_sorted(placed.begin(), placed.end(), [](const auto& a, const auto& b) { return a.t < b.t; }));
  for (const auto& [cube, members] : cubes) {
    Vec3 mean = Vec3::Zero();
    TimeNs late = 0;
    for (const TimedPoint* p : members) {
      mean += Vec3(p->x, p->y, p->z) / static_cast<double>(members.size());
      late += p->t - kRoomEpoch;
    }
    const TimeNs t = kRoomEpoch + late / static_cast<TimeNs>(members.size());
    const auto found = std::find_if(placed.begin(), placed.end(), [&](const WorldPoint& p) {
      return std::abs(p.t - t) <= 1 && (p.p_W - mean).norm() < 0.02;
    });
    CHECK(found != placed.end());  // at rest, where the filter is within 2 cm
  }
}

TEST_CASE("the pointwise filter samples the first map as any other where nothing else is asked") {
  Filter filter({"estimator={type: pointwise_eskf, mean_leaf: 1}"});
  const RoomWindow first(kRoomEpoch, kTenth, TurningRoom{}, 1);
  CHECK(filter.update(first).map_points.size() < first.fresh.size() / 10);
}
