#pragma once
/// The sensor file of an IMU that runs have calibrated (docs/equations.md MOT-11).

#include <filesystem>
#include <string>
#include <vector>

#include "aslio/config/stage_lookup.hpp"
#include "aslio/experiment/calibration.hpp"

namespace aslio::experiment {

/// What one run says of its IMU: what its sensor file knew, and what it has learnt beyond that.
struct RunCalibration {
  std::filesystem::path run;
  std::string sensor_resolved;  ///< sensor file of the run, every key at its value
  std::string input_sha256;     ///< of its recording; empty where the manifest has none
  /// S of (I + S) w; sigma 0 of an entry: the run has held it fixed.
  Estimate<Mat3> gyro_sensitivity{Mat3::Zero(), Mat3::Zero()};
  Estimate<double> imu_delay{0, 0};  ///< [s]; sigma 0 likewise
};

/// S for which taking out `known` and then `learnt` is the same as taking out S: w = (I - learnt) (I + known)^-1 w_m.
Mat3 compose_gyro_sensitivity(const Mat3& known, const Mat3& learnt);

/// Of the folder of a run, by its summary.json and manifest.json. Throws DataError when there is none, when it did not
/// end well, or when it has learnt nothing of sensitivity and delay.
RunCalibration read_calibration(const std::filesystem::path& run, const config::StageLookup& stages);

/// Of what the turns of a walk show, runs claim to know the gyro's sensitivity two and a half to four times better than
/// they do (docs/decisions.md; of two walks with the data sheet's IMU five and seven times, docs/results.md).
inline constexpr double kClaimedTooWell = 4;

/// What several runs of one sensor say together: means of the runs' values, weighted by what they claim. sigma is what
/// the values may be taken to be good to: the claim of the mean times kClaimedTooWell or, where the runs differ by
/// more, times Birge's ratio.
struct SensorCalibration {
  Estimate<Mat3> gyro_sensitivity;
  Estimate<double> imu_delay;
  std::string sensor_file;  ///< that of the runs with these values, YAML
};

/// Throws DataError when two runs are of one recording, when sensor files differ in more than what is calibrated, when
/// all runs hold an entry fixed, but not at one value, or when the result is no error of a working sensor (0.2, 1 s).
/// Pre: at least one run.
SensorCalibration combine(const std::vector<RunCalibration>& runs, const config::StageLookup& stages);

}  // namespace aslio::experiment
