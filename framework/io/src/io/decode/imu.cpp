#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "aslio/core/angles.hpp"
#include "aslio/core/errors.hpp"
#include "decode.hpp"
#include "wire.hpp"

namespace aslio::io::decode {
namespace {

Vec3 vector(Wire& wire) {
  Vec3 v;
  for (int i = 0; i < 3; ++i) v[i] = wire.get<double>();
  return v;
}

bool like_g(double norm) { return norm >= 0.7 && norm <= 1.4; }
bool like_mps2(double norm) { return norm >= 7.0 && norm <= 13.0; }

/// Median norm of the specific force over the first second; not finite ones do not count.
double median_norm(std::span<const ImuSample> samples) {
  std::vector<double> norms;
  for (const ImuSample& s : samples) {
    if (s.t - samples.front().t <= kSecond && s.acc.allFinite()) norms.push_back(s.acc.norm());
  }
  if (norms.empty()) return std::nan("");
  const auto middle = norms.begin() + static_cast<std::ptrdiff_t>(norms.size() / 2);
  std::nth_element(norms.begin(), middle, norms.end());
  return *middle;
}

void judge_acc(double norm, AccUnit declared, const std::string& where, ImuUnits& units) {
  if (declared == AccUnit::g && like_mps2(norm)) {
    throw DataError(
        fmt::format("{}: acc_unit is g, but the acceleration has a norm of {:.3f} at the start: it is in "
                    "m/s^2 (a factor of 9.80665); set `acc_unit: mps2` or `auto`",
                    where, norm));
  }
  if (declared == AccUnit::mps2 && like_g(norm)) {
    throw DataError(
        fmt::format("{}: acc_unit is mps2, but the acceleration has a norm of {:.3f} at the start: it is "
                    "in g (a factor of 9.80665); set `acc_unit: g` or `auto`",
                    where, norm));
  }
  const bool in_g = declared == AccUnit::g || (declared == AccUnit::automatic && like_g(norm));
  if (declared == AccUnit::automatic && !in_g && !like_mps2(norm)) {
    throw DataError(
        fmt::format("{}: the acceleration has a median norm of {:.3f} over the first second: neither g "
                    "(0.7 to 1.4) nor m/s^2 (7 to 13); check the sensor, or declare `acc_unit`",
                    where, norm));
  }
  if (!like_g(norm) && !like_mps2(norm)) {
    units.warnings.push_back(
        fmt::format("{}: acceleration norm {:.3f} at the start fits neither g nor m/s^2", where, norm));
  }
  units.acc = in_g ? kStandardGravity : 1.0;
  const char* how = declared == AccUnit::automatic ? "found" : "declared";
  units.verdicts.push_back(
      in_g ? fmt::format("imu acceleration: g ({}; norm {:.3f} at the start), multiplied by 9.80665", how, norm)
           : fmt::format("imu acceleration: m/s^2 ({}; norm {:.3f} at the start)", how, norm));
}

void judge_gyro(std::span<const ImuSample> samples, GyroUnit declared, const std::string& where, ImuUnits& units) {
  double fastest = 0;
  std::size_t too_fast = 0;
  for (const ImuSample& s : samples) {
    if (!s.gyro.allFinite()) continue;
    fastest = std::max(fastest, s.gyro.norm());
    too_fast += s.gyro.norm() > kFastestGyro ? 1 : 0;
  }
  // A few spikes are bit errors, not a unit.
  const bool degrees = too_fast >= 5;
  if (declared == GyroUnit::rad_s && degrees) {
    throw DataError(
        fmt::format("{}: gyro_unit is rad_s, but {} samples exceed {} rad/s (fastest {:.1f}): they are in "
                    "deg/s (a factor of pi/180); set `gyro_unit: deg_s` or `auto`",
                    where, too_fast, kFastestGyro, fastest));
  }
  const bool in_degrees = declared == GyroUnit::deg_s || (declared == GyroUnit::automatic && degrees);
  units.gyro = in_degrees ? kRadPerDeg : 1.0;
  units.verdicts.push_back(fmt::format("imu angular rate: {} ({}; fastest {:.3f} at the start){}",
                                       in_degrees ? "deg/s" : "rad/s",
                                       declared != GyroUnit::automatic ? "declared"
                                       : in_degrees                    ? "found, no gyroscope turns so fast in rad/s"
                                                                       : "assumed, nothing speaks against it",
                                       fastest, in_degrees ? ", multiplied by pi/180" : ""));
}

/// eq. MOT-11.
void take_calibration(const SensorConfig& sensor, ImuUnits& units) {
  if (!sensor.gyro_sensitivity.isZero(0)) {
    units.without_sensitivity = (Mat3::Identity() + sensor.gyro_sensitivity).inverse();
    Mat3 cross = sensor.gyro_sensitivity;
    cross.diagonal().setZero();
    units.verdicts.push_back(
        fmt::format("imu angular rate: without the gyro_sensitivity of the sensor file (scale up to {:.2f} %, "
                    "cross-axis up to {:.2f} %)",
                    100 * sensor.gyro_sensitivity.diagonal().cwiseAbs().maxCoeff(), 100 * cross.cwiseAbs().maxCoeff()));
  }
  units.delay = to_ns(sensor.imu_delay);
  for (std::size_t i = 0; i < 3; ++i) {
    units.gyro_signs[static_cast<int>(i)] = sensor.gyro_signs[i];
    units.acc_signs[static_cast<int>(i)] = sensor.acc_signs[i];
  }
  if (units.delay != 0) {
    units.verdicts.push_back(fmt::format("imu stamps: {:.3f} ms {} than sent, by the imu_delay of the sensor file",
                                         1e3 * std::abs(to_seconds(units.delay)),
                                         units.delay > 0 ? "earlier" : "later"));
  }
  if (sensor.times.imu_time_offset != 0) {
    units.delay -= to_ns(sensor.times.imu_time_offset);
    units.verdicts.push_back(
        fmt::format("imu stamps: {:+.6f} s, by the imu_time_offset of the sensor file", sensor.times.imu_time_offset));
  }
}

}  // namespace

std::optional<TimeNs> header_stamp(const Message& message) {
  Wire wire(message);
  if (!wire.cdr()) wire.get<std::uint32_t>();
  const TimeNs stamp = wire.time();
  return wire.ok() ? std::optional(stamp) : std::nullopt;
}

std::string decode_imu(const Message& message, ImuSample& sample) {
  Wire wire(message);
  sample.t = wire.header();
  wire.skip<double>(4 + 9);  // orientation and its covariance
  sample.gyro = vector(wire);
  wire.skip<double>(9);
  sample.acc = vector(wire);
  wire.skip<double>(9);
  return wire.ok() ? std::string{} : wire.problem("an Imu");
}

void GyroRange::add(const Vec3& gyro) {
  const double rate = gyro.norm();
  if (!std::isfinite(rate)) return;
  fastest_ = std::max(fastest_, rate);
  too_fast_ += rate > kFastestGyro ? 1 : 0;
  too_fast_in_degrees_ += rate * kRadPerDeg > kFastestGyro ? 1 : 0;
  latest_[count_++ % latest_.size()] = rate;
  if (count_ >= latest_.size()) fastest_sustained_ = std::max(fastest_sustained_, median_of_latest());
}

double GyroRange::median_of_latest() const {
  auto sorted = latest_;
  const std::size_t n = std::min<std::size_t>(count_, sorted.size());
  std::nth_element(sorted.begin(), sorted.begin() + n / 2, sorted.begin() + n);
  return sorted[n / 2];
}

std::uint64_t GyroRange::too_fast(const ImuUnits& units) const {
  return units.gyro < 1 ? too_fast_in_degrees_ : too_fast_;
}

std::string GyroRange::beyond(const ImuUnits& units) const {
  const std::uint64_t count = too_fast(units);
  if (count == 0) return {};
  return fmt::format("{} sample(s) turn faster than {:.0f} rad/s (the fastest {:.1f}), beyond any gyroscope; {}", count,
                     kFastestGyro, fastest_ * units.gyro,
                     units.gyro < 1 ? "check the sensor" : "if they are in deg/s set `gyro_unit: deg_s`");
}

std::string GyroRange::doubt(GyroUnit declared) const {
  constexpr double kSlow = 10;    // deg/s: what is carried about turns faster some time
  constexpr double kUsual = 0.5;  // rad/s: a standstill, in either unit, stays below
  const double fastest = count_ < latest_.size() ? median_of_latest() : fastest_sustained_;
  if (declared != GyroUnit::deg_s || fastest >= kSlow || fastest <= kUsual) return {};
  return fmt::format(
      "gyro_unit is deg_s, but nothing in all that was read, spikes aside, turns faster than {:.3f} deg/s; taken as "
      "rad/s that is a usual motion of up to {:.0f} deg/s: if the data are in rad/s (a factor of pi/180) "
      "set `gyro_unit: rad_s` or `auto`",
      fastest, fastest / kRadPerDeg);
}

ImuUnits judge_imu_units(std::span<const ImuSample> samples, const SensorConfig& sensor, const std::string& where) {
  if (samples.empty()) throw DataError(fmt::format("{}: there is no IMU sample", where));
  ImuUnits units;
  judge_acc(median_norm(samples), sensor.acc_unit, where, units);
  judge_gyro(samples, sensor.gyro_unit, where, units);
  take_calibration(sensor, units);
  units.gyro_range = sensor.model.gyro_range;
  return units;
}

}  // namespace aslio::io::decode
