#include <optional>

#include "aslio/core/errors.hpp"
#include "aslio/io/cdr.hpp"
#include "containers.hpp"
#include "lidar_messages.hpp"
#include "rows.hpp"
#include "writers_of.hpp"

namespace aslio::io {
namespace {

namespace fs = std::filesystem;

bool is_topic(const ReferenceLayout& layout) {
  return layout.format == ReferenceFile::pose || layout.format == ReferenceFile::point;
}

/// A topic, and the container that it goes to.
class TopicWriter {
 public:
  TopicWriter(MessageWriter& to, const std::string& topic, const rosbag::MessageType& type, Encoding encoding)
      : to_(to), ros1_{0, topic, std::string(type.name), std::string(type.md5), std::string(type.definition)} {
    Connection written = ros1_;
    if (encoding == Encoding::cdr) {
      written.type = ros2_type(ros1_.type);
      written.md5 = {};
      written.definition = ros2_definition(type.definition);
      written.encoding = Encoding::cdr;
    }
    converts_ = encoding == Encoding::cdr;
    id_ = to_.add(written);
  }

  std::uint32_t count() const { return count_; }
  /// To be filled in with a message of ROS1.
  std::vector<std::uint8_t>& bytes() { return bytes_; }
  void write(TimeNs received) {
    if (converts_) {
      if (const std::string why = to_cdr(ros1_, bytes_, converted_); !why.empty()) throw DataError(why);
    }
    to_.write(id_, received, converts_ ? converted_ : bytes_);
    ++count_;
  }

 private:
  MessageWriter& to_;
  Connection ros1_;
  bool converts_ = false;
  std::uint32_t id_ = 0, count_ = 0;
  std::vector<std::uint8_t> bytes_, converted_;
};

class MessageLayoutWriter final : public LayoutWriter {
 public:
  MessageLayoutWriter(const Layout& layout, const LayoutPlace& place)
      : layout_(layout), messages_(make_lidar_messages(layout.lidar, place.grid)), sampler_(layout.reference) {
    for (const std::string& name : layout.files) outputs_.push_back(open_container(layout_, place, name, files_));
    const Encoding encoding = layout.container == Container::rosbag ? Encoding::ros1 : Encoding::cdr;
    lidar_.emplace(*outputs_.front(), layout.lidar.topic, messages_->type(), encoding);
    imu_.emplace(*outputs_[outputs_.size() > 1 ? 1 : 0], layout.imu.topic, rosbag::kImu, encoding);
    if (is_topic(layout.reference)) {
      const bool pose = layout.reference.format == ReferenceFile::pose;
      reference_.emplace(*outputs_.back(), layout.reference.topic, pose ? rosbag::kPoseStamped : rosbag::kPointStamped,
                         encoding);
    } else if (layout.reference.format != ReferenceFile::none) {
      const fs::path path = place_of(place, layout.reference.file);
      reference_file_.emplace(layout.reference, path);
      files_.push_back(path.lexically_relative(place.folder));
    }
  }

  void add_imu(const ImuSample& sample, TimeNs received) override {
    const ImuSample told = as_told(layout_.imu, sample);
    rosbag::encode_imu({imu_->count(), told.t, layout_.imu.frame_id}, told.gyro, told.acc, imu_->bytes());
    imu_->write(received);
  }

  void add_sweep(const LidarPacket& sweep, TimeNs received) override {
    messages_->encode(as_told(layout_.lidar, sweep, scratch_), lidar_->count(), lidar_->bytes());
    lidar_->write(received);
  }

  void add_reference(const StampedPose& T_W_I) override {
    if (!reference_ && !reference_file_) return;
    const auto pose = sampler_.take(T_W_I);
    if (!pose) return;
    if (reference_file_) return reference_file_->add(*pose);
    const rosbag::HeaderFields header{reference_->count(), pose->t, "world"};
    if (layout_.reference.format == ReferenceFile::pose) {
      rosbag::encode_pose(header, pose->T, reference_->bytes());
    } else {
      rosbag::encode_point(header, pose->T.p, reference_->bytes());
    }
    reference_->write(T_W_I.t);
  }

  void close() override {
    for (const auto& output : outputs_) output->close();
    if (reference_file_) reference_file_->close();
  }

  const std::vector<fs::path>& files() const override { return files_; }

 private:
  const Layout layout_;
  std::vector<fs::path> files_;
  std::vector<std::unique_ptr<MessageWriter>> outputs_;
  std::unique_ptr<LidarMessages> messages_;
  std::optional<TopicWriter> lidar_, imu_, reference_;
  std::optional<ReferenceFileWriter> reference_file_;
  ReferenceSampler sampler_;
  LidarPacket scratch_;
};

}  // namespace

std::unique_ptr<LayoutWriter> open_message_layout(const Layout& layout, const LayoutPlace& place) {
  return std::make_unique<MessageLayoutWriter>(layout, place);
}

}  // namespace aslio::io
