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
#include "aslio/io/source.hpp"

namespace aslio::io::rosbag {

/// What a reader accepts before it refuses a file as damaged or hostile.
struct Limits {
  std::uint64_t record_bytes = 256U << 20U;       ///< longest record
  std::uint64_t chunk_bytes = 64U << 20U;         ///< longest compressed chunk once decompressed
  std::uint64_t chunk_ratio = 200;                ///< decompressed over compressed size
  std::uint64_t header_bytes = 1U << 20U;         ///< longest record header or connection description
  std::uint64_t merged_chunk_bytes = 64U << 20U;  ///< decompressed chunks held at once to put messages in order
  std::size_t connections = 4096;
};

struct Connection {
  std::uint32_t id = 0;
  std::string topic, type, md5, definition;
};

struct BagMessage {
  std::uint32_t connection = 0;              ///< Connection::id
  TimeNs time = 0;                           ///< when it was recorded
  std::span<const std::uint8_t> bytes = {};  ///< ROS1 serialisation; valid until the next call
};

class BagReader {
 public:
  /// Reads connections and chunk list. Throws DataError naming file, offset and remedy.
  explicit BagReader(const std::filesystem::path& path, const Limits& limits = {});
  ~BagReader();
  BagReader(BagReader&&) noexcept;
  BagReader& operator=(BagReader&&) noexcept;

  /// By id, ascending.
  const std::vector<Connection>& connections() const;
  /// Record time of the first and last message of the bag; nullopt for a bag without messages.
  std::optional<TimeNs> begin_time() const;
  std::optional<TimeNs> end_time() const;

  /// Restricts reading to these connections (all of them before the first call) and starts over.
  void select(std::span<const std::uint32_t> ids);
  /// Next message by record time; messages of equal time in file order. False at the end. Throws DataError for damage.
  bool next(BagMessage& message);

  /// `truncated` once it is known that the file ends before its last record does.
  InputStatus status() const;
  const std::vector<std::string>& warnings() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace aslio::io::rosbag
