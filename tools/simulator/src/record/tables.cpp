#include "record/tables.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

namespace aslio::simulator {
namespace {

/// Seconds with all nanoseconds, as in TUM files.
std::string seconds(TimeNs t) { return fmt::format("{}.{:09}", t / kSecond, t % kSecond); }

/// Bias at `t`, interpolated between the IMU samples about it.
Vec3 bias_at(const std::vector<ImuSample>& samples, const std::vector<Vec3>& bias, TimeNs t) {
  const auto after = std::upper_bound(samples.begin(), samples.end(), t,
                                      [](TimeNs time, const ImuSample& sample) { return time < sample.t; });
  if (after == samples.begin()) return bias.front();
  const auto k = static_cast<std::size_t>(after - samples.begin());
  if (k == samples.size()) return bias.back();
  const double share = static_cast<double>(t - samples[k - 1].t) / static_cast<double>(samples[k].t - samples[k - 1].t);
  return bias[k - 1] + share * (bias[k] - bias[k - 1]);
}

/// Text as a YAML scalar in double quotes. Control characters are escaped as scene.yaml has them: a configuration that
/// holds one is refused.
std::string yaml_text(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') out += '\\';
    if (byte < 0x20 || byte == 0x7f) {
      fmt::format_to(std::back_inserter(out), "\\x{:02x}", static_cast<unsigned>(byte));
    } else {
      out += c;
    }
  }
  return out + '"';
}

std::string numbers(const double* values, int count) {
  return fmt::format("{}", fmt::join(values, values + count, ", "));
}

std::string absolute(const SceneFile& scene, const std::string& file) {
  return std::filesystem::absolute(scene.path.parent_path() / file).lexically_normal().string();
}

}  // namespace

void write_truth_table(const Simulation& simulation, const std::filesystem::path& path) {
  io::AtomicFile file(path);
  file.write(
      "t,px,py,pz,vx,vy,vz,qx,qy,qz,qw,wx,wy,wz,gyro_bias_x,gyro_bias_y,gyro_bias_z,acc_bias_x,acc_bias_y,"
      "acc_bias_z\n");
  const ImuRecord& imu = simulation.imu();
  std::string line;
  const Trajectory truth = simulation.truth();
  for (const StampedPose& stamped : truth.samples()) {
    const MotionState m = simulation.motion().at(to_seconds(stamped.t - simulation.begin_time()));
    Eigen::Quaterniond q(m.R);
    if (q.w() < 0) q.coeffs() = -q.coeffs();
    line = seconds(stamped.t);
    const auto add = [&](const auto& values) {
      for (Eigen::Index k = 0; k < values.size(); ++k)
        fmt::format_to(std::back_inserter(line), ",{:.9g}", values[k] + 0.0);  // + 0.0: no "-0"
    };
    add(m.p);
    add(m.v);
    add(q.coeffs());
    add(m.w);
    add(bias_at(imu.samples, imu.gyro_bias, stamped.t));
    add(bias_at(imu.samples, imu.acc_bias, stamped.t));
    line += '\n';
    file.write(line);
  }
  file.close();
}

OverlapTable::OverlapTable(const std::filesystem::path& path) : file_(path) {
  file_.write("t,static_rays,true_overlap,people_rays\n");
}

void OverlapTable::add(const CellBlock& block, TimeNs end) {
  const auto known = std::count_if(block.cells.begin(), block.cells.end(),
                                   [this](std::uint64_t cell) { return seen_.contains(cell); });
  for (const std::uint64_t cell : block.cells) seen_.insert(cell);
  const double share = block.cells.empty() ? std::numeric_limits<double>::quiet_NaN()
                                           : static_cast<double>(known) / static_cast<double>(block.cells.size());
  file_.write(fmt::format("{},{},{:.6f},{}\n", seconds(end), block.cells.size(), share, block.people_rays));
}

std::string sensor_file(const Simulation& simulation) {
  const SensorFacts& f = facts(simulation.sensor_kind());
  const SensorModel& s = simulation.claimed_sensor();
  const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> R = s.T_imu_lidar.R;
  const bool livox = simulation.pattern().message() == LidarMessage::livox_custom;
  return fmt::format(
      "# Simulated {}.\n"
      "schema: aslio/sensor/1\n"
      "lidar_topic: {}\n"
      "imu_topic: {}\n"
      "acc_unit: {}\n"
      "gyro_unit: rad_s\n"
      "T_imu_lidar:\n"
      "  translation: [{}]\n"
      "  rotation: [{}]\n"
      "scan_lines: {}\n"
      "min_range: {}\n"
      "max_range: {}\n"
      "sweep_period: {}\n"
      "gyro_noise: {}\n"
      "acc_noise: {}\n"
      "gyro_bias_walk: {}\n"
      "acc_bias_walk: {}\n",
      f.name, f.lidar_topic, f.imu_topic, livox ? "g" : "mps2", numbers(s.T_imu_lidar.p.data(), 3),
      numbers(R.data(), 9), s.scan_lines, s.min_range, s.max_range, s.sweep_period, s.gyro_noise, s.acc_noise,
      s.gyro_bias_walk, s.acc_bias_walk);
}

std::string scene_file(const Simulation& simulation, const SceneFile& scene) {
  std::vector<std::string> effective = {fmt::format("sensor={}", facts(simulation.sensor_kind()).name)};
  if (!scene.scene.follow.file.empty())
    effective.push_back("follow.file=" + yaml_text(absolute(scene, scene.scene.follow.file)));
  if (scene.scene.world.type == WorldKind::mesh)
    effective.push_back("world.file=" + yaml_text(absolute(scene, scene.scene.world.mesh.file)));
  const SimulationOptions& options = simulation.options();
  return fmt::format("# simulated with --seed {} --scale {}\n{}", options.seed, options.scale,
                     with_overrides(scene, effective).resolved);
}

std::string dataset_file(const Simulation& simulation, const std::string& name, const std::string& input) {
  const MotionState begin = simulation.motion().at(0), end = simulation.motion().at(simulation.duration());
  const bool closed = (begin.p - end.p).norm() < 1e-3 && log_so3(begin.R.transpose() * end.R).norm() < 1.75e-3;
  return fmt::format(
      "schema: aslio/dataset/1\n"
      "name: {}\n"
      "description: {}\n"
      "input: {}\n"
      "sensor: sensor.yaml\n"
      "reference: truth.tum\n"
      "closed_loop: {}\n",
      yaml_text(name), yaml_text(simulation.scene().description), yaml_text(input), closed);
}

}  // namespace aslio::simulator
