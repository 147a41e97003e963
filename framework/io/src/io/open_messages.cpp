#include "aslio/io/message_reader.hpp"
#include "aslio/io/rosbag/reader.hpp"

namespace aslio::io {

std::unique_ptr<MessageReader> open_messages(const std::filesystem::path& path) {
  return std::make_unique<rosbag::BagReader>(path);
}

}  // namespace aslio::io
