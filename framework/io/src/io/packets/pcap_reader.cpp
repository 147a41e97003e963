#include "pcap_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "capture_sensors.hpp"
#include "imu_message.hpp"
#include "sweep_message.hpp"
#include "sweep_splitter.hpp"

namespace aslio::io::packets {
namespace {

constexpr std::uint32_t kLidarId = 0, kImuId = 1;

std::string_view sweep_type(Vendor vendor) {
  switch (vendor) {
    case Vendor::velodyne:
      return kVelodyneSweep;
    case Vendor::hesai:
      return kHesaiSweep;
    case Vendor::ouster:
      return kOusterSweep;
  }
  return {};
}

class PcapReader final : public MessageReader {
 public:
  PcapReader(const std::filesystem::path& path, const SensorConfig& sensor)
      : capture_(path), sensor_(find_sensor(capture_, path, sensor)) {
    Connection lidar;
    lidar.id = kLidarId;
    lidar.topic = "lidar";
    lidar.type = std::string(sweep_type(sensor_.vendor));
    lidar.definition = sensor_.metadata;
    connections_.push_back(std::move(lidar));
    if (sensor_.has_imu) connections_.push_back(imu_connection(kImuId, "imu"));
    start_over();
  }

  std::string kind() const override { return "network capture"; }
  const std::vector<Connection>& connections() const override { return connections_; }
  std::optional<TimeNs> begin_time() const override { return sensor_.begin; }
  std::optional<TimeNs> end_time() const override { return sensor_.end; }
  InputStatus status() const override { return capture_.status(); }
  const std::vector<std::string>& warnings() const override { return warnings_; }

  void select(std::span<const std::uint32_t> ids) override {
    lidar_ = std::find(ids.begin(), ids.end(), kLidarId) != ids.end();
    imu_ = std::find(ids.begin(), ids.end(), kImuId) != ids.end();
    capture_.rewind();
    start_over();
  }

  bool next(RawMessage& message) override {
    Datagram datagram;
    while (capture_.next(datagram)) {
      last_time_ = std::max(last_time_, datagram.time);  // captures may be out of order by a little
      if (sensor_.is_imu(datagram)) {
        if (add_imu(datagram) && imu_) return yield(kImuId, imu_message_, message);
      } else if (sensor_.is_lidar(datagram) && add_lidar(datagram) && lidar_) {
        return yield(kLidarId, splitter_->message(), message);
      }
    }
    note_end();
    if (!splitter_->flush() || !lidar_) return false;
    return yield(kLidarId, splitter_->message(), message);
  }

 private:
  void start_over() {
    splitter_.emplace(*sensor_.format);
    clock_.emplace(sensor_.format->clock_period());
    last_time_ = 0;
  }

  /// Both kinds of packets set the clock, whichever is selected: so their times do not depend on it.
  bool add_imu(const Datagram& datagram) {
    const auto encode = sensor_.vendor == Vendor::ouster ? encode_ouster_imu : encode_velodyne_imu;
    return encode(datagram.payload, datagram.time, *clock_, imu_message_).empty();
  }

  bool add_lidar(const Datagram& datagram) {
    PacketHead head;
    const std::string why = sensor_.format->head(datagram.payload, head);
    if (why.empty()) {
      return splitter_->add(head, clock_->to_receiver(head.time, datagram.time), datagram.payload);
    }
    if (!foreign_) warnings_.push_back(fmt::format("packets were skipped that cannot be decoded; the first: {}", why));
    foreign_ = true;
    return false;
  }

  bool yield(std::uint32_t connection, const std::vector<std::uint8_t>& bytes, RawMessage& message) const {
    message.connection = connection;
    message.time = last_time_;
    message.bytes = bytes;
    message.encoding = Encoding::ros1;
    return true;
  }

  void note_end() {
    if (noted_) return;
    noted_ = true;
    if (!capture_.damage().empty()) {
      warnings_.push_back(
          fmt::format("it ends within a record ({}): copy it again from its origin", capture_.damage()));
    }
    if (capture_.incomplete() > 0) {
      warnings_.push_back(
          fmt::format("{} datagrams are there in part alone (fragments lost, or a snapshot length below "
                      "that of the packets) and were skipped",
                      capture_.incomplete()));
    }
  }

  CaptureFile capture_;
  CaptureSensor sensor_;
  std::vector<Connection> connections_;
  std::vector<std::string> warnings_;
  std::optional<SweepSplitter> splitter_;
  std::optional<SensorClock> clock_;
  std::vector<std::uint8_t> imu_message_;
  TimeNs last_time_ = 0;
  bool lidar_ = true, imu_ = true, foreign_ = false, noted_ = false;
};

}  // namespace

std::unique_ptr<MessageReader> open_capture(const std::filesystem::path& path, const SensorConfig& sensor) {
  return std::make_unique<PcapReader>(path, sensor);
}

}  // namespace aslio::io::packets
