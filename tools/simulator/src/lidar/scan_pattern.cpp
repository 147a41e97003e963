#include "aslio/simulator/scan_pattern.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <numbers>

#include "aslio/core/angles.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/simulator/avia.hpp"

namespace aslio::simulator {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr TimeNs kTurnTime = kSecond / 10, kBlockTime = kSecond / 100;

struct SineCosine {
  double sine = 0, cosine = 1;
};
SineCosine sine_cosine(double angle) { return {std::sin(angle), std::cos(angle)}; }
/// Of the sum of two angles.
SineCosine operator+(const SineCosine& a, const SineCosine& b) {
  return {a.sine * b.cosine + a.cosine * b.sine, a.cosine * b.cosine - a.sine * b.sine};
}

Beam beam_at(const SineCosine& azimuth, const SineCosine& elevation) {
  Beam beam;
  beam.direction << elevation.cosine * azimuth.cosine, elevation.cosine * azimuth.sine, elevation.sine;
  beam.azimuth << -azimuth.sine, azimuth.cosine, 0;
  beam.elevation << -elevation.sine * azimuth.cosine, -elevation.sine * azimuth.sine, elevation.cosine;
  return beam;
}

/// The rosette of avia.hpp, with the sines of the line offsets taken once.
class Avia final : public ScanPattern {
 public:
  Avia() {
    for (int line = 0; line < avia::kLines; ++line)
      offsets_[static_cast<std::size_t>(line)] = sine_cosine((line - 2) * avia::kLineSpacing * kRadPerDeg);
  }
  std::size_t beams_per_firing() const override { return avia::kLines; }
  TimeNs firing_period() const override { return avia::kFiringPeriod; }
  LidarMessage message() const override { return LidarMessage::livox_custom; }
  void fire(TimeNs since, std::span<Beam> out) const override {
    const avia::Angles middle = avia::angles(to_seconds(since));
    const SineCosine azimuth = sine_cosine(middle.azimuth), elevation = sine_cosine(middle.elevation);
    for (std::size_t line = 0; line < offsets_.size(); ++line) out[line] = beam_at(azimuth, elevation + offsets_[line]);
  }

 private:
  std::array<SineCosine, avia::kLines> offsets_;
};

/// A Livox Mid-40: one beam through two prisms that turn as those of the Avia, in a round field of view of 38.4 deg.
class Mid40 final : public ScanPattern {
 public:
  std::size_t beams_per_firing() const override { return 1; }
  TimeNs firing_period() const override { return 10'000; }  // 100 000 points per second
  LidarMessage message() const override { return LidarMessage::livox_custom; }
  void fire(TimeNs since, std::span<Beam> out) const override {
    constexpr double reach = 38.4 / 4 * kRadPerDeg;  // of each prism: a quarter of the field of view
    const double t = to_seconds(since);
    const SineCosine first = sine_cosine(avia::kPrism1 * t), second = sine_cosine(avia::kPrism2 * t);
    out[0] =
        beam_at(sine_cosine(reach * (first.cosine + second.cosine)), sine_cosine(reach * (first.sine + second.sine)));
  }
};

/// A model of the Livox Mid-360, whose pattern is not published: a mirror turns at about 10 rev/s and nods at about
/// 400 Hz through 59 deg; four lines a quarter of a nod apart. The two rates have no small common multiple, so that the
/// pattern does not repeat for a thousand seconds.
class Mid360 final : public ScanPattern {
 public:
  std::size_t beams_per_firing() const override { return 4; }
  TimeNs firing_period() const override { return 20'000; }  // 200 000 points per second
  LidarMessage message() const override { return LidarMessage::livox_custom; }
  void fire(TimeNs since, std::span<Beam> out) const override {
    constexpr double turns = 10.007, nods = 397.043;  // [1/s]
    constexpr double low = -7, high = 52;             // [deg]
    const double t = to_seconds(since);
    const SineCosine azimuth = sine_cosine(kTurn * std::fmod(turns * t, 1.0));
    const double phase = std::fmod(nods * t, 1.0);
    for (std::size_t line = 0; line < out.size(); ++line) {
      // A triangle wave covers elevations evenly; a sine would crowd its ends.
      const double u = std::fmod(phase + 0.25 * static_cast<double>(line), 1.0);
      const double share = u < 0.5 ? 2 * u : 2 - 2 * u;
      out[line] = beam_at(azimuth, sine_cosine((low + (high - low) * share) * kRadPerDeg));
    }
  }
};

/// Beams at fixed elevations, evenly spaced, on a head that turns 10 times per second.
class Spinning final : public ScanPattern {
 public:
  Spinning(int beams, double lowest, double highest, std::int64_t columns)
      : columns_(columns), period_(kTurnTime / columns) {
    for (int k = 0; k < beams; ++k)
      elevations_.push_back(sine_cosine((lowest + (highest - lowest) * k / (beams - 1)) * kRadPerDeg));
    for (std::int64_t column = 0; column < columns; ++column)
      azimuths_.push_back(sine_cosine(-kTurn * static_cast<double>(column) / static_cast<double>(columns)));
  }
  std::size_t beams_per_firing() const override { return elevations_.size(); }
  TimeNs firing_period() const override { return period_; }
  LidarMessage message() const override { return LidarMessage::point_cloud2; }
  void fire(TimeNs since, std::span<Beam> out) const override {
    const SineCosine& azimuth = azimuths_[static_cast<std::size_t>((since / period_) % columns_)];
    for (std::size_t k = 0; k < elevations_.size(); ++k) out[k] = beam_at(azimuth, elevations_[k]);
  }

 private:
  std::int64_t columns_;
  TimeNs period_;
  std::vector<SineCosine> elevations_, azimuths_;  ///< clockwise seen from above, from x
};

/// A Velodyne VLP-16 as its manual (63-9243) has it: its lasers fire one after the other, 2.304 us apart, in a cycle of
/// 55.296 us, and do not leave from one point. All beams of a cycle share its time; their azimuths are those of their
/// own.
class Vlp16 final : public ScanPattern {
 public:
  Vlp16() {
    for (int line = 0; line < kBeams; ++line)
      elevations_[static_cast<std::size_t>(line)] = sine_cosine((-15.0 + 2.0 * line) * kRadPerDeg);
  }
  std::size_t beams_per_firing() const override { return kBeams; }
  TimeNs firing_period() const override { return 55'296; }
  LidarMessage message() const override { return LidarMessage::point_cloud2; }
  bool has_heights() const override { return true; }
  void fire(TimeNs since, std::span<Beam> out) const override {
    constexpr TimeNs kLaserTime = 2'304;
    // Of the lasers by line: the lower half are those of even numbers.
    constexpr std::array<double, kBeams> kHeights = {11.2, 9.7,  8.1,  6.6,  5.1,  3.7,  2.2,  0.7,
                                                     -0.7, -2.2, -3.7, -5.1, -6.6, -8.1, -9.7, -11.2};  // mm
    for (std::size_t line = 0; line < kBeams; ++line) {
      const std::size_t laser = line < kBeams / 2 ? 2 * line : 2 * line - (kBeams - 1);
      const TimeNs at = (since + kLaserTime * static_cast<TimeNs>(laser)) % kTurnTime;
      const double azimuth = -kTurn * static_cast<double>(at) / static_cast<double>(kTurnTime);
      out[line] = beam_at(sine_cosine(azimuth), elevations_[line]);
      out[line].height = 1e-3 * kHeights[line];
    }
  }

 private:
  static constexpr int kBeams = 16;
  std::array<SineCosine, kBeams> elevations_;
};

}  // namespace

bool may_be_columns(std::int64_t columns) {
  return columns > 0 && kTurnTime % columns == 0 && kBlockTime % (kTurnTime / columns) == 0;
}

std::unique_ptr<ScanPattern> make_scan_pattern(SensorKind kind, std::int64_t columns) {
  if (!may_be_columns(columns))
    throw ConfigError(
        fmt::format("lidar.columns: {} columns do not end with every 10 ms; give 400, 500, 800, 1000, 1250, "
                    "1600 or 2000, say",
                    columns));
  switch (kind) {
    case SensorKind::mid360:
      return std::make_unique<Mid360>();
    case SensorKind::spin16:
      return std::make_unique<Spinning>(16, -15.0, 15.0, columns);
    case SensorKind::spin32:
      return std::make_unique<Spinning>(32, -30.67, 10.67, columns);
    case SensorKind::spin64:
      return std::make_unique<Spinning>(64, -24.8, 2.0, columns);
    case SensorKind::vlp16:
      return std::make_unique<Vlp16>();
    case SensorKind::mid40:
      return std::make_unique<Mid40>();
    default:
      return std::make_unique<Avia>();
  }
}

}  // namespace aslio::simulator
