#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>

#include "aslio/core/errors.hpp"
#include "aslio/experiment/calibrated_sensor.hpp"
#include "aslio/io/writers.hpp"
#include "aslio/toolkit/initial_covariance.hpp"
#include "command.hpp"
#include "console.hpp"
#include "stages.hpp"

namespace aslio::cli {

namespace {

namespace fs = std::filesystem;
using experiment::SensorCalibration;

constexpr const char* kFirstLine = "# Written by `aslio calibrate`";

struct CalibrateArguments {
  std::vector<std::string> runs;
  std::string output;
};

/// A sensor file that somebody wrote has remarks of its own, which a written one loses.
void refuse_to_overwrite(const std::string& output) {
  std::error_code ignored;
  if (!fs::exists(output, ignored)) return;
  std::ifstream file(output);
  std::string line;
  if (fs::is_regular_file(output, ignored) && std::getline(file, line) && line.starts_with(kFirstLine)) return;
  throw ConfigError(fmt::format("--output {}: exists and was not written by this command; name a new file", output));
}

/// Rounded up to one digit.
double rounded_up(double x) {
  const double unit = std::pow(10.0, std::floor(std::log10(x)));
  return std::ceil(x / unit - 1e-9) * unit;
}

/// What a run is told of how well the values are known: no worse than estimators take for granted of any IMU.
struct Priors {
  Mat3 gyro_sensitivity;
  double imu_delay;
};

Priors priors_of(const SensorCalibration& c) {
  const aslio::EstimatedStates usual;
  const auto prior = [](double sigma, double most) { return sigma > 0 ? std::min(most, rounded_up(sigma)) : most; };
  Priors out;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      const double most = row == column ? usual.sigma_gyro_scale : usual.sigma_gyro_cross;
      out.gyro_sensitivity(row, column) = prior(c.gyro_sensitivity.sigma(row, column), most);
    }
  }
  out.imu_delay = prior(c.imu_delay.sigma, usual.sigma_time_offset);
  return out;
}

/// Options of a run for an estimator that goes on to estimate them.
std::string prior_options(const Priors& priors) {
  const Mat3 rows = priors.gyro_sensitivity.transpose();  // stored by columns
  return fmt::format(" --set 'estimator.sigma_gyro_sensitivity=[{:g}]' --set estimator.sigma_time_offset={:g}",
                     fmt::join(rows.data(), rows.data() + rows.size(), ","), priors.imu_delay);
}

std::string calibration_report(const SensorCalibration& c, std::size_t runs, const std::string& output) {
  const Priors priors = priors_of(c);
  const auto known = [](double value, double sigma) { return fmt::format("{:+9.3f} +- {:5.3f}", value, sigma); };
  std::string text = fmt::format("of {} run{}, and what it is taken to be good to\n", runs, runs == 1 ? "" : "s");
  for (int row = 0; row < 3; ++row) {
    text += row == 0 ? "gyro sensitivity [%]" : "                    ";
    for (int column = 0; column < 3; ++column) {
      text += known(100 * c.gyro_sensitivity.value(row, column), 100 * priors.gyro_sensitivity(row, column));
    }
    text += '\n';
  }
  text += fmt::format("IMU delay [ms]      {}\n", known(1000 * c.imu_delay.value, 1000 * priors.imu_delay));
  text += fmt::format("written             {}\n", output);
  return text + fmt::format("use                 --sensor {}{}\n", output, prior_options(priors));
}

int calibrate(const CalibrateArguments& a) {
  refuse_to_overwrite(a.output);
  const Stages stages = load_stages({});
  std::vector<experiment::RunCalibration> runs;
  for (const std::string& run : a.runs) runs.push_back(experiment::read_calibration(run, stages.catalog));
  const SensorCalibration c = experiment::combine(runs, stages.catalog);

  io::AtomicFile file(a.output);
  file.write(fmt::format("{} from {} run{}; known so well that a run is served by\n#{}\n", kFirstLine, runs.size(),
                         runs.size() == 1 ? "" : "s", prior_options(priors_of(c))));
  file.write(c.sensor_file);
  file.close();
  print(calibration_report(c, runs.size(), a.output));
  return kSuccess;
}

}  // namespace

Command add_calibrate(CLI::App& root) {
  CLI::App* app = root.add_subcommand(
      "calibrate",
      "Writes a sensor file with the gyro's sensitivity and the delay of the IMU that runs have estimated.");
  auto arguments = std::make_shared<CalibrateArguments>();
  app->add_option("RUN", arguments->runs, "folders of runs with one sensor and its current calibration")->required();
  app->add_option("--output", arguments->output, "sensor file to write; one that this command wrote is replaced")
      ->required();
  app->footer(
      "Use several walks: each calibrates only the axes it turns about. Example:\n"
      "  aslio run configs/pipelines/as_lio_plus.yaml --input walk_1.bag --sensor mine.yaml --output out/walk_1\n"
      "  aslio run configs/pipelines/as_lio_plus.yaml --input walk_2.bag --sensor mine.yaml --output out/walk_2\n"
      "  aslio calibrate out/walk_1 out/walk_2 --output mine_calibrated.yaml");
  return {app, [=] { return calibrate(*arguments); }};
}

}  // namespace aslio::cli
