#pragma once
/// Writes rosbag2 databases (SQLite, schema 4) as rosbag2_storage_sqlite3 does, and the metadata.yaml of their folder.

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "aslio/io/message_writer.hpp"

namespace aslio::io::rosbag2 {

struct DatabaseOptions {
  bool index = true;      ///< on times, as rosbag2 makes it
  bool compress = false;  ///< each message by zstd (compression_mode MESSAGE)
};

/// One `.db3` file of CDR messages.
class DatabaseWriter final : public MessageWriter {
 public:
  /// Throws DataError that names the path when it cannot be written.
  explicit DatabaseWriter(const std::filesystem::path& path, DatabaseOptions options = {});
  ~DatabaseWriter() override;
  std::uint32_t add(const Connection& connection) override;
  void write(std::uint32_t connection, TimeNs time, std::span<const std::uint8_t> bytes) override;
  void close() override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// How a folder is written in parts: `make(path without extension)` opens a part and returns its name as well.
struct FolderOptions {
  struct OpenPart {
    std::unique_ptr<MessageWriter> writer;
    std::string file;  ///< its name in the folder
  };
  std::function<OpenPart(const std::filesystem::path& stem)> make;
  std::string storage = "sqlite3";  ///< `storage_identifier`
  bool compressed_messages = false;
  double part_s = 0;  ///< a new part each so many seconds of record time; 0: one part
};

/// A folder `NAME` of parts `NAME_0`, `NAME_1`, .. with the metadata.yaml that lists them.
std::unique_ptr<MessageWriter> open_folder_writer(const std::filesystem::path& folder, FolderOptions options);

}  // namespace aslio::io::rosbag2
