#include "folder_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "aslio/core/errors.hpp"

namespace aslio::io {
namespace {

constexpr TimeNs kEndOfStamps = (TimeNs{1} << 32) * kSecond;  ///< seconds of a message have 32 bits

template <class Item, class Stamp>
std::vector<TimeNs> stamps_of(const std::vector<Item>& items, Stamp stamp) {
  std::vector<TimeNs> stamps;
  stamps.reserve(items.size());
  for (const Item& item : items) stamps.push_back(item.*stamp);
  return stamps;
}

/// Names of files reach terminals and reports: control characters in them are replaced.
std::string printable(std::string name) {
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
  return name;
}

}  // namespace

FolderReader::FolderReader(FolderRecording recording) : recording_(std::move(recording)) {
  for (const ImuTrack& imu : recording_.imus) add_track(imu.topic, false, stamps_of(imu.samples, &ImuSample::t));
  for (const ScanTrack& lidar : recording_.lidars)
    add_track(lidar.topic, true, stamps_of(lidar.scans, &ScanFile::stamp));
}

void FolderReader::add_track(const std::string& topic, bool scans, const std::vector<TimeNs>& stamps) {
  Connection connection;
  connection.id = static_cast<std::uint32_t>(tracks_.size());
  connection.topic = printable(topic);
  connection.type = scans ? rosbag::kPointCloud2.name : rosbag::kImu.name;
  connections_.push_back(connection);
  Track track;
  track.scans = scans;
  track.order.resize(stamps.size());
  std::iota(track.order.begin(), track.order.end(), 0U);
  std::stable_sort(track.order.begin(), track.order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return stamps[a] < stamps[b]; });
  for (const std::uint32_t i : track.order) track.stamps.push_back(stamps[i]);
  std::size_t backward = 0;
  for (std::size_t i = 1; i < stamps.size(); ++i) backward += stamps[i] < stamps[i - 1] ? 1 : 0;
  if (backward > 0) {
    recording_.warnings.push_back(
        fmt::format("{}: {} stamps lie before their predecessor: all were put in the order of "
                    "time",
                    connection.topic, backward));
  }
  if (!track.stamps.empty()) {
    for (const TimeNs t : {track.stamps.front(), track.stamps.back()}) {
      if (t >= 0 && t < kEndOfStamps) continue;
      throw DataError(
          fmt::format("{}: {}: a stamp of {:.3f} s lies before 1970 or after 2106; correct it, or remove "
                      "what has it",
                      recording_.folder.string(), connection.topic, to_seconds(t)));
    }
    begin_ = std::min(begin_.value_or(kTimeMax), track.stamps.front());
    end_ = std::max(end_.value_or(kTimeMin), track.stamps.back());
  }
  tracks_.push_back(std::move(track));
}

void FolderReader::select(std::span<const std::uint32_t> ids) {
  for (std::size_t id = 0; id < tracks_.size(); ++id) {
    tracks_[id].selected = std::find(ids.begin(), ids.end(), id) != ids.end();
    tracks_[id].at = 0;
  }
}

bool FolderReader::next(RawMessage& message) {
  std::size_t id = tracks_.size();
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    const auto time = [this](std::size_t track) { return tracks_[track].stamps[tracks_[track].at]; };
    if (tracks_[i].left() && (id == tracks_.size() || time(i) < time(id))) id = i;
  }
  if (id == tracks_.size()) return false;
  Track& track = tracks_[id];
  const auto sequence = static_cast<std::uint32_t>(track.at);
  const std::size_t item = track.order[track.at];
  const TimeNs stamp = track.stamps[track.at++];
  if (track.scans) {
    encode_scan(recording_.lidars[id - recording_.imus.size()], item, sequence);
  } else {
    const ImuSample& sample = recording_.imus[id].samples[item];
    rosbag::encode_imu({sequence, stamp, {}}, sample.gyro, sample.acc, bytes_);
  }
  message = {static_cast<std::uint32_t>(id), stamp, bytes_, Encoding::ros1};
  return true;
}

void FolderReader::note_damage(const std::filesystem::path& scan) {
  constexpr std::size_t kMaxNoted = 10;
  status_ = InputStatus::truncated;
  if (damaged_.size() > kMaxNoted || !damaged_.insert(scan.string()).second) return;
  recording_.warnings.push_back(damaged_.size() > kMaxNoted ? "further scans are damaged, too"
                                                            : fmt::format("{}: {}", scan.string(), table_.damage));
}

void FolderReader::encode_scan(const ScanTrack& track, std::size_t i, std::uint32_t sequence) {
  table_.bytes.clear();
  table_.damage.clear();
  track.read(i, table_);
  if (!table_.damage.empty()) note_damage(track.scans[i].path);
  rosbag::CloudLayout layout;
  layout.fields = table_.columns;
  layout.point_step = table_.point_step;
  layout.width = static_cast<std::uint32_t>(table_.bytes.size() / std::max<std::size_t>(table_.point_step, 1));
  layout.row_step = layout.width * layout.point_step;
  rosbag::encode_point_cloud2({sequence, track.scans[i].stamp, {}}, layout, table_.bytes, bytes_);
}

}  // namespace aslio::io
