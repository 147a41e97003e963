#include "lidar_messages.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "../packets/velodyne_encoder.hpp"
#include "aslio/core/errors.hpp"
#include "cloud_form.hpp"

namespace aslio::io {
namespace {

class CloudMessages final : public LidarMessages {
 public:
  CloudMessages(const LidarLayout& layout, const SweepGrid& grid)
      : layout_(layout), grid_(grid), encoder_(layout, grid) {}

  const rosbag::MessageType& type() const override { return rosbag::kPointCloud2; }
  void encode(const LidarPacket& sweep, std::uint32_t seq, std::vector<std::uint8_t>& out) override {
    const std::vector<std::uint8_t>& data = encoder_.encode(sweep);
    const TimeNs stamp = moment_of(layout_.stamp, sweep.stamp, grid_.period);
    rosbag::encode_point_cloud2({seq, stamp, layout_.frame_id}, encoder_.layout(), data, out);
  }

 private:
  const LidarLayout layout_;
  const SweepGrid grid_;
  CloudEncoder encoder_;
};

class LivoxMessages final : public LidarMessages {
 public:
  explicit LivoxMessages(const LidarLayout& layout) : layout_(layout) {}

  const rosbag::MessageType& type() const override {
    return layout_.form == LidarForm::livox ? rosbag::kLivoxCustomMsg : rosbag::kLivox2CustomMsg;
  }
  void encode(const LidarPacket& sweep, std::uint32_t seq, std::vector<std::uint8_t>& out) override {
    points_.clear();
    for (const TimedPoint& p : sweep.points) {
      const TimeNs offset = p.t - sweep.stamp;
      if (offset < 0 || offset > std::numeric_limits<std::uint32_t>::max()) {
        throw DataError(
            fmt::format("a point lies {} ns from the start of its sweep, and a Livox message holds 0 to 2^32", offset));
      }
      points_.push_back({static_cast<std::uint32_t>(offset), p.x, p.y, p.z,
                         static_cast<std::uint8_t>(std::clamp(p.intensity, 0.0F, 255.0F)), p.tag, p.line});
    }
    rosbag::encode_livox({seq, sweep.stamp, layout_.frame_id}, sweep.stamp, kLidarId, points_, out);
  }

 private:
  static constexpr std::uint8_t kLidarId = 1;
  const LidarLayout layout_;
  std::vector<rosbag::LivoxPoint> points_;
};

class PacketMessages final : public LidarMessages {
 public:
  PacketMessages(const LidarLayout& layout, const SweepGrid& grid) : layout_(layout), grid_(grid) {}

  const rosbag::MessageType& type() const override { return rosbag::kVelodyneScan; }
  void encode(const LidarPacket& sweep, std::uint32_t seq, std::vector<std::uint8_t>& out) override {
    encoder_.encode(sweep, packets_);
    const TimeNs stamp = moment_of(layout_.stamp, sweep.stamp, grid_.period);
    rosbag::encode_velodyne_scan({seq, stamp, layout_.frame_id}, packets_, out);
  }

 private:
  const LidarLayout layout_;
  const SweepGrid grid_;
  packets::Vlp16Encoder encoder_;
  std::vector<rosbag::VelodynePacketFields> packets_;
};

}  // namespace

std::unique_ptr<LidarMessages> make_lidar_messages(const LidarLayout& layout, const SweepGrid& grid) {
  if (is_livox_form(layout.form)) return std::make_unique<LivoxMessages>(layout);
  if (layout.form == LidarForm::velodyne_packets) return std::make_unique<PacketMessages>(layout, grid);
  return std::make_unique<CloudMessages>(layout, grid);
}

}  // namespace aslio::io
