#include "stand_in.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <system_error>

#include "aslio/core/errors.hpp"
#include "aslio/experiment/family.hpp"
#include "aslio/experiment/stand_in.hpp"
#include "aslio/io/writers.hpp"
#include "data_folder.hpp"

namespace aslio::cli {
namespace {

namespace fs = std::filesystem;
using simulator::SensorKind;

constexpr const char* kNote = "SIMULATED.md";
constexpr const char* kMark = "The data in this folder are simulated.";
constexpr double kDuration = 60;  ///< [s]

/// The simulated sensor nearest to that of the family.
SensorKind sensor_for(const experiment::StandIn& stand_in) {
  const int lines = stand_in.sensor.model.scan_lines;
  switch (stand_in.layout.lidar.form) {
    case io::LidarForm::livox:
    case io::LidarForm::livox2:
    case io::LidarForm::livox_cloud:
      return lines == 4 ? SensorKind::mid360 : SensorKind::avia;
    case io::LidarForm::velodyne_packets:
      return SensorKind::vlp16;
    default:
      return lines <= 24 ? SensorKind::spin16 : lines <= 48 ? SensorKind::spin32 : SensorKind::spin64;
  }
}

bool spins(SensorKind kind) {
  return kind != SensorKind::avia && kind != SensorKind::mid360 && kind != SensorKind::mid40;
}

/// IMU, ranges and columns of the sensor file, as keys of a scene.
std::vector<std::string> scene_keys(const experiment::StandIn& stand_in, SensorKind kind) {
  const SensorModel& m = stand_in.sensor.model;
  std::vector<std::string> keys = {fmt::format("imu.rate={}", stand_in.layout.imu.rate),
                                   fmt::format("lidar.min_range={}", m.min_range),
                                   fmt::format("lidar.max_range={}", m.max_range)};
  if (stand_in.sensor_noise) {
    keys.insert(
        keys.end(),
        {fmt::format("imu.gyro_noise={}", m.gyro_noise), fmt::format("imu.acc_noise={}", m.acc_noise),
         fmt::format("imu.gyro_bias_walk={}", m.gyro_bias_walk), fmt::format("imu.acc_bias_walk={}", m.acc_bias_walk)});
  }
  if (spins(kind) && kind != SensorKind::vlp16) keys.push_back(fmt::format("lidar.columns={}", stand_in.columns));
  return keys;
}

/// Messages in a packet of the simulator.
double sweep_period_for(const experiment::StandIn& stand_in) {
  const double packet = to_seconds(simulator::Simulation::kPacketPeriod);
  return packet / std::max(1.0, std::round(packet / stand_in.sensor.model.sweep_period));
}

/// How the data differ from the published ones, for people.
std::vector<std::string> differences_of(const StandInPlan& plan, const simulator::Simulation& simulation) {
  const simulator::ScanPattern& pattern = simulation.pattern();
  const SensorKind kind = simulation.sensor_kind();
  std::vector<std::string> all;
  all.push_back(fmt::format("Place, motion and measurements are those of a simulated scene with a sensor {}.",
                            simulator::facts(kind).name));
  if (spins(kind)) {
    const auto lines = static_cast<int>(pattern.beams_per_firing());
    if (lines != plan.published_lines) {
      all.push_back(fmt::format("The LiDAR has {} lines in place of {}.", lines, plan.published_lines));
    }
    const auto columns = std::llround(plan.layout.sweep_period * 1e9 / static_cast<double>(pattern.firing_period()));
    if (columns != plan.published_columns) {
      all.push_back(fmt::format("A sweep has {} columns in place of {}.", columns, plan.published_columns));
    }
  }
  if (plan.layout.sweep_period < to_seconds(simulator::Simulation::kPacketPeriod)) {
    all.push_back(
        fmt::format("The head turns at 10 Hz: a sweep of {} s is a part of a turn.", plan.layout.sweep_period));
  }
  return all;
}

/// Published and simulated data in one folder could be taken for one another.
void require_own_folder(const fs::path& output, const fs::path& beside, const std::string& sequence) {
  std::error_code ignored;
  if (!fs::exists(output, ignored)) return;
  if (fs::exists(beside, ignored)) {
    throw ConfigError(
        fmt::format("--output {}: holds a simulated {} already; remove {} and its data, or name another "
                    "folder",
                    output.string(), sequence, beside.string()));
  }
  const bool empty = fs::is_directory(output, ignored) && fs::is_empty(output, ignored);
  if (empty || fs::exists(output / kNote, ignored)) return;
  throw ConfigError(
      fmt::format("--output {}: is not empty and not a folder of simulated data; name another one, so that published "
                  "and simulated data are not mixed",
                  output.string()));
}

}  // namespace

StandInPlan plan_stand_in(const SimulateArguments& a) {
  const auto name = experiment::parse_family_name(a.as);
  if (!name) throw ConfigError(fmt::format("--as {}: give FAMILY/SEQUENCE, newer_college_2021/quad_easy, say", a.as));
  if (!a.sensor.empty()) {
    throw ConfigError("--sensor: the family says which sensor is simulated; leave it out, or simulate without --as");
  }
  const experiment::Family family =
      experiment::load_family(experiment::find_family(name->family, data_path("configs") / "datasets"));
  const experiment::FamilySequence& sequence = experiment::find_sequence(family, name->sequence);
  const experiment::StandIn stand_in = experiment::stand_in_of(family, sequence);
  StandInPlan plan;
  plan.family = family.name;
  plan.sequence = sequence.name;
  plan.title = family.config.title;
  plan.url = family.config.url;
  plan.beside = fs::path(a.output) / "simulated" / sequence.name;
  require_own_folder(a.output, plan.beside, sequence.name);
  const SensorKind kind = sensor_for(stand_in);
  plan.overrides = scene_keys(stand_in, kind);
  plan.simulation.seed = a.seed;
  plan.simulation.scale = a.scale;
  plan.simulation.sensor = kind;
  plan.simulation.begin = to_ns(stand_in.layout.begin);
  plan.simulation.duration = a.duration.value_or(sequence.section.start + kDuration);
  plan.simulation.T_imu_lidar = stand_in.sensor.model.T_imu_lidar;
  const double sweep_period = sweep_period_for(stand_in);
  plan.layout = {stand_in.layout, a.output, sequence.name, sweep_period, stand_in.sensor.model.scan_lines};
  plan.published_lines = stand_in.sensor.model.scan_lines;
  plan.published_columns = stand_in.published_columns;
  return plan;
}

void write_stand_in_note(const StandInPlan& plan, const simulator::Simulation& simulation, const fs::path& output) {
  std::string text = fmt::format(
      "# Simulated data\n\n{} They are not the published ones.\n\n"
      "`aslio simulate --as` wrote them in the layout of {} ({}).\n"
      "They are for tests of programs and configurations. Results on them say nothing about the published data.\n\n",
      kMark, plan.title, plan.url);
  for (const std::string& difference : differences_of(plan, simulation)) text += fmt::format("- {}\n", difference);
  text +=
      "\nThe folder `simulated` has, for each sequence, the scene (`scene.yaml`), the truth (`truth.tum`, "
      "`truth.csv`), "
      "`overlap.csv` and `preview.svg`.\n";
  io::AtomicFile file(output / kNote);
  file.write(text);
  file.close();
}

std::string stand_in_report(const StandInPlan& plan, const simulator::Simulation& simulation,
                            const simulator::RecordResult& r, const fs::path& output) {
  std::string text = fmt::format("SIMULATED    these are not the published data of {} ({})\n", plan.title, plan.url);
  const auto out = std::back_inserter(text);
  for (const std::string& difference : differences_of(plan, simulation))
    fmt::format_to(out, "             {}\n", difference);
  fmt::format_to(out, "duration     {:.2f} s, path {:.2f} m\n", r.data_s, r.path_length_m);
  fmt::format_to(out, "messages     {} of the LiDAR, {} of the IMU\n", r.packets, r.imu_samples);
  constexpr std::size_t kMostFiles = 8;
  std::vector<std::string> files;
  for (const fs::path& file : r.files) files.push_back(file.string());
  const std::size_t more = files.size() - std::min(files.size(), kMostFiles);
  files.resize(files.size() - more);
  fmt::format_to(out, "output       {}: {}{}\n", output.string(), fmt::join(files, ", "),
                 more == 0 ? "" : fmt::format(" and {} more", more));
  fmt::format_to(out, "truth        {}: truth.tum, truth.csv, overlap.csv, scene.yaml, preview.svg\n",
                 plan.beside.string());
  fmt::format_to(out,
                 "run it       aslio run configs/pipelines/as_lio_plus.yaml --dataset {}/{} --data {} --output OUT\n",
                 plan.family, plan.sequence, output.string());
  return text;
}

}  // namespace aslio::cli
