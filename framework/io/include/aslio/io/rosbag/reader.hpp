#pragma once
/// Reads ROS1 bags (format 2.0; chunks uncompressed, lz4 or bz2) in the order of record time, in bounded memory.
/// Every length in the file is untrusted. Bags without an index are scanned; a bag cut short yields all whole messages.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "aslio/core/time.hpp"
#include "aslio/io/message_reader.hpp"

namespace aslio::io::rosbag {

/// What a reader accepts before it refuses a file as damaged or hostile.
struct Limits {
  std::uint64_t record_bytes = 2U << 30U;         ///< longest record; an uncompressed chunk is one, read in parts
  std::uint64_t chunk_bytes = 1U << 30U;          ///< longest compressed chunk once decompressed
  std::uint64_t lz4_ratio = 256;                  ///< decompressed over compressed size: what the format can reach
  std::uint64_t bz2_ratio = 65'536;               ///< the same of bz2
  std::uint64_t header_bytes = 1U << 20U;         ///< longest record header or connection description
  std::uint64_t merged_chunk_bytes = 64U << 20U;  ///< decompressed chunks held at once to put messages in order
  std::size_t connections = 4096;
};

using io::Connection;
using BagMessage = RawMessage;

class BagReader final : public MessageReader {
 public:
  /// Reads connections and chunk list. Throws DataError naming file, offset and remedy.
  explicit BagReader(const std::filesystem::path& path, const Limits& limits = {});
  ~BagReader() override;
  BagReader(BagReader&&) noexcept;
  BagReader& operator=(BagReader&&) noexcept;

  std::string kind() const override { return "ROS1 bag"; }
  const std::vector<Connection>& connections() const override;
  std::optional<TimeNs> begin_time() const override;
  std::optional<TimeNs> end_time() const override;
  void select(std::span<const std::uint32_t> ids) override;
  bool next(BagMessage& message) override;
  InputStatus status() const override;
  const std::vector<std::string>& warnings() const override;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace aslio::io::rosbag
