#include "capture_sensors.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <tuple>
#include <utility>

#include "../input_file.hpp"
#include "aslio/core/errors.hpp"
#include "hesai.hpp"
#include "ouster.hpp"
#include "pcap_reader.hpp"
#include "velodyne.hpp"

namespace aslio::io::packets {
namespace {

constexpr std::size_t kFirstPackets = 20;  ///< by which a model is told
constexpr std::size_t kMostStreams = 256;  ///< of other traffic: the rest is not listed

bool is_velodyne_data(Bytes payload) {
  return payload.size() == kVelodyneDataBytes && payload[0] == 0xFF && (payload[1] == 0xEE || payload[1] == 0xDD);
}

/// Datagrams of one sender to one port.
struct Stream {
  std::optional<Vendor> vendor;
  std::uint64_t datagrams = 0;
  std::size_t bytes = 0;                                            ///< of the last one
  bool ouster_sized = false;                                        ///< as LiDAR packets of some Ouster are
  std::vector<std::pair<TimeNs, std::vector<std::uint8_t>>> first;  ///< of a LiDAR
};
using StreamKey = std::pair<std::string, std::uint16_t>;
using Streams = std::map<StreamKey, Stream>;

/// Sizes of 16 columns of 16 to 128 rows in the known profiles; others exist, and are found by metadata alone.
bool is_ouster_sized(std::size_t bytes) {
  for (const std::size_t rows : {16U, 32U, 64U, 128U}) {
    const std::size_t legacy = 16 * (20 + 12 * rows);
    if (bytes == legacy) return true;
    for (const std::size_t pixel : {4U, 8U, 12U, 16U}) {
      if (bytes == 64 + 16 * (12 + pixel * rows)) return true;
    }
  }
  return false;
}

std::string list_of(const Streams& streams, bool lidars) {
  std::vector<std::string> lines;
  for (const auto& [key, stream] : streams) {
    if (lidars && !stream.vendor) continue;
    lines.push_back(fmt::format("\n  {}:{} ({} datagrams, the last of {} bytes)", key.first, key.second,
                                stream.datagrams, stream.bytes));
  }
  return lines.empty() ? "\n  (none)" : fmt::format("{}", fmt::join(lines, ""));
}

class SensorFinder {
 public:
  SensorFinder(CaptureFile& capture, const std::filesystem::path& path, const SensorConfig& sensor)
      : capture_(capture), path_(path), sensor_(sensor), file_(find_metadata(path, sensor)) {
    if (!file_.text.empty()) metadata_ = parse_ouster_metadata(file_.path.string(), file_.text);
  }

  CaptureSensor find() {
    read_all();
    const auto chosen = choose();
    CaptureSensor found;
    found.vendor = chosen->second.vendor.value();
    std::tie(found.address, found.port) = chosen->first;
    found.begin = begin_.value_or(0);
    found.end = end_;
    found.format = format_of(chosen->second);
    if (found.vendor == Vendor::ouster) found.metadata = file_.text;
    found.has_imu = imu_senders_.contains({found.vendor, found.address});
    return found;
  }

 private:
  void read_all() {
    Datagram datagram;
    while (capture_.next(datagram)) {
      if (!begin_) begin_ = datagram.time;
      end_ = std::max(end_, datagram.time);
      const StreamKey key(datagram.address, datagram.port);
      if (streams_.size() >= kMostStreams && !streams_.contains(key)) continue;
      look_at(datagram, streams_[key]);
    }
    capture_.rewind();
  }

  void look_at(const Datagram& datagram, Stream& stream) {
    ++stream.datagrams;
    stream.bytes = datagram.payload.size();
    stream.ouster_sized = stream.ouster_sized || is_ouster_sized(stream.bytes);
    if (const auto vendor = lidar_of(datagram.payload)) {
      if (!stream.vendor) stream.vendor = vendor;
      if (stream.first.size() < kFirstPackets) {
        stream.first.emplace_back(datagram.time, std::vector(datagram.payload.begin(), datagram.payload.end()));
      }
    }
    VelodynePosition position;
    const bool inertial = decode_velodyne_position(datagram.payload, position).empty() && position.has_imu;
    if (inertial) imu_senders_[{Vendor::velodyne, datagram.address}] = true;
    const bool ouster = metadata_ && metadata_->legacy_imu && datagram.payload.size() == kOusterImuBytes;
    if (ouster) imu_senders_[{Vendor::ouster, datagram.address}] = true;
  }

  std::optional<Vendor> lidar_of(Bytes payload) const {
    if (is_velodyne_data(payload)) return Vendor::velodyne;
    if (hesai_model(payload)) return Vendor::hesai;
    if (metadata_ && payload.size() == metadata_->packet_bytes()) return Vendor::ouster;
    return std::nullopt;
  }

  /// `lidar_address` names a sender, or a sender and a port: "10.5.5.1", "10.5.5.1:7502".
  bool is_meant(const StreamKey& key) const {
    const std::string& wanted = sensor_.lidar_address;
    return wanted.empty() || wanted == key.first || wanted == fmt::format("{}:{}", key.first, key.second);
  }

  Streams::const_iterator choose() const {
    std::vector<Streams::const_iterator> lidars;
    for (auto at = streams_.begin(); at != streams_.end(); ++at) {
      if (at->second.vendor && is_meant(at->first)) lidars.push_back(at);
    }
    if (lidars.size() == 1) return lidars.front();
    if (lidars.size() > 1) {
      throw DataError(
          fmt::format("{}: it holds the packets of more than one LiDAR; set `lidar_address` of the sensor "
                      "file to one of:{}",
                      path_.string(), list_of(streams_, true)));
    }
    fail_without_lidar();
  }

  [[noreturn]] void fail_without_lidar() const {
    const bool others = std::any_of(streams_.begin(), streams_.end(), [](const auto& s) { return s.second.vendor; });
    if (others) {
      throw DataError(fmt::format("{}: no LiDAR sends from `lidar_address` {}; set it to one of:{}", path_.string(),
                                  sensor_.lidar_address, list_of(streams_, true)));
    }
    const bool ouster =
        std::any_of(streams_.begin(), streams_.end(), [](const auto& s) { return s.second.ouster_sized; });
    if (ouster && metadata_) {
      throw DataError(
          fmt::format("{}: no datagram is of the {} bytes that the metadata {} says; name that of this sensor "
                      "by `lidar_metadata` of the sensor file. It holds:{}",
                      path_.string(), metadata_->packet_bytes(), file_.path.string(), list_of(streams_, false)));
    }
    if (ouster) {
      std::filesystem::path expected = path_;
      throw DataError(
          fmt::format("{}: these look like packets of an Ouster, which need the metadata of the sensor: put "
                      "it beside as {}, or name it by `lidar_metadata` of the sensor file",
                      path_.string(), expected.replace_extension(".json").string()));
    }
    throw DataError(
        fmt::format("{}: it holds no packets of a LiDAR that can be read (Velodyne VLP-16, HDL-32E, VLP-32C, "
                    "VLS-128; Ouster; Hesai XT16, XT32, QT64, Pandar40P). It holds:{}",
                    path_.string(), list_of(streams_, false)));
  }

  std::unique_ptr<PacketFormat> format_of(const Stream& stream) const {
    std::vector<Packet> first;
    for (const auto& [time, bytes] : stream.first) first.push_back({time, bytes});
    std::string why;
    std::unique_ptr<PacketFormat> format;
    if (stream.vendor == Vendor::ouster) {
      format = make_ouster(*metadata_);
      PacketHead head;
      why = format->head(first.front().bytes, head);
      if (!why.empty()) format.reset();
    } else {
      format = stream.vendor == Vendor::hesai ? make_hesai(first, {}, why) : make_velodyne(first, why);
    }
    if (!format) throw DataError(fmt::format("{}: its packets cannot be decoded: {}", path_.string(), why));
    return format;
  }

  CaptureFile& capture_;
  const std::filesystem::path& path_;
  const SensorConfig& sensor_;
  MetadataFile file_;
  std::optional<OusterMetadata> metadata_;
  Streams streams_;
  std::map<std::pair<Vendor, std::string>, bool> imu_senders_;
  std::optional<TimeNs> begin_;
  TimeNs end_ = 0;
};

}  // namespace

bool CaptureSensor::is_lidar(const Datagram& datagram) const {
  if (datagram.port != port || datagram.address != address) return false;
  return vendor != Vendor::velodyne || is_velodyne_data(datagram.payload);
}

bool CaptureSensor::is_imu(const Datagram& datagram) const {
  if (!has_imu || datagram.address != address) return false;
  const std::size_t bytes = vendor == Vendor::ouster ? kOusterImuBytes : kVelodynePositionBytes;
  return datagram.payload.size() == bytes && (vendor != Vendor::ouster || datagram.port != port);
}

CaptureSensor find_sensor(CaptureFile& capture, const std::filesystem::path& path, const SensorConfig& sensor) {
  return SensorFinder(capture, path, sensor).find();
}

MetadataFile find_metadata(const std::filesystem::path& recording, const SensorConfig& sensor) {
  constexpr std::uint64_t kMost = 4 << 20;
  const char* what = "the metadata of an Ouster (`lidar_metadata` of the sensor file)";
  if (!sensor.lidar_metadata.empty()) {
    return {sensor.lidar_metadata, read_small_file(sensor.lidar_metadata, kMost, what)};
  }
  const std::string stem = recording.stem().string();
  std::filesystem::path best;
  std::error_code error;
  const std::filesystem::path folder = recording.parent_path().empty() ? "." : recording.parent_path();
  for (std::filesystem::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    const std::filesystem::path& path = at->path();
    const bool fits = path.extension() == ".json" && stem.starts_with(path.stem().string());
    if (fits && path.stem().string().size() > best.stem().string().size()) best = path;
  }
  if (best.empty() || !std::filesystem::is_regular_file(best, error)) return {};
  std::string text = read_small_file(best, kMost, what);
  // Any other file may be named so.
  if (text.find("beam_altitude_angles") == std::string::npos) return {};
  return {best, std::move(text)};
}

}  // namespace aslio::io::packets
