#include "faults/driver.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <sstream>

#include "aslio/core/errors.hpp"
#include "aslio/core/trajectory.hpp"
#include "aslio/evaluation/evaluation.hpp"
#include "aslio/experiment/measure.hpp"
#include "aslio/io/writers.hpp"

namespace aslio::test::faults {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using namespace io::rosbag;

/// x, y, z, intensity: float32; ring: uint16 and two bytes of padding; t: int32.
constexpr std::uint32_t kPointStep = 24;

/// When a recorder would have had each message: with its last point, and never before the one before.
class Arrivals {
 public:
  TimeNs of(const Measurement& m) {
    TimeNs t = stamp_of(m);
    if (const auto* packet = std::get_if<LidarPacket>(&m); packet != nullptr && !packet->points.empty()) {
      t = std::max(t, packet->points.back().t);
    }
    constexpr TimeNs kLongest = kSecond / 5, kUsual = kSecond / 250;
    // A stamp that is wild is no time at which anything arrived.
    if (last_ && (t < *last_ || t > *last_ + kLongest)) t = *last_ + (t < *last_ ? 0 : kUsual);
    last_ = t;
    return t;
  }

 private:
  std::optional<TimeNs> last_;
};

template <class T>
void put(std::uint8_t* to, T value) {
  std::memcpy(to, &value, sizeof value);
}

CloudLayout layout_of(std::size_t points, bool with_times) {
  CloudLayout layout;
  layout.width = static_cast<std::uint32_t>(points);
  layout.fields = {{"x", 0, 7, 1}, {"y", 4, 7, 1}, {"z", 8, 7, 1}, {"intensity", 12, 7, 1}, {"ring", 16, 4, 1}};
  if (with_times) layout.fields.push_back({"t", 20, 5, 1});
  layout.point_step = kPointStep;
  layout.row_step = kPointStep * layout.width;
  layout.is_dense = false;
  return layout;
}

std::vector<std::uint8_t> bytes_of(const LidarPacket& packet, double time_unit) {
  std::vector<std::uint8_t> data(packet.points.size() * kPointStep);
  std::uint8_t* to = data.data();
  for (const TimedPoint& p : packet.points) {
    put(to, p.x);
    put(to + 4, p.y);
    put(to + 8, p.z);
    put(to + 12, p.intensity);
    put(to + 16, std::uint16_t{p.line});
    // As a counter of 32 bits would: what does not fit comes round.
    const auto offset = std::llround(static_cast<double>(p.t - packet.stamp) / time_unit);
    put(to + 20, static_cast<std::uint32_t>(static_cast<std::uint64_t>(offset)));
    to += kPointStep;
  }
  return data;
}

std::string read_if_there(const fs::path& file) { return fs::exists(file) ? content(file) : std::string(); }

Ended start(const std::vector<std::string>& arguments, const fs::path& out, const How& how) {
  if (how.file_limit) return run_aslio_with_file_limit(arguments, *how.file_limit);
  if (how.during) return run_aslio(arguments, [&](pid_t child, const std::string&) { return how.during(child, out); });
  return run_aslio(arguments);
}

std::vector<std::string> cells(const std::string& line) {
  std::vector<std::string> out;
  std::istringstream stream(line);
  for (std::string cell; std::getline(stream, cell, ',');) out.push_back(cell);
  return out;
}

std::optional<double> ate_of(const fs::path& trajectory, const std::vector<StampedPose>& truth) {
  if (!fs::exists(trajectory) || truth.empty()) return std::nullopt;
  try {
    const Trajectory reference(truth);
    const auto options = experiment::measuring_options(reference, evaluation::Rule::interpolated);
    return evaluation::evaluate(Trajectory(io::read_tum(trajectory)), reference, options).ate.translation.rmse;
  } catch (const DataError&) {  // too few poses, or none of them within the truth's time
    return std::nullopt;
  }
}

void read_updates(const std::string& csv, Outcome& out) {
  std::istringstream stream(csv);
  std::string line;
  std::getline(stream, line);
  const std::vector<std::string> names = cells(line);
  while (std::getline(stream, line)) {
    std::vector<std::string> row = cells(line);
    row.resize(names.size());
    for (std::size_t i = 0; i < names.size(); ++i) out.updates[names[i]].push_back(row[i]);
  }
  for (const std::string& t : out.updates["t_ns"]) out.times.push_back(std::stoll(t));
  out.tracking = out.updates["tracking"];
}

}  // namespace

void write_bag(const fs::path& bag, const Measurements& data, const BagForm& form) {
  BagWriter writer(bag, form.options);
  const auto connect = [&](const std::string& topic, const MessageType& type) {
    return writer.add_connection(topic, std::string(type.name), std::string(type.md5), std::string(type.definition));
  };
  const std::uint32_t lidar = connect(form.lidar_topic, form.lidar_type), imu = connect(form.imu_topic, form.imu_type);
  Arrivals arrivals;
  std::vector<std::uint8_t> bytes;
  std::uint32_t packets = 0, samples = 0;
  for (const Measurement& m : data) {
    const TimeNs arrival = arrivals.of(m);
    if (const auto* sample = std::get_if<ImuSample>(&m)) {
      encode_imu({samples++, sample->t, "imu"}, form.gyro_factor * sample->gyro, form.acc_factor * sample->acc, bytes);
      writer.write(imu, arrival, bytes);
      continue;
    }
    const auto& packet = std::get<LidarPacket>(m);
    CloudLayout layout = layout_of(packet.points.size(), form.point_times);
    std::vector<std::uint8_t> points = bytes_of(packet, form.time_unit);
    if (form.edit) form.edit(layout, points, packets);
    encode_point_cloud2({packets++, packet.stamp, "lidar"}, layout, points, bytes);
    writer.write(lidar, arrival, bytes);
  }
  writer.close();
}

std::string sensor_text(const SensorModel& s, const std::vector<std::string>& lines) {
  const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> R = s.T_imu_lidar.R;
  const double *p = s.T_imu_lidar.p.data(), *r = R.data();
  std::vector<std::string> text = {"schema: aslio/sensor/1",
                                   fmt::format("T_imu_lidar: {{translation: [{}], rotation: [{}]}}",
                                               fmt::join(p, p + 3, ", "), fmt::join(r, r + 9, ", ")),
                                   fmt::format("scan_lines: {}", s.scan_lines),
                                   fmt::format("min_range: {}", s.min_range),
                                   fmt::format("max_range: {}", s.max_range),
                                   fmt::format("sweep_period: {}", s.sweep_period),
                                   fmt::format("gyro_noise: {}", s.gyro_noise),
                                   fmt::format("acc_noise: {}", s.acc_noise),
                                   fmt::format("gyro_bias_walk: {}", s.gyro_bias_walk),
                                   fmt::format("acc_bias_walk: {}", s.acc_bias_walk)};
  for (const std::string& line : lines) {
    const std::string key = line.substr(0, line.find(':') + 1);
    std::erase_if(text, [&](const std::string& other) { return other.starts_with(key); });
    text.push_back(line);
  }
  return fmt::format("{}\n", fmt::join(text, "\n"));
}

std::string Outcome::status() const {
  return summary.is_null() ? std::string() : summary.at("status").get<std::string>();
}

std::string Outcome::reason() const {
  return summary.is_null() ? std::string() : summary.at("reason").get<std::string>();
}

std::uint64_t Outcome::count(const std::string& name) const {
  if (summary.is_null() || !summary.at("counts").contains(name)) return 0;
  return summary.at("counts").at(name);
}

std::optional<TimeNs> Outcome::lost_at() const {
  if (summary.is_null() || summary.at("losses").empty()) return std::nullopt;
  return summary.at("losses").front().at("t_ns").get<TimeNs>();
}

std::optional<TimeNs> Outcome::first(const std::string& status, TimeNs t) const {
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (times[i] > t && tracking[i] == status) return times[i];
  }
  return std::nullopt;
}

Outcome run_over(const Measurements& data, const std::vector<StampedPose>& truth, const SensorModel& sensor,
                 const How& how) {
  const TemporaryFolder folder;
  const fs::path bag = folder / "recording.bag", out = how.output.empty() ? folder / "out" : how.output;
  write_bag(bag, data, how.form);
  if (how.damage) how.damage(bag);
  const bool shipped = how.pipeline.find('/') == std::string::npos;
  const std::string pipeline =
      shipped ? fmt::format("{}/configs/pipelines/{}.yaml", ASLIO_SOURCE_DIR, how.pipeline) : how.pipeline;
  std::vector<std::string> arguments = {
      "run",      pipeline,   "--input",
      bag,        "--sensor", folder.write("sensor.yaml", sensor_text(sensor, how.sensor_lines)),
      "--output", out,        "--quiet"};
  for (const std::string& assignment : how.set) arguments.insert(arguments.end(), {"--set", assignment});
  arguments.insert(arguments.end(), how.options.begin(), how.options.end());
  const Ended ended = start(arguments, out, how);
  Outcome outcome;
  outcome.exit_code = ended.code;
  outcome.err = ended.err;
  outcome.summary = Json::parse(read_if_there(out / "summary.json"), nullptr, false);
  if (outcome.summary.is_discarded()) outcome.summary = nullptr;
  outcome.trajectory = read_if_there(out / "trajectory.tum");
  outcome.ate = ate_of(out / "trajectory.tum", truth);
  read_updates(read_if_there(out / "updates.csv"), outcome);
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(out, none)) outcome.files.push_back(entry.path().filename());
  std::sort(outcome.files.begin(), outcome.files.end());
  return outcome;
}

Outcome run_with(const Fault& fault, const How& how) {
  const Walk& walk = clean_walk();
  return run_over(altered(walk.data, fault), walk.truth, walk.sensor, how);
}

}  // namespace aslio::test::faults
