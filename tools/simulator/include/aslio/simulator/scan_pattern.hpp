#pragma once
/// When and where to a LiDAR fires.

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "aslio/core/lie.hpp"
#include "aslio/core/time.hpp"

namespace aslio::simulator {

/// A beam in the LiDAR frame (x forward, z up) and the unit vectors in which its azimuth and elevation grow.
struct Beam {
  Vec3 direction = Vec3::UnitX(), azimuth = Vec3::UnitY(), elevation = Vec3::UnitZ();
  double height = 0;  ///< of its origin above that of the LiDAR frame [m]
};

enum class SensorKind : std::uint8_t { avia, mid360, spin16, spin32, spin64, vlp16, mid40 };
inline constexpr std::array kSensorKinds{SensorKind::avia,   SensorKind::mid360, SensorKind::spin16, SensorKind::spin32,
                                         SensorKind::spin64, SensorKind::vlp16,  SensorKind::mid40};
enum class LidarMessage : std::uint8_t { livox_custom, point_cloud2 };

/// Beams leave in firings of equal size and period; the beams of a firing share its time.
class ScanPattern {
 public:
  virtual ~ScanPattern() = default;
  virtual std::size_t beams_per_firing()
      const = 0;                             ///< beam index = scan line, from the lowest elevation for spinning ones
  virtual TimeNs firing_period() const = 0;  ///< [ns]; divides 0.1 s, but for vlp16
  virtual LidarMessage message() const = 0;
  virtual bool has_heights() const { return false; }  ///< beams leave from different origins
  /// The beams of the firing `since` nanoseconds after the start; `out` has beams_per_firing() elements.
  virtual void fire(TimeNs since, std::span<Beam> out) const = 0;
};

inline constexpr std::int64_t kUsualColumns = 2000;
/// Firings of a spinning sensor per turn that keep to whole nanoseconds and end with each block of 10 ms.
bool may_be_columns(std::int64_t columns);

/// `columns` is the number of firings per turn of a spinning sensor; others have none. Throws ConfigError for a number
/// that may not be.
std::unique_ptr<ScanPattern> make_scan_pattern(SensorKind kind, std::int64_t columns = kUsualColumns);

/// What belongs to a sensor besides its pattern.
struct SensorFacts {
  std::string_view name;                                        ///< as in scene files and `--sensor`
  Vec3 p_imu_lidar = Vec3::Zero();                              ///< origin of L in I [m]; R = identity
  double min_range = 0.5, max_range = 100;                      ///< [m]
  double range_noise = 0.02;                                    ///< standard deviation [m]
  double angle_noise = 4.363e-4;                                ///< standard deviation per axis [rad]
  double beam_divergence = 1e-3;                                ///< full angle, taken as round [rad]: mixed pixels
  double footprint_azimuth = 1e-3, footprint_elevation = 1e-3;  ///< full angles [rad]: with realism
  double motor = 0;  ///< turns per second of what rotates fastest [Hz]; 0: not published
  std::string_view lidar_topic, imu_topic, frame_id;
};
const SensorFacts& facts(SensorKind kind);

}  // namespace aslio::simulator
