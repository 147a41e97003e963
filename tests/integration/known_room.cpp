#include "integration/known_room.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

#include "aslio/simulator/avia.hpp"
#include "aslio/toolkit/information_update.hpp"
#include "aslio/toolkit/initial_covariance.hpp"
#include "pipeline/runs.hpp"
#include "plugins/estimators/room.hpp"

namespace aslio::test {

namespace {

const Vec3 kHalf(4, 3, 1.5);  // of the room of room.hpp
constexpr double kEdge = 0.15;

Vec3 normal3(simulator::RandomStream& random) {
  const double x = random.normal(), y = random.normal(), z = random.normal();
  return {x, y, z};
}

}  // namespace

void TrueWalls::correspond(std::span<const Vec3> queries, const MapQuery& query, Neighbours& out) const {
  out.resize(queries.size(), query.k);
  std::fill(out.count.begin(), out.count.end(), std::uint8_t{0});
}

void TrueWalls::surfaces(std::span<const Vec3> queries, const MapQuery& query, std::span<Surface> out) const {
  (void)query;
  for (std::size_t i = 0; i < queries.size(); ++i) {
    const Vec3 off = (kHalf - queries[i].cwiseAbs()).cwiseAbs();
    int axis = 0;
    const double nearest = off.minCoeff(&axis);
    out[i] = {};
    if (nearest > 0.5 || (off.array() < kEdge).count() > 1) continue;
    const double side = std::copysign(1.0, queries[i][axis]);
    out[i].normal[axis] = -side;
    out[i].anchor = queries[i];
    out[i].anchor[axis] = side * kHalf[axis];
    out[i].valid = true;
  }
}

KnownRoom::KnownRoom(const simulator::Motion& motion, const KnownRoomSetting& setting, std::uint64_t seed)
    : motion_(motion), setting_(setting), random_(seed, 77) {
  environment_.sensor.T_imu_lidar = Pose{};
  environment_.sensor.gyro_noise = setting.imu.gyro_noise;
  environment_.sensor.acc_noise = setting.imu.acc_noise;
  environment_.sensor.gyro_bias_walk = setting.imu.gyro_bias_walk;
  environment_.sensor.acc_bias_walk = setting.imu.acc_bias_walk;
  std::vector<std::string> overrides = {"estimator={type: ieskf}", "estimator.noise=physical",
                                        "estimator.sigma=" + std::to_string(setting.sigma), "history={type: none}"};
  overrides.push_back(setting.map.empty() ? "estimator.residual.planes=map" : "map=" + setting.map);
  overrides.insert(overrides.end(), setting.overrides.begin(), setting.overrides.end());
  const pipeline::PipelineConfig config = shipped("as_lio_plus", overrides);
  estimator_ = config.estimator.make(environment_.context());
  history_ = config.history.make(environment_.context());
  if (setting.map.empty()) {
    map_ = std::make_unique<TrueWalls>();
  } else {
    map_ = config.map.make(environment_.context());
    build_map();
  }
  pattern_phase_ = random_.uniform(0, 100);
  record_imu(seed);
  start();
}

void KnownRoom::build_map() {
  constexpr double spacing = 0.1;
  std::vector<WorldPoint> points;
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (const double side : {-1.0, 1.0}) {
      for (double a = -kHalf[u] + spacing / 2; a < kHalf[u]; a += spacing) {
        for (double b = -kHalf[v] + spacing / 2; b < kHalf[v]; b += spacing) {
          WorldPoint p;
          p.p_W[axis] = side * kHalf[axis];
          p.p_W[u] = a;
          p.p_W[v] = b;
          points.push_back(p);
        }
      }
    }
  }
  map_->insert(points, 0);
}

void KnownRoom::record_imu(std::uint64_t seed) {
  simulator::ImuSimulator imu(motion_, kRoomEpoch, setting_.imu, seed);
  calibration_ = imu.calibration();
  for (TimeNs t = 0; t <= kRoomEpoch + to_ns(motion_.duration());) {
    simulator::ImuSimulator::Output out = imu.next();
    t = out.sample.t;
    Vec3& acc = out.sample.acc;
    if (setting_.accelerometer_calibrated) {
      acc = calibration_.acc_sensitivity.inverse() * (acc - out.acc_bias) + out.acc_bias;
    }
    imu_.samples.push_back(out.sample);
    imu_.gyro_bias.push_back(out.gyro_bias);
    imu_.acc_bias.push_back(out.acc_bias);
  }
}

NavState KnownRoom::truth(TimeNs t) const {
  const auto sample = static_cast<std::size_t>(std::llround(to_seconds(t - kRoomEpoch) * setting_.imu.rate));
  const simulator::MotionState motion = motion_.at(to_seconds(t - kRoomEpoch));
  NavState state;
  state.t = t;
  state.R = motion.R;
  state.p = motion.p;
  state.v = motion.v;
  // w = M^-1 (w_m - b), which the filter writes as w_m - S w_m - b.
  const Mat3 inverse = calibration_.gyro_sensitivity.inverse();
  state.S_w = Mat3::Identity() - inverse;
  state.b_w = inverse * imu_.gyro_bias[sample];
  state.b_a = imu_.acc_bias[sample];
  state.imu_delay = setting_.imu.delay;
  return state;
}

void KnownRoom::start() {
  InitialState initial;
  initial.sigma_tilt = setting_.sigma_tilt;
  initial.sigma_velocity = setting_.sigma_velocity;
  initial.sigma_gyro_bias = setting_.sigma_gyro_bias;
  initial.sigma_acc_bias = setting_.sigma_acc_bias;
  initial.state = truth(kRoomEpoch);
  const aslio::EstimatedStates no_calibration;
  const StateMatrix P = aslio::initial_covariance(initial, no_calibration, initial.sigma_velocity);
  // Diagonal but for the block of g, whose part across the vertical is diagonal, too.
  StateVector error = StateVector::Zero();
  for (int i = 0; i < kStateDim; ++i) error[i] = std::sqrt(P(i, i)) * random_.normal();
  initial.state = aslio::box_plus(initial.state, error, true);
  initial.state.S_w.setZero();
  initial.state.imu_delay = 0;
  estimator_->reset(initial);
  window_.plan.end = kRoomEpoch;
}

bool KnownRoom::at_end() const { return window_.plan.end + setting_.window > kRoomEpoch + to_ns(motion_.duration()); }

const Update& KnownRoom::step() {
  const TimeNs begin = window_.plan.end;
  window_.plan.history_begin = window_.plan.fresh_begin = begin;
  window_.plan.end = begin + setting_.window;
  ++window_.sequence;
  points_.clear();
  for (int i = 0; i < setting_.points; ++i) {
    TimedPoint point;
    point.t = begin + (i + 1) * setting_.window / setting_.points;
    const double s = to_seconds(point.t - kRoomEpoch);
    const simulator::MotionState at = motion_.at(s);
    const Vec3 d = simulator::avia::firing(s + pattern_phase_)[static_cast<std::size_t>(i % 6)].direction;
    Vec3 p = wall_distance(at.p, at.R * d) * d;
    p += setting_.noise == PointNoise::along_the_ray ? Vec3(setting_.sigma * random_.normal() * d)
                                                     : Vec3(setting_.sigma * normal3(random_));
    point.x = static_cast<float>(p.x());
    point.y = static_cast<float>(p.y());
    point.z = static_cast<float>(p.z());
    point.index = static_cast<std::uint32_t>(i);
    points_.push_back(point);
  }
  window_.fresh = points_;
  const auto sample_at = [&](TimeNs t) {
    return static_cast<std::size_t>(std::llround(to_seconds(t - kRoomEpoch) * setting_.imu.rate));
  };
  const std::size_t first = sample_at(begin), last = sample_at(window_.plan.end);
  window_.imu = std::span<const ImuSample>(imu_.samples).subspan(first, last - first + 1);
  return estimator_->update(window_, history_->select(window_), {samplers_, *map_, *history_});
}

double KnownRoom::pose_nees(const Update& update) const {
  const Vec6 error = aslio::box_minus(truth(update.state.t), update.state).head<6>();
  const Mat6 P = update.P.topLeftCorner<6, 6>();
  return error.dot(P.ldlt().solve(error));
}

}  // namespace aslio::test
