#include "aslio/experiment/calibration.hpp"

#include <fmt/format.h>

#include <cmath>

#include "aslio/core/angles.hpp"
#include "aslio/core/lie.hpp"

namespace aslio::experiment {

namespace {

std::optional<Estimate<Vec3>> three(const Vec3& value, const StateMatrix& P, int at) {
  const Vec3 variance = P.diagonal().segment<3>(at);
  if (variance.maxCoeff() <= 0.0) return std::nullopt;
  return Estimate<Vec3>{value, variance.cwiseMax(0.0).cwiseSqrt()};
}

/// Of the largest term beside the diagonal, in percent; empty when all of them are held fixed.
std::string cross_axis(const Estimate<Mat3>& S) {
  if (S.sigma(0, 1) <= 0.0) return {};
  Mat3 off = S.value.cwiseAbs();
  off.diagonal().setConstant(-1.0);
  int row = 0, column = 0;
  off.maxCoeff(&row, &column);
  return fmt::format(", cross-axis up to {:.2f} +- {:.2f} %", 100 * off(row, column), 100 * S.sigma(row, column));
}

}  // namespace

namespace {

std::optional<Estimate<Vec3>> known(const Vec3& value, const Vec3& sigma) {
  if (sigma.maxCoeff() <= 0.0) return std::nullopt;
  return Estimate<Vec3>{value, sigma};
}

void add_sensor(const SensorEstimate& sensor, Calibration& out) {
  const Mat3 turn = sensor.declared.R.transpose() * sensor.T_imu_lidar.R;
  out.extrinsic_turn = known(log_so3(turn), sensor.sigma_rotation);
  out.extrinsic_shift = known(sensor.T_imu_lidar.p - sensor.declared.p, sensor.sigma_translation);
  out.acc_scale = known(sensor.acc_scale, sensor.sigma_acc_scale);
  out.T_imu_lidar = sensor.T_imu_lidar;
}

std::string triple(const Estimate<Vec3>& known, double unit) {
  std::string text;
  for (int axis = 0; axis < 3; ++axis) {
    text +=
        fmt::format("{}{:+.2f} +- {:.2f}", axis == 0 ? "" : ", ", unit * known.value[axis], unit * known.sigma[axis]);
  }
  return text;
}

}  // namespace

std::optional<Calibration> calibration_of(const Update& update) {
  const NavState& x = update.state;
  const StateMatrix& P = update.P;
  const bool finite = x.b_w.allFinite() && x.b_a.allFinite() && x.S_w.allFinite() && std::isfinite(x.imu_delay);
  if (!update.accepted || update.restart_map || !finite || !P.allFinite()) return std::nullopt;
  Calibration out;
  out.t = x.t;
  out.gyro_bias = three(x.b_w, P, block::b_w);
  out.acc_bias = three(x.b_a, P, block::b_a);
  const Mat3 variance = P.diagonal().segment<9>(block::s).reshaped(3, 3);
  if (variance.maxCoeff() > 0.0) out.gyro_sensitivity = {x.S_w, variance.cwiseMax(0.0).cwiseSqrt()};
  if (P(block::d, block::d) > 0.0) out.imu_delay = {x.imu_delay, std::sqrt(P(block::d, block::d))};
  if (update.sensor) add_sensor(*update.sensor, out);
  if (!out.gyro_bias && !out.acc_bias && !out.extrinsic_turn && !out.acc_scale && !out.gyro_sensitivity &&
      !out.imu_delay)
    return std::nullopt;
  return out;
}

std::string to_text(const Calibration& calibration) {
  std::string text;
  if (const auto& S = calibration.gyro_sensitivity) {
    text += "gyro scale " + triple({S->value.diagonal(), S->sigma.diagonal()}, 100) + " %" + cross_axis(*S);
  }
  if (const auto& delay = calibration.imu_delay) {
    text += fmt::format("{}IMU delay {:.2f} +- {:.2f} ms", text.empty() ? "" : ", ", 1e3 * delay->value,
                        1e3 * delay->sigma);
  }
  const auto add = [&](const char* name, const std::optional<Estimate<Vec3>>& value, double unit, const char* of) {
    if (value) text += fmt::format("{}{} {} {}", text.empty() ? "" : ", ", name, triple(*value, unit), of);
  };
  add("LiDAR turned by", calibration.extrinsic_turn, 1 / kRadPerDeg, "deg");
  add("LiDAR shifted by", calibration.extrinsic_shift, 1e3, "mm");
  add("accelerometer scale", calibration.acc_scale, 100, "%");
  return text;
}

}  // namespace aslio::experiment
