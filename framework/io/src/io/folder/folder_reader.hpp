#pragma once

#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "aslio/io/message_reader.hpp"
#include "folder_recording.hpp"

namespace aslio::io {

/// The scans and IMU samples of a folder as sensor_msgs/PointCloud2 and sensor_msgs/Imu. A folder tells no times of
/// recording: messages come by their stamps, of equal ones the IMU samples first. One scan is in memory at a time.
class FolderReader final : public MessageReader {
 public:
  /// Throws DataError for a stamp that no message can carry.
  explicit FolderReader(FolderRecording recording);

  std::string kind() const override { return recording_.kind; }
  const std::vector<Connection>& connections() const override { return connections_; }
  std::optional<TimeNs> begin_time() const override { return begin_; }
  std::optional<TimeNs> end_time() const override { return end_; }
  void select(std::span<const std::uint32_t> ids) override;
  bool next(RawMessage& message) override;
  InputStatus status() const override { return status_; }
  const std::vector<std::string>& warnings() const override { return recording_.warnings; }
  const std::vector<std::string>& verdicts() const override { return recording_.verdicts; }

  const FolderRecording& recording() const { return recording_; }

 private:
  /// One connection, by its number.
  struct Track {
    std::vector<TimeNs> stamps;        ///< ascending
    std::vector<std::uint32_t> order;  ///< of the samples or scans
    std::size_t at = 0;
    bool selected = true, scans = false;
    bool left() const { return selected && at < order.size(); }
  };

  void add_track(const std::string& topic, bool scans, const std::vector<TimeNs>& stamps);
  void note_damage(const std::filesystem::path& scan);
  void encode_scan(const ScanTrack& track, std::size_t i, std::uint32_t sequence);

  FolderRecording recording_;
  std::vector<Connection> connections_;
  std::vector<Track> tracks_;
  std::optional<TimeNs> begin_, end_;
  InputStatus status_ = InputStatus::complete;
  PointTable table_;
  std::vector<std::uint8_t> bytes_;
  std::set<std::string> damaged_;  ///< the first scans that are
};

}  // namespace aslio::io
