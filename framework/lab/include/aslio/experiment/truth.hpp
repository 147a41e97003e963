#pragma once
/// A reference as runs, `aslio evaluate` and reports measure against it.

#include <span>
#include <string>
#include <vector>

#include "aslio/evaluation/evaluation.hpp"
#include "aslio/io/reference.hpp"
#include "aslio/io/source.hpp"

namespace aslio::experiment {

struct Truth {
  io::ReferenceSpec spec;  ///< with what its protocol says, its frame by T_imu_reference
  Trajectory trajectory;   ///< of the IMU; of the reference point where positions_only. From `origin` on [m]
  bool positions_only = false;
  Vec3 point = Vec3::Zero();   ///< the reference point in the IMU frame where positions_only [m]
  Vec3 origin = Vec3::Zero();  ///< taken off the positions where they are far from their origin (UTM) [m]
  std::vector<std::string> notes, warnings;

  /// The estimated poses of the IMU as what the trajectory is to be compared with: those of the reference point.
  std::vector<StampedPose> comparable(std::span<const StampedPose> imu) const;
  /// The options of an evaluation against it: rule, gaps and scoring of the spec.
  evaluation::Options options() const;
};

/// Reads the reference and puts it into the IMU frame. `sensor`: its transforms name frames; may be null. Throws
/// DataError for the file, ConfigError for keys that do not fit it or name a frame that there is not.
Truth load_truth(const io::ReferenceSpec& spec, const io::SensorConfig* sensor = nullptr);

/// Errors of estimated poses of the IMU. Warnings of the reference stand before those of the evaluation.
evaluation::Evaluation evaluate_against(const Truth& truth, std::span<const StampedPose> imu,
                                        const evaluation::Options& options);

}  // namespace aslio::experiment
