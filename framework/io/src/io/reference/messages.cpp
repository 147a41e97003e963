// Poses in a recording.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <set>

#include "../topic_chooser.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/io/writers.hpp"
#include "decode_poses.hpp"
#include "rows.hpp"

namespace aslio::io {
namespace {

using decode::PoseKind;
using decode::ToldPose;

constexpr const char* kTypes =
    "nav_msgs/Odometry, geometry_msgs/PoseStamped, PoseWithCovarianceStamped, TransformStamped, PointStamped, "
    "sensor_msgs/NavSatFix and tf2_msgs/TFMessage";

bool readable(const Connection& c) { return c.encoding != Encoding::other && decode::pose_kind(c.type).has_value(); }

bool tells_pose(const Connection& c) { return readable(c) && decode::pose_kind(c.type) != PoseKind::transforms; }

const TopicRoleWords kAnyWords{"reference", "topic", kTypes, &readable};
const TopicRoleWords kPoseWords{"reference", "topic", kTypes, &tells_pose};

/// Positions of fixes east, north and up of the first one [m] (WGS 84).
class LocalTangent {
 public:
  Vec3 position(const Vec3& fix) {
    const double lat = fix[0] * kRadPerDegree, lon = fix[1] * kRadPerDegree;
    const Vec3 p = earth_centred(lat, lon, fix[2]);
    if (!set_) {
      set_ = true;
      origin_ = p;
      R_enu_ << -std::sin(lon), std::cos(lon), 0,                                         //
          -std::sin(lat) * std::cos(lon), -std::sin(lat) * std::sin(lon), std::cos(lat),  //
          std::cos(lat) * std::cos(lon), std::cos(lat) * std::sin(lon), std::sin(lat);
    }
    return R_enu_ * (p - origin_);
  }

 private:
  static constexpr double kRadPerDegree = std::numbers::pi / 180;

  static Vec3 earth_centred(double lat, double lon, double height) {
    constexpr double a = 6378137.0, f = 1 / 298.257223563, e2 = f * (2 - f);
    const double n = a / std::sqrt(1 - e2 * std::sin(lat) * std::sin(lat));
    return {(n + height) * std::cos(lat) * std::cos(lon), (n + height) * std::cos(lat) * std::sin(lon),
            (n * (1 - e2) + height) * std::sin(lat)};
  }

  bool set_ = false;
  Vec3 origin_ = Vec3::Zero();
  Mat3 R_enu_ = Mat3::Identity();
};

class MessageRows {
 public:
  explicit MessageRows(const ReferenceSpec& spec) : spec_(spec), reader_(open_messages(spec.file)) { choose(); }

  ReferenceRows read() {
    RawMessage message;
    while (reader_->next(message)) {
      ++count_;
      const std::string wrong = decode::decode_poses(message, kind_, [this](const ToldPose& pose) { take(pose); });
      if (wrong.empty()) continue;
      if (malformed_++ == 0) first_wrong_ = fmt::format("message {}: {}", count_, wrong);
    }
    conclude();
    return std::move(out_);
  }

 private:
  void choose() {
    const bool by_frames = !spec_.parent_frame.empty() || !spec_.child_frame.empty();
    const TopicChooser chooser(spec_.file, reader_->connections(), "");
    const auto chosen = chooser.choose(by_frames || !spec_.topic.empty() ? kAnyWords : kPoseWords, topic(by_frames));
    kind_ = *decode::pose_kind(chosen.front().type);
    std::vector<std::uint32_t> ids;
    for (const Connection& c : chosen) {
      if (decode::pose_kind(c.type) == kind_) ids.push_back(c.id);
    }
    reader_->select(ids);
    out_.source = fmt::format("{}: {}", spec_.file, chosen.front().topic);
    out_.place = "message";
    out_.positions_only = kind_ == PoseKind::point || kind_ == PoseKind::fix;
    out_.notes.push_back(fmt::format("poses of topic {} [{}]", chosen.front().topic, chosen.front().type));
  }

  /// Frames ask for the topic of TF, whatever others there are.
  std::string topic(bool by_frames) const {
    if (!spec_.topic.empty() || !by_frames) return spec_.topic;
    for (const Connection& c : reader_->connections()) {
      if (decode::pose_kind(c.type) == PoseKind::transforms && !c.topic.ends_with("_static")) return c.topic;
    }
    return {};
  }

  void take(const ToldPose& told) {
    if (kind_ == PoseKind::transforms && !wanted(told)) return;
    if (!told.valid) {
      ++without_fix_;
      return;
    }
    if (!told.p.allFinite() || !is_time(told.t)) {
      if (malformed_++ == 0) first_wrong_ = fmt::format("message {}: its position or stamp is no number", count_);
      return;
    }
    if (out_.rows.size() == kMostPoses) {
      throw DataError(fmt::format("{}: has more than {} poses; name another topic", out_.source, kMostPoses));
    }
    ReferenceRow row;
    row.line = count_;
    row.pose.t = told.t;
    row.pose.T.p = kind_ == PoseKind::fix ? tangent_.position(told.p) : told.p;
    if (!out_.positions_only) row.pose.T.R = rotation_of(told);
    out_.rows.push_back(row);
  }

  /// Of the frames that are asked for; remembers which there are.
  bool wanted(const ToldPose& told) {
    constexpr std::size_t kMostFrames = 1000;
    std::pair<std::string, std::string> frames(stripped(told.parent), stripped(told.child));
    const bool fits = (spec_.parent_frame.empty() || frames.first == stripped(spec_.parent_frame)) &&
                      (spec_.child_frame.empty() || frames.second == stripped(spec_.child_frame));
    if (fits && (chosen_.contains(frames) || chosen_.size() < kMostFrames)) chosen_.insert(frames);
    if (seen_.size() < kMostFrames) seen_.insert(std::move(frames));
    return fits;
  }

  /// tf wrote `/map` where tf2 writes `map`.
  static std::string stripped(std::string_view frame) {
    return std::string(frame.starts_with('/') ? frame.substr(1) : frame);
  }

  Mat3 rotation_of(const ToldPose& told) {
    const Eigen::Quaterniond q(told.q[3], told.q[0], told.q[1], told.q[2]);
    const double norm = q.norm();
    if (norm == 0) {
      ++zeros_;
      return Mat3::Identity();
    }
    if (!(std::abs(norm - 1) < 1e-2) && spec_.positions_only != PositionsOnly::yes) {
      throw DataError(
          fmt::format("{}: message {}: a quaternion of norm {:.4f}; set `positions_only: yes` to do without",
                      out_.source, count_, norm));
    }
    return std::isfinite(norm) ? q.normalized().toRotationMatrix() : Mat3::Identity();
  }

  static std::string pairs_of(const std::set<std::pair<std::string, std::string>>& pairs) {
    std::string text;
    std::size_t shown = 0;
    for (const auto& [parent, child] : pairs) {
      if (shown++ == 20) return text + ", ..";
      text += fmt::format("{}{} -> {}", text.empty() ? "" : ", ", parent, child);
    }
    return text.empty() ? "none" : text;
  }

  void conclude() {
    if (chosen_.size() > 1) {
      throw DataError(fmt::format("{}: has several frames that fit: {}; set `parent_frame` and `child_frame`",
                                  out_.source, pairs_of(chosen_)));
    }
    if (out_.rows.empty()) {
      const std::string frames = seen_.empty() ? "" : fmt::format("; there are the frames {}", pairs_of(seen_));
      throw DataError(
          fmt::format("{}: tells no pose{}{}{}", out_.source, frames, malformed_ > 0 ? ": " : "", first_wrong_));
    }
    if (without_fix_ > 0) out_.notes.push_back(fmt::format("{} messages have no fix: left out", without_fix_));
    if (malformed_ > 0) {
      out_.warnings.push_back(
          fmt::format("{}: {} messages cannot be read and are left out; {}", out_.source, malformed_, first_wrong_));
    }
    for (const std::string& warning : reader_->warnings()) out_.warnings.push_back(warning);
    judge_orientations();
  }

  void judge_orientations() {
    const bool set = spec_.positions_only == PositionsOnly::yes;
    const bool all_zero = zeros_ == out_.rows.size();
    if (zeros_ > 0 && !all_zero && !set) {
      throw DataError(fmt::format("{}: {} of {} quaternions are 0 0 0 0; set `positions_only: yes` to do without",
                                  out_.source, zeros_, out_.rows.size()));
    }
    out_.positions_only = out_.positions_only || set || all_zero;
    if (!out_.positions_only) return;
    if (spec_.positions_only == PositionsOnly::no) {
      throw ConfigError(fmt::format("{}: has no orientation, which `positions_only: no` asks for", out_.source));
    }
    out_.notes.emplace_back("positions only: no rotation error is measured");
  }

  const ReferenceSpec& spec_;
  std::unique_ptr<MessageReader> reader_;
  PoseKind kind_ = PoseKind::pose;
  ReferenceRows out_;
  LocalTangent tangent_;
  std::set<std::pair<std::string, std::string>> chosen_, seen_;
  std::size_t count_ = 0, zeros_ = 0, without_fix_ = 0, malformed_ = 0;
  std::string first_wrong_;
};

}  // namespace

bool is_recording(const std::string& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) return true;
  if (!std::filesystem::is_regular_file(path, ignored)) return false;
  std::array<char, 16> head{};
  std::ifstream file(path, std::ios::binary);
  file.read(head.data(), head.size());
  const std::string_view begin(head.data(), static_cast<std::size_t>(std::max<std::streamsize>(file.gcount(), 0)));
  return begin.starts_with("#ROSBAG") || begin.starts_with("\x89MCAP") || begin.starts_with("SQLite format 3");
}

ReferenceRows read_message_rows(const ReferenceSpec& spec) { return MessageRows(spec).read(); }

}  // namespace aslio::io
