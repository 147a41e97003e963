#include "layouts/written.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <fstream>
#include <sstream>

#include "aslio/core/sha256.hpp"

namespace aslio::test {

namespace fs = std::filesystem;
using simulator::SensorKind;
using simulator::Simulation;

namespace {

simulator::SimulationOptions options_of(SensorKind sensor, double duration) {
  simulator::SimulationOptions options;
  options.sensor = sensor;
  options.duration = duration;
  return options;
}

template <class T>
void add(std::string& text, const T& value) {
  text.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

}  // namespace

Walk::Walk(SensorKind sensor, double duration)
    : scene(simulator::test::room(folder, "lidar: {columns: 400}\nimu: {preset: ideal, rate: 100}\n")),
      simulation(scene, options_of(sensor, duration)) {
  for (std::size_t i = 0; i < simulation.packet_count(); ++i) packets.push_back(simulation.packet(i).packet);
}

const Walk& spinning_walk() {
  static const Walk walk(SensorKind::spin16);
  return walk;
}

const Walk& livox_walk() {
  static const Walk walk(SensorKind::avia);
  return walk;
}

Written::Written(const Walk& walk, const io::Layout& layout, double sweep_period) {
  simulator::RecordOptions options{folder / "beside", 1, true, "walk"};
  options.layout = simulator::RecordLayout{layout, folder / "data", "walk", sweep_period};
  REQUIRE(simulator::record(walk.simulation, walk.scene, options, nullptr, result));
}

io::SensorConfig sensor_of(const Walk& walk, const io::Layout& layout) {
  io::SensorConfig sensor;
  sensor.from_file = true;
  sensor.lidar_topic = layout.of_messages() ? layout.lidar.topic : "";
  sensor.imu_topic = layout.of_messages() ? layout.imu.topic : "";
  sensor.acc_unit = layout.imu.acc_unit;
  sensor.gyro_unit = layout.imu.gyro_unit;
  sensor.model = walk.simulation.claimed_sensor();
  return sensor;
}

Recording read(const std::vector<fs::path>& inputs, const io::SensorConfig& sensor) {
  const auto source = io::open_source(inputs, sensor);
  Recording recording = record(*source);
  for (const std::string& warning : source->notes().warnings) FAIL_CHECK(warning);
  CHECK(source->status() == io::InputStatus::complete);
  return recording;
}

std::string digest(const Recording& recording) {
  std::string lidar, imu;
  for (const Measurement& measurement : recording) {
    if (const auto* sample = std::get_if<ImuSample>(&measurement)) {
      add(imu, sample->t);
      for (int i = 0; i < 3; ++i) add(imu, sample->gyro[i]);
      for (int i = 0; i < 3; ++i) add(imu, sample->acc[i]);
      continue;
    }
    for (const TimedPoint& p : std::get<LidarPacket>(measurement).points) {
      add(lidar, p.t);
      for (const float value : {p.x, p.y, p.z, p.intensity}) add(lidar, value);
      add(lidar, p.line);
    }
  }
  return sha256_of(lidar + imu);
}

Recording simulated(const Walk& walk) {
  Recording recording;
  std::size_t next = 0;
  const auto until = [&](TimeNs t) {
    for (; next < walk.imu().size() && walk.imu()[next].t <= t; ++next) recording.emplace_back(walk.imu()[next]);
  };
  for (const LidarPacket& packet : walk.packets) {
    until(std::min(packet.stamp + Simulation::kPacketPeriod, walk.simulation.end_time()));
    recording.emplace_back(packet);
  }
  until(kTimeMax);
  return recording;
}

Split split(const Recording& recording) {
  Split out;
  for (const Measurement& measurement : recording) {
    if (const auto* packet = std::get_if<LidarPacket>(&measurement)) {
      out.packets.push_back(*packet);
    } else {
      out.imu.push_back(std::get<ImuSample>(measurement));
    }
  }
  return out;
}

std::vector<TimedPoint> sorted(std::vector<TimedPoint> points) {
  std::sort(points.begin(), points.end(),
            [](const TimedPoint& a, const TimedPoint& b) { return a.t != b.t ? a.t < b.t : a.line < b.line; });
  return points;
}

std::string text_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

std::vector<std::string> lines(const fs::path& file) {
  std::istringstream text(text_of(file));
  std::vector<std::string> all;
  for (std::string line; std::getline(text, line);) all.push_back(line);
  return all;
}

std::vector<std::string> names_below(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) names.push_back(entry.path().lexically_relative(folder).string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

PlainCloud take_apart(std::span<const std::uint8_t> message) {
  PlainCloud cloud;
  std::size_t next = 4;  // seq
  const auto number = [&] {
    next += 4;
    return at<std::uint32_t>(message, next - 4);
  };
  const auto text = [&] {
    const std::size_t size = number();
    next += size;
    return std::string(reinterpret_cast<const char*>(message.data()) + next - size, size);
  };
  cloud.stamp = TimeNs{number()} * kSecond;
  cloud.stamp += number();
  cloud.frame = text();
  cloud.height = number();
  cloud.width = number();
  const std::uint32_t fields = number();
  for (std::uint32_t i = 0; i < fields; ++i) {
    PlainCloud::Field field;
    field.name = text();
    field.offset = number();
    field.datatype = message[next++];
    REQUIRE(number() == 1);
    cloud.fields.push_back(field);
  }
  REQUIRE(message[next++] == 0);  // little-endian
  cloud.point_step = number();
  cloud.row_step = number();
  const std::uint32_t bytes = number();
  REQUIRE(next + bytes + 1 == message.size());
  cloud.data.assign(message.begin() + static_cast<std::ptrdiff_t>(next), message.end() - 1);
  cloud.dense = message.back() == 1;
  return cloud;
}

FirstMessage first_on(const fs::path& file, const std::string& topic) {
  const auto reader = io::open_messages(file);
  for (const io::Connection& connection : reader->connections()) {
    if (connection.topic != topic) continue;
    reader->select(std::span(&connection.id, 1));
    io::RawMessage message;
    REQUIRE(reader->next(message));
    return {connection, message.time, {message.bytes.begin(), message.bytes.end()}};
  }
  FAIL("there is no topic " << topic << " in " << file);
  return {};
}

}  // namespace aslio::test
