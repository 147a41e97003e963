#include <fmt/format.h>

#include <set>
#include <vector>

#include "../compress.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/io/rosbag2/writer.hpp"
#include "statement.hpp"

namespace aslio::io::rosbag2 {
namespace {

// As rosbag2_storage_sqlite3 of schema 4 makes them.
constexpr const char* kTables = R"(
CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL);
CREATE TABLE metadata(id INTEGER PRIMARY KEY, metadata_version INTEGER NOT NULL, metadata TEXT NOT NULL);
CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, serialization_format TEXT NOT NULL,
                    offered_qos_profiles TEXT NOT NULL, type_description_hash TEXT NOT NULL);
CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type TEXT NOT NULL, encoding TEXT NOT NULL,
                                 encoded_message_definition TEXT NOT NULL, type_description_hash TEXT NOT NULL);
CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, data BLOB NOT NULL);
INSERT INTO schema(schema_version, ros_distro) VALUES (4, '');
)";
constexpr const char* kIndex = "CREATE INDEX timestamp_idx ON messages (timestamp ASC)";

}  // namespace

struct DatabaseWriter::Impl {
  std::filesystem::path path, temporary;
  DatabaseOptions options;
  Database database;
  Statement topic, message, definition;
  std::int64_t topics = 0;
  std::set<std::string> defined;
  std::vector<std::uint8_t> packed;

  [[noreturn]] void fail() const {
    throw DataError(fmt::format("{}: cannot write: {}", path.string(), sqlite3_errmsg(database.get())));
  }
  void run(const char* sql) const {
    if (sqlite3_exec(database.get(), sql, nullptr, nullptr, nullptr) != SQLITE_OK) fail();
  }
  Statement prepare(const char* sql) const {
    sqlite3_stmt* raw = nullptr;
    if (sqlite3_prepare_v2(database.get(), sql, -1, &raw, nullptr) != SQLITE_OK) fail();
    return Statement(raw);
  }
  void step(const Statement& statement) const {
    if (sqlite3_step(statement.get()) != SQLITE_DONE) fail();
    sqlite3_reset(statement.get());
  }
  /// The text of a type, once.
  void define(const Connection& connection) {
    if (!defined.insert(connection.type).second) return;
    sqlite3_stmt* row = definition.get();
    sqlite3_bind_text(row, 1, connection.type.data(), static_cast<int>(connection.type.size()), SQLITE_TRANSIENT);
    sqlite3_bind_text(row, 2, connection.definition.data(), static_cast<int>(connection.definition.size()),
                      SQLITE_TRANSIENT);
    step(definition);
  }
  void discard() {
    topic.reset();
    message.reset();
    definition.reset();
    database.reset();
    std::error_code ignored;
    if (!temporary.empty()) std::filesystem::remove(temporary, ignored);
    temporary.clear();
  }
};

DatabaseWriter::DatabaseWriter(const std::filesystem::path& path, DatabaseOptions options)
    : impl_(std::make_unique<Impl>()) {
  impl_->path = path;
  impl_->temporary = path.string() + ".unfinished";
  impl_->options = options;
  std::error_code ignored;
  std::filesystem::remove(impl_->temporary, ignored);
  sqlite3* raw = nullptr;
  const int result = sqlite3_open_v2(impl_->temporary.c_str(), &raw,
                                     SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX, nullptr);
  impl_->database.reset(raw);
  if (result != SQLITE_OK) throw DataError(fmt::format("{}: cannot write: {}", path.string(), sqlite3_errstr(result)));
  // The file counts once it has its name: no journal is needed before.
  impl_->run("PRAGMA journal_mode = OFF; PRAGMA synchronous = OFF; BEGIN");
  impl_->run(kTables);
  impl_->topic = impl_->prepare("INSERT INTO topics VALUES (?, ?, ?, 'cdr', '', '')");
  impl_->definition = impl_->prepare(
      "INSERT INTO message_definitions(topic_type, encoding, encoded_message_definition, type_description_hash) "
      "VALUES (?, 'ros2msg', ?, '')");
  impl_->message = impl_->prepare("INSERT INTO messages(topic_id, timestamp, data) VALUES (?, ?, ?)");
}

DatabaseWriter::~DatabaseWriter() { impl_->discard(); }

std::uint32_t DatabaseWriter::add(const Connection& connection) {
  if (connection.encoding != Encoding::cdr) {
    throw DataError(fmt::format("{}: a rosbag2 database carries CDR, and {} is none: convert it first",
                                impl_->path.string(), connection.topic));
  }
  sqlite3_stmt* row = impl_->topic.get();
  sqlite3_bind_int64(row, 1, ++impl_->topics);
  sqlite3_bind_text(row, 2, connection.topic.data(), static_cast<int>(connection.topic.size()), SQLITE_TRANSIENT);
  sqlite3_bind_text(row, 3, connection.type.data(), static_cast<int>(connection.type.size()), SQLITE_TRANSIENT);
  impl_->step(impl_->topic);
  if (!connection.definition.empty()) impl_->define(connection);
  return static_cast<std::uint32_t>(impl_->topics);
}

void DatabaseWriter::write(std::uint32_t connection, TimeNs time, std::span<const std::uint8_t> bytes) {
  if (impl_->options.compress) {
    impl_->packed = compress_zstd(bytes);
    bytes = impl_->packed;
  }
  sqlite3_stmt* row = impl_->message.get();
  sqlite3_bind_int64(row, 1, connection);
  sqlite3_bind_int64(row, 2, time);
  sqlite3_bind_blob64(row, 3, bytes.data(), bytes.size(), SQLITE_STATIC);
  impl_->step(impl_->message);
}

void DatabaseWriter::close() {
  if (impl_->options.index) impl_->run(kIndex);
  impl_->run("COMMIT");
  impl_->topic.reset();
  impl_->message.reset();
  impl_->definition.reset();
  if (sqlite3_close(impl_->database.release()) != SQLITE_OK) {
    throw DataError(fmt::format("{}: cannot close the database", impl_->path.string()));
  }
  std::filesystem::rename(impl_->temporary, impl_->path);
  impl_->temporary.clear();
}

}  // namespace aslio::io::rosbag2
