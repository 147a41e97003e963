#pragma once
/// Decoders of ROS messages. Each returns an empty text, or what is wrong with the message.

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "aslio/core/measurement.hpp"
#include "aslio/core/sensor.hpp"
#include "aslio/io/message_reader.hpp"
#include "aslio/io/source.hpp"

namespace aslio::io::decode {

using Bytes = std::span<const std::uint8_t>;

/// A serialised message.
struct Message {
  Bytes bytes;
  Encoding encoding = Encoding::ros1;

  Message(Bytes all, Encoding how) : bytes(all), encoding(how) {}
  Message(const RawMessage& raw) : bytes(raw.bytes), encoding(raw.encoding) {}
};

/// No LiDAR sees farther [m]; beyond stand the sentinels and bit errors that overflow integer grids.
inline constexpr float kFarthest = 1e5F;

/// Finite, not the zero return, and not absurdly far.
inline bool is_return(float x, float y, float z) {
  const bool bounded = std::abs(x) < kFarthest && std::abs(y) < kFarthest && std::abs(z) < kFarthest;
  return bounded && (x != 0 || y != 0 || z != 0);
}

/// Header stamp of any message that starts with a std_msgs/Header; nullopt when it is too short.
std::optional<TimeNs> header_stamp(const Message& message);

/// Values as sent, units not yet known.
std::string decode_imu(const Message& message, ImuSample& sample);

/// How the times of a Livox CustomMsg are read.
struct LivoxRule {
  int lidar_id = -1;  ///< of the only sensor that is taken; -1: any
  bool tag_filter = true;
  int scan_lines = 6;
  TimeNs longest_offset = kSecond;  ///< larger offsets are damage
  TimeNs shift = 0;                 ///< from what offsets are sent from to what they count from [ns]
  bool from_header = false;         ///< offsets count from the header stamp, since the time base is another clock
  bool timed = true;                ///< false: offsets mean nothing, all points are at the time they count from
};

/// What one message tells.
struct LivoxFacts {
  TimeNs stamp = 0, timebase = 0;
  std::uint32_t declared = 0, present = 0, valid = 0;
  std::uint8_t lidar_id = 0;
};

std::string decode_livox(const Message& message, const LivoxRule& rule, LidarPacket& packet, LivoxFacts& facts);

/// Factors to SI, how they were found, and doubts; and what the sensor file knows of the IMU (docs/equations.md
/// MOT-11).
struct ImuUnits {
  double acc = 1, gyro = 1;
  std::optional<Mat3> without_sensitivity;                   ///< (I + S)^-1; nothing where S is zero
  TimeNs delay = 0;                                          ///< what stamps are moved back by [ns]
  Vec3 gyro_signs = Vec3::Ones(), acc_signs = Vec3::Ones();  ///< of the axes, as sent
  double gyro_range = 0;                                     ///< as the sensor file declares it [rad/s]; 0: unknown
  std::vector<std::string> verdicts, warnings;

  /// From a sample as sent to SI, without what is known. One of which nothing is known stays as it is, to the bit.
  void apply(ImuSample& sample) const {
    sample.acc = (acc * sample.acc).cwiseProduct(acc_signs);
    sample.gyro = (gyro * sample.gyro).cwiseProduct(gyro_signs);
    for (int i = 0; without_sensitivity && i < 3; ++i) {  // which moves readings from the end of the range
      constexpr double kAtEnd = 0.99;
      const bool clipped = gyro_range > 0 && std::abs(sample.gyro[i]) >= kAtEnd * gyro_range;
      if (clipped) sample.faults |= imu_fault::clipped(false, i);
    }
    if (without_sensitivity) sample.gyro = *without_sensitivity * sample.gyro;
    sample.t -= delay;
  }
};

/// Largest angular rate a common gyroscope can report (+-2000 deg/s = 34.9 rad/s), with some room [rad/s].
inline constexpr double kFastestGyro = 40.0;

/// Judges the units from the first seconds of samples. `where` names file and topic in messages. Throws DataError when
/// the magnitude fits no unit, or not the declared one.
ImuUnits judge_imu_units(std::span<const ImuSample> samples, const SensorConfig& sensor, const std::string& where);

/// The angular rates of a whole recording, as sent. Its beginning is often a standstill, which tells no unit.
class GyroRange {
 public:
  /// Rates that are not finite do not count.
  void add(const Vec3& gyro);
  /// Samples beyond kFastestGyro, read as `units` say.
  std::uint64_t too_fast(const ImuUnits& units) const;
  /// What is to be said of those; empty where there are none.
  std::string beyond(const ImuUnits& units) const;
  /// Doubt in a declared deg/s, which radians per second would pass for a carrier that hardly turns; empty: none. Only
  /// all samples together can tell. Spikes do not: what a carrier turns, it turns for several samples.
  std::string doubt(GyroUnit declared) const;

 private:
  double median_of_latest() const;

  std::array<double, 9> latest_{};  ///< a ring
  std::uint64_t count_ = 0;
  double fastest_ = 0, fastest_sustained_ = 0;  ///< of single samples; of the medians over `latest_`
  std::uint64_t too_fast_ = 0, too_fast_in_degrees_ = 0;
};

}  // namespace aslio::io::decode
