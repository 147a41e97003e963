#pragma once
/// From what a ray met to what a LiDAR reports of it.

#include <cstdint>
#include <memory>
#include <optional>

#include "aslio/simulator/caster.hpp"
#include "aslio/simulator/random.hpp"
#include "aslio/simulator/realism.hpp"
#include "aslio/simulator/scan_pattern.hpp"

namespace aslio::config {
class Binder;
}

namespace aslio::simulator {

/// `lidar:` of a scene file. Absent values are those of the sensor.
struct LidarParams {
  bool noise = true;  ///< false: exact ranges and directions, nothing lost or added at random
  std::optional<double> range_noise, angle_noise;  ///< standard deviations [m], [deg]
  std::optional<double> min_range, max_range;      ///< [m]
  double dropout = 0.02;                           ///< share of pulses lost at random
  double outliers = 0.001;                         ///< share of returns at a random range
  double mixed = 0.1;                              ///< share of pulses whose footprint is followed to a second surface
  double grazing_begin = 70, grazing_end = 80;     ///< incidence from which returns begin to be lost, and all are [deg]
  std::int64_t columns = kUsualColumns;            ///< firings per turn of a spinning sensor
  double weak_range = 90;  ///< a surface of reflectivity 0.1 returns up to here [m]; grows with its square root
  static void describe(config::Binder& b, LidarParams& params);
};

/// One report of the sensor.
struct Return {
  double range = 0;            ///< [m], along the nominal beam
  std::uint8_t intensity = 0;  ///< 0..255: reflectivity times cosine of incidence; range is compensated
  std::uint8_t tag = 0x10;     ///< Livox: single return
};

/// Errors drawn for a pulse before it is cast: where it really goes. A fixed number of draws per stream and beam, so
/// that the streams do not depend on what is hit.
struct Pulse {
  Vec3 direction = Vec3::UnitX();  ///< in L, unit
  bool lost = false;
  bool mixed = false;           ///< cast `second`, too
  Vec3 second = Vec3::UnitX();  ///< another direction within the footprint, unit
  double range_error = 0;       ///< random [m]
  double bias = 0;              ///< systematic, whatever is hit [m]
  double keep = 0;              ///< uniform draw against losses by range and incidence
  double outlier_range = -1;    ///< [m]; negative: none
  double mix = 0.5;             ///< weight of the second surface
  double glass = 1;             ///< uniform draw: what a pane does to it
};

class RangeErrors;

/// One for each packet: its streams depend on (seed, packet) alone, so packets can be simulated in any order.
class ReturnModel {
 public:
  ReturnModel(const LidarParams& params, const SensorFacts& sensor, std::uint64_t seed, std::uint64_t packet,
              const Realism& realism = {});
  ~ReturnModel();

  /// `line` and the time since the sensor was switched on [s] matter to systematic errors alone.
  Pulse emit(const Beam& beam, std::size_t line = 0, double t = 0);
  /// Nothing when the pulse does not come back. `second` is what Pulse::second met (pulses that are mixed).
  std::optional<Return> receive(const Pulse& pulse, const SurfaceHit& hit, const SurfaceHit& second) const;

  double min_range() const { return min_range_; }
  double max_range() const { return max_range_; }

 private:
  /// The echo of a surface, if it is strong enough.
  std::optional<Return> reported(const Pulse& pulse, const SurfaceHit& hit, double range) const;

  LidarParams params_;
  double range_noise_, angle_noise_, min_range_, max_range_, cos_grazing_begin_, cos_grazing_end_;
  double spread_azimuth_, spread_elevation_;  ///< of the footprint [rad]
  RandomStream range_, angle_, loss_, outlier_, mixed_, glass_;
  bool footprint_;                       ///< of every pulse: realism
  std::unique_ptr<RangeErrors> errors_;  ///< none without realism
};

}  // namespace aslio::simulator
