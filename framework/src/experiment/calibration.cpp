#include "aslio/experiment/calibration.hpp"

#include <fmt/format.h>

#include <cmath>

namespace aslio::experiment {

namespace {

std::optional<Known<Vec3>> three(const Vec3& value, const StateMatrix& P, int at) {
  const Vec3 variance = P.diagonal().segment<3>(at);
  if (variance.maxCoeff() <= 0.0) return std::nullopt;
  return Known<Vec3>{value, variance.cwiseMax(0.0).cwiseSqrt()};
}

/// Of the largest term beside the diagonal, in percent; empty when all of them are held fixed.
std::string cross_axis(const Known<Mat3>& S) {
  if (S.sigma(0, 1) <= 0.0) return {};
  Mat3 off = S.value.cwiseAbs();
  off.diagonal().setConstant(-1.0);
  int row = 0, column = 0;
  off.maxCoeff(&row, &column);
  return fmt::format(", cross-axis up to {:.2f} +- {:.2f} %", 100 * off(row, column), 100 * S.sigma(row, column));
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
  if (!out.gyro_bias && !out.acc_bias && !out.gyro_sensitivity && !out.imu_delay) return std::nullopt;
  return out;
}

std::string to_text(const Calibration& calibration) {
  std::string text;
  if (const auto& S = calibration.gyro_sensitivity) {
    for (int axis = 0; axis < 3; ++axis) {
      text += fmt::format("{}{:+.2f} +- {:.2f}", axis == 0 ? "gyro scale " : ", ", 100 * S->value(axis, axis),
                          100 * S->sigma(axis, axis));
    }
    text += " %" + cross_axis(*S);
  }
  if (const auto& delay = calibration.imu_delay) {
    text += fmt::format("{}IMU delay {:.2f} +- {:.2f} ms", text.empty() ? "" : ", ", 1e3 * delay->value,
                        1e3 * delay->sigma);
  }
  return text;
}

}  // namespace aslio::experiment
