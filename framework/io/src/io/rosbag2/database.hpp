#pragma once
/// Reads a rosbag2 database (SQLite, `.db3`) in the order of record time, in bounded memory. The file is taken as it
/// is: nothing is written beside it. Source: rosbag2_storage_sqlite3, schemas 1 to 4 (older ones lack tables and
/// columns).

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "../zstd.hpp"
#include "aslio/io/message_reader.hpp"

struct sqlite3;

namespace aslio::io::rosbag2 {

struct Limits {
  std::uint64_t message_bytes = 256U << 20U;  ///< longest message, decompressed
  std::size_t topics = 4096;
};

/// A file whose first bytes are those of a SQLite database.
bool is_database(const std::string& head);

class DatabaseReader final : public MessageReader {
 public:
  /// Reads the topics. `name`: of the recording in messages; `unpacked`: the file that `path` names, kept while it is
  /// read. Throws DataError naming the file, what is wrong, and the remedy.
  DatabaseReader(const std::filesystem::path& path, std::string name, std::unique_ptr<ScratchFile> unpacked = nullptr,
                 const Limits& limits = {});
  ~DatabaseReader() override;

  std::string kind() const override { return "rosbag2 database"; }
  const std::vector<Connection>& connections() const override;
  std::optional<TimeNs> begin_time() const override;
  std::optional<TimeNs> end_time() const override;
  void select(std::span<const std::uint32_t> ids) override;
  bool next(RawMessage& message) override;
  InputStatus status() const override;
  const std::vector<std::string>& warnings() const override;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace aslio::io::rosbag2
