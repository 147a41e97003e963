#pragma once
/// Writes ROS1 bags (format 2.0) with an index, for the simulator and for tests. Readable by librosbag.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

#include "aslio/io/message_writer.hpp"

namespace aslio::io::rosbag {

enum class Compression : std::uint8_t { none, lz4 };

struct WriterOptions {
  Compression compression = Compression::none;
  std::uint32_t chunk_bytes = 768 * 1024;  ///< a chunk is closed once it holds this much
  bool index = true;                       ///< false: as a recorder leaves a bag it could not close
};

class BagWriter final : public MessageWriter {
 public:
  /// The bag appears under `path` at close(). Throws DataError that names the path when it cannot be written.
  explicit BagWriter(const std::filesystem::path& path, WriterOptions options = {});
  ~BagWriter() override;
  BagWriter(const BagWriter&) = delete;
  BagWriter& operator=(const BagWriter&) = delete;

  /// `definition` is the full message text as in `rosmsg show --raw`, with its dependencies.
  std::uint32_t add_connection(const std::string& topic, const std::string& type, const std::string& md5,
                               const std::string& definition);
  /// Of a message in ROS1 serialisation.
  std::uint32_t add(const Connection& connection) override;
  void write(std::uint32_t connection, TimeNs time, std::span<const std::uint8_t> bytes) override;
  void close() override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace aslio::io::rosbag
