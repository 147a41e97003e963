#pragma once
/// Faults put into recordings: what sensors, clocks and recorders do wrong, each with its begin and length.

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "aslio/core/trajectory.hpp"
#include "aslio/io/source.hpp"

namespace aslio::test::faults {

/// Measurements in the order in which they arrive.
using Measurements = std::vector<Measurement>;

/// Of data time, in seconds since the first measurement: [begin, begin + length).
struct Span {
  double begin = 0, length = 1e9;
};

/// Alters a recording in place. A Span counts from the stamp that the first measurement then has.
using Fault = std::function<void(Measurements&)>;

/// Stamp of a message: of the IMU sample, or of the packet's header [ns].
TimeNs stamp_of(const Measurement& measurement);

/// Only the measurements whose stamp is within the span remain.
Fault keep(Span span);
/// `first`, then `second`.
Fault both(Fault first, Fault second);

// IMU
/// Any change of each sample within the span. `index` counts those samples.
Fault alter_imu(Span span, std::function<void(ImuSample&, std::size_t index)> change);
/// Only the samples whose index within the span is a multiple of `keep_every` remain; 0: none does.
Fault drop_imu(Span span, std::size_t keep_every = 0);
/// Each sample within the span comes twice.
Fault repeat_imu(Span span);
/// Each pair of samples within the span arrives in the wrong order.
Fault swap_imu(Span span);
/// The samples within the span arrive only with the first one after it. Stamps stay.
Fault delay_imu(Span span);
/// Linear interpolation to `times` samples per step.
Fault multiply_imu_rate(std::size_t times);
/// The reading of the first sample within the span, repeated.
Fault freeze_imu(Span span);
/// Stamps only, normally distributed; arrival as before.
Fault jitter_imu_stamps(Span span, double sigma_s, std::uint64_t seed);
/// Readings clipped per axis [rad/s, m/s^2].
Fault clip_imu(Span span, double gyro, double acc);
/// Added to each gyro reading within the span [rad/s].
Fault add_gyro_bias(Span span, const Vec3& bias);

// LiDAR
/// Any change of each packet whose stamp is within the span. `index` counts those packets.
Fault alter_packets(Span span, std::function<void(LidarPacket&, std::size_t index)> change);
/// Any change of each point of those packets.
Fault alter_points(Span span, std::function<void(TimedPoint&)> change);
Fault drop_packets(Span span);
/// The packets come without points.
Fault empty_packets(Span span);
/// Every packet is left with about `count` points, evenly taken.
Fault thin_packets(Span span, std::size_t count);
Fault repeat_packets(Span span);
/// Points whose azimuth is within [from, from + width) rad in L are gone.
Fault block_view(Span span, double from, double width);
/// Along the ray, normally distributed [m].
Fault add_range_noise(Span span, double sigma, std::uint64_t seed);
/// A share of the points lies anywhere between 0.5 m and `farthest` on its ray.
Fault add_rain(Span span, double share, double farthest, std::uint64_t seed);

// Both
/// Stamps of sensors within the span, points included, move by `shift` [ns]. Arrival stays.
Fault shift_imu_stamps(Span span, TimeNs shift);
Fault shift_packet_stamps(Span span, TimeNs shift);
Fault shift_stamps(Span span, TimeNs shift);
/// The data of the span are cut out and the gap in time is closed: the sensor is at another place at once. A packet
/// that the begin or the end of the span would cut goes with it.
Fault teleport(Span span);
/// The same for the truth of that recording. `begin`: stamp of its first measurement.
std::vector<StampedPose> teleported(const std::vector<StampedPose>& truth, TimeNs begin, Span span);

/// A recording in memory as a source.
class VectorSource final : public io::MeasurementSource {
 public:
  explicit VectorSource(Measurements measurements) : measurements_(std::move(measurements)) {}
  std::optional<Measurement> next() override;
  io::InputStatus status() const override { return io::InputStatus::complete; }
  const io::SourceNotes& notes() const override { return notes_; }
  std::optional<TimeNs> begin_time() const override;
  std::optional<TimeNs> end_time() const override;

 private:
  Measurements measurements_;
  std::size_t next_ = 0;
  io::SourceNotes notes_;
};

/// All that `source` yields.
Measurements read_all(io::MeasurementSource& source);
/// The same recording with a fault.
Measurements altered(Measurements recording, const Fault& fault);
/// A source that yields what `source` does, with a fault. Reads it to its end at once.
std::unique_ptr<io::MeasurementSource> altered(io::MeasurementSource& source, const Fault& fault);

}  // namespace aslio::test::faults
