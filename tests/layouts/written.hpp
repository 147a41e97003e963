#pragma once
/// A short walk in a bare room, written in a layout and read again.

#include <string>
#include <vector>

#include "aslio/io/message_reader.hpp"
#include "aslio/io/source.hpp"
#include "aslio/simulator/record.hpp"
#include "pipeline/runs.hpp"
#include "simulator/box_room.hpp"

namespace aslio::test {

struct Walk {
  TemporaryFolder folder;
  simulator::SceneFile scene;
  simulator::Simulation simulation;
  std::vector<LidarPacket> packets;  ///< as simulated

  explicit Walk(simulator::SensorKind sensor, double duration = 1.0);
  const std::vector<ImuSample>& imu() const { return simulation.imu().samples; }
};

/// One for all cases of a test: simulated once.
const Walk& spinning_walk();
const Walk& livox_walk();

struct Written {
  TemporaryFolder folder;
  simulator::RecordResult result;

  Written(const Walk& walk, const io::Layout& layout, double sweep_period = 0.1);
  std::filesystem::path operator/(const std::string& name) const { return folder / ("data/" + name); }
};

/// What a sensor file would say of a layout: topics, units and lines.
io::SensorConfig sensor_of(const Walk& walk, const io::Layout& layout);

/// Everything that is read; fails the test where the source has warnings.
Recording read(const std::vector<std::filesystem::path>& inputs, const io::SensorConfig& sensor);

/// Hash of all that measurements tell: times, points with line and intensity, then angular rates and accelerations. Of
/// messages of one time, files by topic may give either first.
std::string digest(const Recording& recording);
/// The same of what was simulated, in the order of arrival.
Recording simulated(const Walk& walk);

struct Split {
  std::vector<LidarPacket> packets;
  std::vector<ImuSample> imu;
};
Split split(const Recording& recording);

/// Points by line and time.
std::vector<TimedPoint> sorted(std::vector<TimedPoint> points);

/// Bytes of a file.
std::string text_of(const std::filesystem::path& file);
/// Lines of a text file.
std::vector<std::string> lines(const std::filesystem::path& file);
/// Paths below a folder, sorted, as text.
std::vector<std::string> names_below(const std::filesystem::path& folder);

/// A number as it lies in memory.
template <class T>
T at(std::span<const std::uint8_t> bytes, std::size_t offset) {
  T value{};
  if (offset + sizeof(T) <= bytes.size()) std::memcpy(&value, bytes.data() + offset, sizeof(T));
  return value;
}

/// A PointCloud2 in ROS1 serialisation, taken apart by the definition of the message alone.
struct PlainCloud {
  TimeNs stamp = 0;
  std::string frame;
  std::uint32_t height = 0, width = 0, point_step = 0, row_step = 0;
  struct Field {
    std::string name;
    std::uint32_t offset = 0;
    int datatype = 0;
    bool operator==(const Field&) const = default;
  };
  std::vector<Field> fields;
  std::vector<std::uint8_t> data;
  bool dense = false;
};
PlainCloud take_apart(std::span<const std::uint8_t> message);

/// The first message on a topic, and its connection.
struct FirstMessage {
  io::Connection connection;
  TimeNs time = 0;
  std::vector<std::uint8_t> bytes;
};
FirstMessage first_on(const std::filesystem::path& file, const std::string& topic);

}  // namespace aslio::test
