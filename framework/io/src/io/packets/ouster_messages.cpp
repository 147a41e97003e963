#include "ouster_messages.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "../decode/wire.hpp"
#include "../lidar_decoder.hpp"
#include "aslio/core/errors.hpp"
#include "imu_message.hpp"
#include "ouster.hpp"
#include "pcap_reader.hpp"
#include "sweep_message.hpp"
#include "sweep_splitter.hpp"

namespace aslio::io::packets {
namespace {

bool is_packet_message(const Connection& connection) {
  return connection.encoding != Encoding::other && connection.type.starts_with("ouster") &&
         connection.type.ends_with("/PacketMsg");
}

bool is_text(const Connection& connection) {
  return connection.encoding != Encoding::other && connection.type.starts_with("std_msgs/") &&
         connection.type.ends_with("/String");
}

/// `uint8[] buf`; empty for a message that is cut off.
Bytes packet_of(const RawMessage& message) {
  decode::Wire wire(message);
  const std::uint32_t size = wire.get<std::uint32_t>();
  const Bytes bytes = wire.take(size);
  return wire.ok() ? bytes : Bytes{};
}

/// Length of the begin that two topics share: those of one sensor share their namespace.
std::size_t alike(const std::string& a, const std::string& b) {
  const auto [end, other] = std::mismatch(a.begin(), a.end(), b.begin(), b.end());
  return static_cast<std::size_t>(end - a.begin());
}

/// One sensor: its packets set one clock.
struct Sensor {
  std::string where, json;
  OusterMetadata metadata;
  std::unique_ptr<PacketFormat> format;
  SensorClock clock{0};

  Sensor(std::string name, std::string text)
      : where(std::move(name)),
        json(std::move(text)),
        metadata(parse_ouster_metadata(where, json)),
        format(make_ouster(metadata)) {}
};

/// A topic of packets.
struct PacketTopic {
  Sensor* sensor = nullptr;
  bool imu = false;
  std::optional<SweepSplitter> splitter;  ///< of a LiDAR
};

class OusterReader final : public MessageReader {
 public:
  OusterReader(std::unique_ptr<MessageReader> inner, std::vector<std::unique_ptr<Sensor>> sensors)
      : inner_(std::move(inner)), sensors_(std::move(sensors)), connections_(inner_->connections()) {
    for (Connection& connection : connections_) {
      selected_.push_back(connection.id);
      if (is_packet_message(connection)) take_over(connection);
    }
    select(std::vector<std::uint32_t>(selected_));
  }

  std::string kind() const override { return inner_->kind(); }
  const std::vector<Connection>& connections() const override { return connections_; }
  std::optional<TimeNs> begin_time() const override { return inner_->begin_time(); }
  std::optional<TimeNs> end_time() const override { return inner_->end_time(); }
  InputStatus status() const override { return inner_->status(); }
  const std::vector<std::string>& warnings() const override { return inner_->warnings(); }

  /// All packets of a sensor set its clock, so that times do not depend on what is selected.
  void select(std::span<const std::uint32_t> ids) override {
    selected_.assign(ids.begin(), ids.end());
    std::vector<std::uint32_t> all = selected_;
    const bool packets =
        std::any_of(all.begin(), all.end(), [this](std::uint32_t id) { return topic_of_.contains(id); });
    for (const auto& [id, topic] : topic_of_) {
      if (packets && !is_selected(id)) all.push_back(id);
    }
    inner_->select(all);
    for (const auto& sensor : sensors_) sensor->clock = SensorClock(0);
    for (auto& [name, topic] : topics_) {
      if (!topic.imu) topic.splitter.emplace(*topic.sensor->format);
    }
    flushed_ = false;
  }

  bool next(RawMessage& message) override {
    while (!flushed_ && inner_->next(message)) {
      last_time_ = message.time;
      const auto at = topic_of_.find(message.connection);
      if (at == topic_of_.end()) return true;
      if (unpack(*at->second, message) && is_selected(message.connection)) return true;
    }
    flushed_ = true;
    for (const auto& [id, topic] : topic_of_) {
      if (topic->imu || !topic->splitter->flush() || !is_selected(id)) continue;
      message.connection = id;
      message.time = last_time_;
      message.bytes = topic->splitter->message();
      message.encoding = Encoding::ros1;
      return true;
    }
    return false;
  }

 private:
  bool is_selected(std::uint32_t id) const {
    return std::find(selected_.begin(), selected_.end(), id) != selected_.end();
  }

  /// What its packets are tells their length, by the first of them.
  void take_over(Connection& connection) {
    Sensor& sensor = **std::max_element(sensors_.begin(), sensors_.end(), [&](const auto& a, const auto& b) {
      return alike(a->where, connection.topic) < alike(b->where, connection.topic);
    });
    const std::uint32_t id = connection.id;
    inner_->select({&id, 1});
    RawMessage first;
    const std::size_t size = inner_->next(first) ? packet_of(first).size() : 0;
    const bool imu = size == kOusterImuBytes;
    if (!imu && size != sensor.metadata.packet_bytes()) return;
    const auto [at, added] = topics_.try_emplace(connection.topic);
    if (added) {
      at->second.sensor = &sensor;
      at->second.imu = imu;
    } else if (at->second.imu != imu) {
      return;
    }
    topic_of_[id] = &at->second;
    if (imu) {
      connection = imu_connection(id, connection.topic);
      return;
    }
    connection.type = std::string(kOusterSweep);
    connection.md5.clear();
    connection.definition = sensor.json;
    connection.encoding = Encoding::ros1;
  }

  /// True when there is a message: in place of that which was read.
  bool unpack(PacketTopic& topic, RawMessage& message) {
    const Bytes packet = packet_of(message);
    message.encoding = Encoding::ros1;
    if (topic.imu) {
      if (!encode_ouster_imu(packet, message.time, topic.sensor->clock, imu_).empty()) return false;
      message.bytes = imu_;
      return true;
    }
    PacketHead head;
    if (!topic.sensor->format->head(packet, head).empty()) return false;
    const bool finished = topic.splitter->add(head, topic.sensor->clock.to_receiver(head.time, message.time), packet);
    message.bytes = topic.splitter->message();
    return finished;
  }

  std::unique_ptr<MessageReader> inner_;
  std::vector<std::unique_ptr<Sensor>> sensors_;
  std::vector<Connection> connections_;
  std::map<std::string, PacketTopic> topics_;
  std::map<std::uint32_t, PacketTopic*> topic_of_;  ///< by connection
  std::vector<std::uint32_t> selected_;
  std::vector<std::uint8_t> imu_;
  TimeNs last_time_ = 0;
  bool flushed_ = false;
};

/// By the texts of the recording; otherwise by a file.
std::vector<std::unique_ptr<Sensor>> sensors_of(MessageReader& reader, const std::filesystem::path& recording,
                                                const SensorConfig& config) {
  std::vector<std::unique_ptr<Sensor>> sensors;
  const bool named = !config.lidar_metadata.empty();
  std::vector<std::uint32_t> ids;
  for (const Connection& c : reader.connections()) {
    if (is_text(c)) ids.push_back(c.id);
  }
  constexpr int kMostTexts = 1000;  // latched: at the begin
  RawMessage message;
  if (!named && !ids.empty()) reader.select(ids);
  for (int i = 0; !named && !ids.empty() && i < kMostTexts && reader.next(message); ++i) {
    const std::string text(decode::Wire(message).text());
    const auto from = std::find_if(reader.connections().begin(), reader.connections().end(),
                                   [&](const Connection& c) { return c.id == message.connection; });
    const bool known =
        std::any_of(sensors.begin(), sensors.end(), [&](const auto& s) { return s->where == from->topic; });
    if (known || text.find("beam_altitude_angles") == std::string::npos) continue;
    sensors.push_back(std::make_unique<Sensor>(from->topic, text));
  }
  if (!sensors.empty()) return sensors;
  MetadataFile file = find_metadata(recording, config);
  if (!file.text.empty()) sensors.push_back(std::make_unique<Sensor>(file.path.string(), std::move(file.text)));
  return sensors;
}

}  // namespace

std::unique_ptr<MessageReader> unpack_ouster(std::unique_ptr<MessageReader> reader,
                                             const std::filesystem::path& recording, const SensorConfig& sensor) {
  bool packets = false, others = false, meant = false;
  std::vector<std::uint32_t> all;
  for (const Connection& c : reader->connections()) {
    all.push_back(c.id);
    packets = packets || is_packet_message(c);
    others = others || is_lidar(c);
    meant = meant || (is_packet_message(c) && (c.topic == sensor.lidar_topic || c.topic == sensor.imu_topic));
  }
  if (!packets || (others && !meant)) return reader;
  auto sensors = sensors_of(*reader, recording, sensor);
  if (sensors.empty()) {
    std::filesystem::path expected = recording;
    throw DataError(
        fmt::format("{}: its Ouster packets need the metadata of the sensor, and no std_msgs/String of it holds "
                    "that: put it beside as {}, or name it by `lidar_metadata` of the sensor file",
                    recording.string(), expected.replace_extension(".json").string()));
  }
  return std::make_unique<OusterReader>(std::move(reader), std::move(sensors));
}

}  // namespace aslio::io::packets
