#pragma once
/// Reads MCAP files (https://mcap.dev/spec; chunks uncompressed, lz4 or zstd, and messages outside chunks) in the order
/// of log time, in bounded memory. Every length in the file is untrusted. A file without an index is scanned; one that
/// is cut short yields all whole messages.

#include <filesystem>
#include <memory>

#include "aslio/io/message_reader.hpp"

namespace aslio::io::mcap {

/// What a reader accepts before it refuses a file. A file beyond chunk_bytes, message_bytes or description_bytes may be
/// valid: the error then names the limit.
struct Limits {
  std::uint64_t chunk_bytes = 1U << 30U;           ///< longest compressed chunk once decompressed
  std::uint64_t chunk_ratio = 1U << 16U;           ///< decompressed over compressed size; zstd reaches half of it
  std::uint64_t message_bytes = 1U << 30U;         ///< longest message
  std::uint64_t record_bytes = 64U << 20U;         ///< longest description of a schema or channel, longest index record
  std::uint64_t description_bytes = 256U << 20U;   ///< descriptions of all channels; those of one schema repeat it
  std::uint64_t merged_chunk_bytes = 256U << 20U;  ///< chunks held at once to put messages in order
};

/// Connection::id is the channel id, ::type the name and ::definition the data of its schema (empty where it has none),
/// ::md5 the entry `md5sum` of its metadata.
class McapReader final : public MessageReader {
 public:
  /// Reads channels and chunk list. Throws DataError naming file, offset and remedy.
  explicit McapReader(const std::filesystem::path& path, const Limits& limits = {});
  ~McapReader() override;
  McapReader(McapReader&&) noexcept;
  McapReader& operator=(McapReader&&) noexcept;

  std::string kind() const override { return "MCAP file"; }
  const std::vector<Connection>& connections() const override;
  std::optional<TimeNs> begin_time() const override;
  std::optional<TimeNs> end_time() const override;
  void select(std::span<const std::uint32_t> ids) override;
  /// Checks what it reads by the checksums that the file has: a chunk by its own, messages outside chunks by that of
  /// the data section. The latter is checked for chunks as well once all have been read.
  bool next(RawMessage& message) override;
  InputStatus status() const override;
  const std::vector<std::string>& warnings() const override;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace aslio::io::mcap
