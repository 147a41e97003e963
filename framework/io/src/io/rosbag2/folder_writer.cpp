#include <fmt/format.h>

#include "aslio/core/errors.hpp"
#include "aslio/io/rosbag2/writer.hpp"
#include "aslio/io/writers.hpp"

namespace aslio::io::rosbag2 {
namespace {

class FolderWriter final : public MessageWriter {
 public:
  FolderWriter(std::filesystem::path folder, FolderOptions options)
      : folder_(std::move(folder)), options_(std::move(options)) {
    std::filesystem::create_directories(folder_);
  }

  std::uint32_t add(const Connection& connection) override {
    topics_.push_back({connection, 0});
    if (part_) topics_.back().id = part_->add(connection);
    return static_cast<std::uint32_t>(topics_.size() - 1);
  }

  void write(std::uint32_t connection, TimeNs time, std::span<const std::uint8_t> bytes) override {
    if (!part_ || (options_.part_s > 0 && to_seconds(time - part_begin_) >= options_.part_s)) open_part(time);
    Topic& topic = topics_.at(connection);
    part_->write(topic.id, time, bytes);
    ++topic.messages;
    begin_ = std::min(begin_, time);
    end_ = std::max(end_, time);
  }

  void close() override {
    if (!part_) open_part(0);
    part_->close();
    part_.reset();
    AtomicFile file(folder_ / "metadata.yaml");
    file.write(metadata());
    file.close();
  }

 private:
  struct Topic {
    Connection connection;
    std::uint32_t id = 0;  ///< in the part
    std::uint64_t messages = 0;
  };

  void open_part(TimeNs begin) {
    if (part_) part_->close();
    const std::string name = fmt::format("{}_{}", folder_.filename().string(), files_.size());
    FolderOptions::OpenPart opened = options_.make(folder_ / name);
    part_ = std::move(opened.writer);
    files_.push_back(opened.file);
    for (Topic& topic : topics_) topic.id = part_->add(topic.connection);
    part_begin_ = begin;
  }

  std::string metadata() const {
    std::uint64_t all = 0;
    for (const Topic& topic : topics_) all += topic.messages;
    std::string text = fmt::format(
        "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: {}\n  duration:\n    nanoseconds: {}\n"
        "  starting_time:\n    nanoseconds_since_epoch: {}\n  message_count: {}\n  topics_with_message_count:\n",
        options_.storage, all == 0 ? 0 : end_ - begin_, begin_, all);
    for (const Topic& topic : topics_) {
      text += fmt::format(
          "    - topic_metadata:\n        name: {}\n        type: {}\n        serialization_format: cdr\n"
          "        offered_qos_profiles: \"\"\n      message_count: {}\n",
          topic.connection.topic, topic.connection.type, topic.messages);
    }
    text += fmt::format("  compression_format: \"{}\"\n  compression_mode: \"{}\"\n  relative_file_paths:\n",
                        options_.compressed_messages ? "zstd" : "", options_.compressed_messages ? "MESSAGE" : "");
    for (const std::string& file : files_) text += fmt::format("    - {}\n", file);
    return text;
  }

  std::filesystem::path folder_;
  FolderOptions options_;
  std::vector<Topic> topics_;
  std::vector<std::string> files_;
  std::unique_ptr<MessageWriter> part_;
  TimeNs part_begin_ = 0, begin_ = kTimeMax, end_ = 0;
};

}  // namespace

std::unique_ptr<MessageWriter> open_folder_writer(const std::filesystem::path& folder, FolderOptions options) {
  return std::make_unique<FolderWriter>(folder, std::move(options));
}

}  // namespace aslio::io::rosbag2
