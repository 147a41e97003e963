#pragma once
/// What IMU data around a start say, whether the first or a new one.

#include <span>

#include "aslio/pipeline/initialiser.hpp"

namespace aslio::pipeline {

struct Averages {
  std::size_t n = 0;
  Vec3 gyro = Vec3::Zero(), acc = Vec3::Zero();
  double acc_std = 0;
};
Averages average(std::span<const ImuSample> samples);

/// The samples of [begin, end], two at least, until they reach over `time` [s] and to `until`. Empty while they do not.
std::span<const ImuSample> samples_over(const stream::MeasurementStream& stream, TimeNs begin, TimeNs end, double time,
                                        TimeNs until);

bool is_at_rest(const Averages& mean, const InitialisationParams& params);
/// Steps of a walk: over 0.1 s the mean lies within 6 and 14 m/s^2.
bool may_be_gravity(double norm, bool at_rest);
/// The smallest rotation that takes a direction to +z.
Mat3 to_vertical(const Vec3& up);

/// A start with nothing but the samples `used` and their `mean`, of which the attitude is left open.
Initialisation start_of(std::span<const ImuSample> used, const Averages& mean, bool is_static,
                        const SensorModel& sensor);
/// At rest in the origin of W, with the axes of I.
Initialisation start_without_imu(TimeNs t);

}  // namespace aslio::pipeline
