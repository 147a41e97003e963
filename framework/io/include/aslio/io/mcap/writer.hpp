#pragma once
/// Writes MCAP files (version 0): chunks with message indexes, and a summary with schemas, channels, chunk indexes,
/// statistics and offsets. Facts: mcap.dev/spec.

#include <cstdint>
#include <filesystem>
#include <memory>

#include "aslio/io/message_writer.hpp"

namespace aslio::io::mcap {

enum class Compression : std::uint8_t { none, lz4, zstd };

struct WriterOptions {
  Compression compression = Compression::none;
  std::size_t chunk_bytes = 1U << 20U;  ///< a chunk is closed once it holds this much
};

/// Messages of ROS1 (`ros1`, schema `ros1msg`) and ROS2 (`cdr`, schema `ros2msg`); all checksums are written. Memory:
/// one chunk, and some 100 bytes for each that has been written.
class McapWriter final : public MessageWriter {
 public:
  /// The file appears under `path` at close(). Throws DataError that names the path when it cannot be written.
  explicit McapWriter(const std::filesystem::path& path, WriterOptions options = {});
  ~McapWriter() override;
  McapWriter(const McapWriter&) = delete;
  McapWriter& operator=(const McapWriter&) = delete;

  std::uint32_t add(const Connection& connection) override;
  void write(std::uint32_t connection, TimeNs time, std::span<const std::uint8_t> bytes) override;
  void close() override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace aslio::io::mcap
