#include "aslio/experiment/calibrated_sensor.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "aslio/config/diff.hpp"
#include "aslio/config/load.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/io/source.hpp"
#include "read_json.hpp"

namespace aslio::experiment {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

config::Loaded<io::SensorConfig> parse_sensor(const std::string& text, const std::string& source,
                                              const config::StageLookup& stages,
                                              const std::vector<config::Override>& overrides = {}) {
  return config::parse<io::SensorConfig>(text, source, config::FileKind::sensor, stages, overrides);
}

/// What the keys of the calibration are set to. Shortest decimals that read back to the same bits.
std::vector<config::Override> with_calibration(const Mat3& S, double delay) {
  std::string rows;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) rows += fmt::format("{}{}", rows.empty() ? "" : ", ", S(row, column));
  }
  return {{fmt::format("gyro_sensitivity=[{}]", rows)}, {fmt::format("imu_delay={}", delay)}};
}

const Json& member(const Json& json, const char* key) {
  static const Json none;
  const auto at = json.find(key);
  return at != json.end() ? *at : none;
}

/// Nine numbers, row by row; 0 for what is null. False when it is anything else.
bool read_matrix(const Json& json, Mat3& out) {
  if (!json.is_array() || json.size() != 9) return false;
  for (std::size_t i = 0; i < 9; ++i) {
    if (!json[i].is_number() && !json[i].is_null()) return false;
    const double value = json[i].is_number() ? json[i].get<double>() : 0.0;
    out(static_cast<Eigen::Index>(i / 3), static_cast<Eigen::Index>(i % 3)) = value;
  }
  return true;
}

Json read_whole(const fs::path& run, const char* name) {
  auto json = read_json(run / name);
  if (!json) {
    throw DataError(
        fmt::format("{}: cannot be read as JSON; name the folder of a run (`aslio run --output`, or one below `runs/` "
                    "of a study)",
                    (run / name).string()));
  }
  return std::move(*json);
}

/// A weighted mean of values that claim `sigma` each, those of 0 left out; all left out: their one value, sigma 0.
class Mean {
 public:
  void add(double value, double sigma) {
    if (sigma <= 0) {
      differ_ = differ_ || (fixed_ && *fixed_ != value);
      fixed_ = value;
      return;
    }
    const double w = 1.0 / (sigma * sigma);
    ++count_;
    weight_ += w;
    sum_ += w * value;
    squares_ += w * value * value;
  }
  /// `what`, in messages.
  Estimate<double> result(const char* what) const {
    if (count_ == 0 && differ_) {
      throw DataError(fmt::format("the runs hold a part of {} fixed, at different values of their sensor files", what));
    }
    if (count_ == 0) return {fixed_.value_or(0.0), 0.0};
    const double mean = sum_ / weight_;
    double widened = kClaimedTooWell;
    if (count_ > 1) {
      // Cancellation leaves rounding of either sign where all runs agree.
      const double chi2 = std::max(0.0, squares_ - weight_ * mean * mean);
      widened = std::max(widened, std::sqrt(chi2 / static_cast<double>(count_ - 1)));
    }
    return {mean, widened / std::sqrt(weight_)};
  }

 private:
  std::size_t count_ = 0;
  double weight_ = 0, sum_ = 0, squares_ = 0;
  std::optional<double> fixed_;
  bool differ_ = false;  ///< fixed ones do
};

/// Of another version of the program it may have keys that are not known.
io::SensorConfig sensor_of(const RunCalibration& run, const config::StageLookup& stages) {
  try {
    return parse_sensor(run.sensor_resolved, (run.run / "manifest.json").string() + " (sensor)", stages).value;
  } catch (const ConfigError& error) {
    throw DataError(error.what());
  }
}

void require_other_data(const std::vector<RunCalibration>& runs) {
  for (std::size_t i = 0; i < runs.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (runs[i].input_sha256.empty() || runs[i].input_sha256 != runs[j].input_sha256) continue;
      throw DataError(fmt::format("{} and {} are runs of the same recording, which would count twice: name one of them",
                                  runs[j].run.string(), runs[i].run.string()));
    }
  }
}

/// But for the calibration.
void require_same_sensor(const RunCalibration& a, const RunCalibration& b, const config::StageLookup& stages) {
  const auto bare = [&](const RunCalibration& run) {
    return parse_sensor(run.sensor_resolved, run.run.string(), stages, with_calibration(Mat3::Zero(), 0)).resolved;
  };
  const auto differences = config::diff(bare(a), bare(b));
  if (differences.empty()) return;
  throw DataError(fmt::format("{} and {} are not of one sensor; their sensor files differ in:\n{}", a.run.string(),
                              b.run.string(), config::to_text(differences)));
}

}  // namespace

// eq. MOT-11.
Mat3 compose_gyro_sensitivity(const Mat3& known, const Mat3& learnt) {
  const Mat3 I = Mat3::Identity();
  return (I + known) * (I - learnt).inverse() - I;
}

RunCalibration read_calibration(const fs::path& run, const config::StageLookup& stages) {
  const Json summary = read_whole(run, "summary.json"), manifest = read_whole(run, "manifest.json");
  const Json& status = member(summary, "status");
  if (status != "ok" && status != "degraded") {
    throw DataError(fmt::format("{}: the run ended {}: its calibration of the IMU is not reliable", run.string(),
                                status.is_string() ? status.get<std::string>() : "without a status"));
  }
  const Json& resolved = member(member(manifest, "sensor"), "resolved");
  if (!resolved.is_string()) {
    throw DataError(fmt::format("{}: no sensor file in it", (run / "manifest.json").string()));
  }
  RunCalibration out;
  out.run = run;
  out.sensor_resolved = resolved.get<std::string>();
  const Json& input = member(member(manifest, "input"), "sha256");
  if (input.is_string()) out.input_sha256 = input.get<std::string>();
  const io::SensorConfig sensor = sensor_of(out, stages);

  const Json& calibration = member(summary, "calibration");
  Mat3 learnt = Mat3::Zero();
  const bool S_learnt = read_matrix(member(calibration, "gyro_sensitivity"), learnt) &&
                        read_matrix(member(calibration, "gyro_sensitivity_sigma"), out.gyro_sensitivity.sigma);
  const Json &delay = member(calibration, "imu_delay_s"), &delay_sigma = member(calibration, "imu_delay_sigma_s");
  const bool delay_learnt = delay.is_number() && delay_sigma.is_number();
  if (!S_learnt && !delay_learnt) {
    throw DataError(
        fmt::format("{}: the run estimated no calibration of its IMU; set `estimator.gyro_calibration: full` and "
                    "`estimator.time_offset: true` (as in configs/pipelines/as_lio_plus.yaml), and let the sensor turn",
                    run.string()));
  }
  out.gyro_sensitivity.value =
      S_learnt ? compose_gyro_sensitivity(sensor.gyro_sensitivity, learnt) : sensor.gyro_sensitivity;
  if (!S_learnt) out.gyro_sensitivity.sigma.setZero();
  out.imu_delay = {sensor.imu_delay + (delay_learnt ? delay.get<double>() : 0.0),
                   delay_learnt ? delay_sigma.get<double>() : 0.0};
  return out;
}

SensorCalibration combine(const std::vector<RunCalibration>& runs, const config::StageLookup& stages) {
  require_other_data(runs);
  std::array<Mean, 9> S;
  Mean delay;
  for (const RunCalibration& run : runs) {
    require_same_sensor(runs.front(), run, stages);
    for (int i = 0; i < 9; ++i) {
      S[static_cast<std::size_t>(i)].add(run.gyro_sensitivity.value(i), run.gyro_sensitivity.sigma(i));
    }
    delay.add(run.imu_delay.value, run.imu_delay.sigma);
  }
  SensorCalibration out;
  for (int i = 0; i < 9; ++i) {
    const Estimate<double> entry = S[static_cast<std::size_t>(i)].result("gyro_sensitivity");
    out.gyro_sensitivity.value(i) = entry.value;
    out.gyro_sensitivity.sigma(i) = entry.sigma;
  }
  out.imu_delay = delay.result("imu_delay");
  const double largest = out.gyro_sensitivity.value.cwiseAbs().maxCoeff();
  if (largest > io::SensorConfig::kMaxSensitivity || std::abs(out.imu_delay.value) > io::SensorConfig::kMaxDelay) {
    throw DataError(
        fmt::format("the sensitivity of the gyro would be off by up to {:.3g} % and its delay {:.3g} s: no working "
                    "sensor has that. Check its units and the results of the runs",
                    100 * largest, out.imu_delay.value));
  }
  out.sensor_file = parse_sensor(runs.front().sensor_resolved, runs.front().run.string(), stages,
                                 with_calibration(out.gyro_sensitivity.value, out.imu_delay.value))
                        .resolved;
  return out;
}

}  // namespace aslio::experiment
