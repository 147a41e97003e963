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

double largest_off_diagonal(const Mat3& S) { return (S - Mat3(S.diagonal().asDiagonal())).cwiseAbs().maxCoeff(); }

}  // namespace

std::optional<Calibration> calibration_of(const Update& update) {
  const NavState& x = update.state;
  const StateMatrix& P = update.P;
  const bool finite = x.b_w.allFinite() && x.b_a.allFinite() && x.S_w.allFinite() && std::isfinite(x.imu_delay);
  if (!update.accepted || !finite || !P.allFinite()) return std::nullopt;
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
  if (calibration.gyro_sensitivity) {
    const Mat3 S = 100.0 * calibration.gyro_sensitivity->value;
    text = fmt::format("gyro scale {:+.2f} {:+.2f} {:+.2f} %", S(0, 0), S(1, 1), S(2, 2));
    if (calibration.gyro_sensitivity->sigma(0, 1) > 0.0) {
      text += fmt::format(", cross-axis up to {:.2f} %", largest_off_diagonal(S));
    }
  }
  if (calibration.imu_delay) {
    text += fmt::format("{}IMU delay {:.2f} ms", text.empty() ? "" : ", ", 1e3 * calibration.imu_delay->value);
  }
  return text;
}

}  // namespace aslio::experiment
