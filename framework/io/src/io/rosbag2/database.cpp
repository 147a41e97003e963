#include "database.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <set>

#include "../input_file.hpp"
#include "aslio/core/errors.hpp"
#include "statement.hpp"

namespace aslio::io::rosbag2 {
namespace {

constexpr std::size_t kHeader = 100;  // of the file format, SQLite's documentation, 1.3
constexpr int kLongestSql = 1 << 20;

/// The file has fewer pages than its header says.
bool is_cut(const std::filesystem::path& path) {
  const InputFile file(path);
  std::array<std::uint8_t, kHeader> head{};
  if (file.size() < head.size()) return true;
  file.read(0, head);
  const auto number = [&head](std::size_t at, std::size_t bytes) {
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < bytes; ++i) value = value << 8U | head[at + i];
    return value;
  };
  const std::uint64_t page = number(16, 2) == 1 ? 65536 : number(16, 2);
  const bool count_holds = number(24, 4) == number(92, 4);
  return count_holds && page * number(28, 4) > file.size();
}

/// A path as the URI that SQLite takes: what has a meaning there is escaped.
std::string uri_of(const std::filesystem::path& path) {
  std::string uri = "file:";
  for (const char c : std::filesystem::absolute(path).string()) {
    if (c == '%' || c == '?' || c == '#') {
      uri += fmt::format("%{:02X}", static_cast<unsigned char>(c));
    } else {
      uri += c;
    }
  }
  // Immutable: no lock, no journal and no shared memory beside the file.
  return uri + "?mode=ro&immutable=1";
}

std::string sql_name(const std::string& identifier) {
  std::string text = "\"";
  for (const char c : identifier) text += c == '"' ? std::string("\"\"") : std::string(1, c);
  return text + "\"";
}

}  // namespace

bool is_database(const std::string& head) { return head == std::string("SQLite format 3\0", 16); }

class DatabaseReader::Impl {
 public:
  Impl(const std::filesystem::path& path, std::string name, std::unique_ptr<ScratchFile> unpacked, const Limits& limits)
      : name_(std::move(name)), unpacked_(std::move(unpacked)), limits_(limits) {
    if (is_cut(path) || (unpacked_ && unpacked_->cut())) cut("the file is cut short");
    open(path);
    require_tables();
    warn_of_journal(path);
    read_topics();
    if (unpacked_) unpacked_->hide();
    if (status_ == InputStatus::complete) index_ = time_index();
    read_extent();
  }

  const std::vector<Connection>& connections() const { return connections_; }
  InputStatus status() const { return status_; }
  const std::vector<std::string>& warnings() const { return warnings_; }
  std::optional<TimeNs> begin() const { return begin_; }
  std::optional<TimeNs> end() const { return end_; }

  void select(std::span<const std::uint32_t> ids) {
    wanted_.clear();
    for (const std::uint32_t id : ids) {
      if (id < topics_.size()) wanted_.push_back(topics_[id]);
    }
    all_ = false;
    start_over();
  }

  bool next(RawMessage& message) {
    if (!started_) start();
    return index_.empty() ? next_by_list(message) : next_by_index(message);
  }

 private:
  struct Place {
    TimeNs time;
    std::int64_t row;
  };

  [[noreturn]] void fail(const std::string& why) const { throw DataError(fmt::format("{}: {}", name_, why)); }
  [[noreturn]] void fail_damaged() const {
    fail(
        fmt::format("the database is damaged: {}; copy it again from its origin, or save what is left with `sqlite3 "
                    "FILE .recover`",
                    sqlite3_errmsg(database_.get())));
  }

  void cut(const std::string& what) {
    status_ = InputStatus::truncated;
    warnings_.push_back(what + ": messages behind the cut are missing");
  }

  void open(const std::filesystem::path& path) {
    sqlite3* raw = nullptr;
    const int result = sqlite3_open_v2(uri_of(path).c_str(), &raw,
                                       SQLITE_OPEN_READONLY | SQLITE_OPEN_URI | SQLITE_OPEN_NOMUTEX, nullptr);
    database_.reset(raw);
    if (result != SQLITE_OK) fail(fmt::format("cannot open the database: {}", sqlite3_errstr(result)));
    sqlite3_limit(raw, SQLITE_LIMIT_LENGTH,
                  static_cast<int>(std::min<std::uint64_t>(limits_.message_bytes, 1U << 30U)));
    sqlite3_limit(raw, SQLITE_LIMIT_SQL_LENGTH, kLongestSql);
    sqlite3_limit(raw, SQLITE_LIMIT_ATTACHED, 0);
    sqlite3_db_config(raw, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
    sqlite3_db_config(raw, SQLITE_DBCONFIG_ENABLE_VIEW, 0, nullptr);
    sqlite3_db_config(raw, SQLITE_DBCONFIG_ENABLE_TRIGGER, 0, nullptr);
    sqlite3_exec(raw, "PRAGMA mmap_size = 0; PRAGMA cache_size = -8192; PRAGMA temp_store = FILE;", nullptr, nullptr,
                 nullptr);
    // A file with fewer pages than it says is opened only so.
    if (status_ == InputStatus::truncated) sqlite3_exec(raw, "PRAGMA writable_schema = ON", nullptr, nullptr, nullptr);
  }

  Statement prepare(const std::string& sql) const {
    sqlite3_stmt* raw = nullptr;
    const int result = sqlite3_prepare_v2(database_.get(), sql.c_str(), -1, &raw, nullptr);
    if (result != SQLITE_OK) fail_damaged();
    return Statement(raw);
  }

  /// Real tables: a view or a virtual table of such a name may compute for ever.
  void require_tables() const {
    const Statement rows = prepare("SELECT name FROM sqlite_master WHERE type = 'table' AND rootpage > 0");
    std::set<std::string> tables;
    int result = SQLITE_ROW;
    while ((result = sqlite3_step(rows.get())) == SQLITE_ROW) tables.insert(text_of(rows.get(), 0));
    if (result != SQLITE_DONE) fail_damaged();
    for (const char* table : {"topics", "messages"}) {
      if (tables.count(table) == 0) {
        fail(fmt::format("this SQLite database is no rosbag2 recording: it has no table `{}` (tables: {})", table,
                         tables.empty() ? "none" : fmt::format("{}", fmt::join(tables, ", "))));
      }
    }
  }

  void warn_of_journal(const std::filesystem::path& path) {
    std::error_code error;
    const auto journal = std::filesystem::path(path.string() + "-wal");
    if (unpacked_ || std::filesystem::file_size(journal, error) == 0 || error) return;
    warnings_.push_back(
        fmt::format("the recorder did not close it: its last messages lie in {} and are not read; copy both files and "
                    "run `sqlite3 COPY.db3 'PRAGMA wal_checkpoint'`",
                    journal.filename().string()));
  }

  void read_topics() {
    const Statement rows = prepare("SELECT id, name, type, serialization_format FROM topics ORDER BY id");
    int result = SQLITE_ROW;
    while ((result = sqlite3_step(rows.get())) == SQLITE_ROW) {
      if (connections_.size() >= limits_.topics) fail(fmt::format("it has more than {} topics", limits_.topics));
      Connection& c = connections_.emplace_back();
      c.id = static_cast<std::uint32_t>(connections_.size() - 1);
      c.topic = text_of(rows.get(), 1);
      c.type = text_of(rows.get(), 2);
      const std::string format = text_of(rows.get(), 3);
      c.encoding = format == "cdr" || format.empty() ? Encoding::cdr : Encoding::other;
      topics_.push_back(sqlite3_column_int64(rows.get(), 0));
    }
    if (result != SQLITE_DONE) fail_damaged();
  }

  std::string time_index() const {
    const Statement rows = prepare(
        "SELECT l.name FROM pragma_index_list('messages') AS l JOIN pragma_index_info(l.name) AS i "
        "WHERE l.partial = 0 AND i.seqno = 0 AND i.name = 'timestamp'");
    return sqlite3_step(rows.get()) == SQLITE_ROW ? text_of(rows.get(), 0) : std::string{};
  }

  void read_extent() {
    if (index_.empty()) {
      list_messages();
      for (const Place& place : places_) extend(place.time);
      return;
    }
    for (const char* sql : {"SELECT MIN(timestamp) FROM messages", "SELECT MAX(timestamp) FROM messages"}) {
      const Statement row = prepare(sql);
      if (sqlite3_step(row.get()) != SQLITE_ROW) fail_damaged();
      if (sqlite3_column_type(row.get(), 0) == SQLITE_NULL) return;
      extend(sqlite3_column_int64(row.get(), 0));
    }
  }
  void extend(TimeNs time) {
    begin_ = std::min(begin_.value_or(time), time);
    end_ = std::max(end_.value_or(time), time);
  }

  std::string which_topics() const {
    return all_ ? std::string{"1"} : fmt::format("topic_id IN ({})", fmt::join(wanted_, ","));
  }

  void start_over() {
    rows_.reset();
    started_ = false;
  }

  void start() {
    started_ = true;
    next_place_ = 0;
    if (!index_.empty()) {
      // Named, since a plan without it would sort the data of all messages.
      rows_ = prepare(fmt::format(
          "SELECT id, topic_id, timestamp, data FROM messages INDEXED BY {} WHERE {} ORDER BY timestamp, id",
          sql_name(index_), which_topics()));
      return;
    }
    list_messages();
    rows_ = prepare("SELECT id, topic_id, timestamp, data FROM messages WHERE id = ?");
  }

  /// Without an index on time, or in a file that is cut: the order from the times alone, data by row afterwards.
  void list_messages() {
    places_.clear();
    const Statement rows =
        prepare(fmt::format("SELECT id, timestamp FROM messages NOT INDEXED WHERE {}", which_topics()));
    int result = SQLITE_ROW;
    while ((result = sqlite3_step(rows.get())) == SQLITE_ROW) {
      places_.push_back({sqlite3_column_int64(rows.get(), 1), sqlite3_column_int64(rows.get(), 0)});
    }
    if (result != SQLITE_DONE && status_ == InputStatus::complete) fail_damaged();
    std::stable_sort(places_.begin(), places_.end(),
                     [](const Place& a, const Place& b) { return a.time != b.time ? a.time < b.time : a.row < b.row; });
  }

  bool next_by_index(RawMessage& message) {
    const int result = sqlite3_step(rows_.get());
    if (result == SQLITE_ROW) return give(message);
    if (result == SQLITE_TOOBIG) fail_too_big();
    if (result != SQLITE_DONE) fail_damaged();
    return false;
  }

  bool next_by_list(RawMessage& message) {
    for (; next_place_ < places_.size();) {
      sqlite3_reset(rows_.get());
      sqlite3_bind_int64(rows_.get(), 1, places_[next_place_++].row);
      const int result = sqlite3_step(rows_.get());
      if (result == SQLITE_ROW) return give(message);
      if (result == SQLITE_TOOBIG) fail_too_big();
      if (status_ == InputStatus::complete) fail_damaged();
    }
    return false;
  }

  [[noreturn]] void fail_too_big() const {
    fail(fmt::format("a message is longer than {} MiB, the longest that is read", limits_.message_bytes >> 20U));
  }

  bool give(RawMessage& message) {
    sqlite3_stmt* row = rows_.get();
    const auto topic = std::lower_bound(topics_.begin(), topics_.end(), sqlite3_column_int64(row, 1));
    const std::int64_t id = sqlite3_column_int64(row, 0);
    if (topic == topics_.end() || *topic != sqlite3_column_int64(row, 1)) {
      fail(fmt::format("message {} is of topic {}, which the table `topics` lacks: the database is damaged", id,
                       sqlite3_column_int64(row, 1)));
    }
    if (sqlite3_column_type(row, 2) != SQLITE_INTEGER) {
      fail(fmt::format("the timestamp of message {} is no integer: the database is damaged", id));
    }
    const Connection& connection = connections_[static_cast<std::size_t>(topic - topics_.begin())];
    const auto* data = static_cast<const std::uint8_t*>(sqlite3_column_blob(row, 3));
    message.connection = connection.id;
    message.time = sqlite3_column_int64(row, 2);
    message.encoding = connection.encoding;
    message.bytes = {data, data == nullptr ? 0 : static_cast<std::size_t>(sqlite3_column_bytes(row, 3))};
    if (is_zstd(message.bytes)) unpack(id, message);
    return true;
  }

  /// Compression per message: only metadata.yaml would say so, yet no CDR begins with these bytes.
  void unpack(std::int64_t id, RawMessage& message) {
    if (const std::string why = decompress_message(message.bytes, limits_.message_bytes, plain_); !why.empty()) {
      fail(fmt::format("message {} cannot be decompressed: {}; copy the file again from its origin", id, why));
    }
    message.bytes = plain_.bytes();
  }

  std::string name_;
  std::unique_ptr<ScratchFile> unpacked_;
  Limits limits_;
  Database database_;
  Statement rows_;
  std::vector<Connection> connections_;
  std::vector<std::int64_t> topics_, wanted_;  ///< ids in the file; of all topics by connection, ascending
  std::string index_;                          ///< on the times of messages; empty: none that can be used
  std::vector<Place> places_;
  std::size_t next_place_ = 0;
  ByteBuffer plain_;
  std::optional<TimeNs> begin_, end_;
  std::vector<std::string> warnings_;
  InputStatus status_ = InputStatus::complete;
  bool all_ = true, started_ = false;
};

DatabaseReader::DatabaseReader(const std::filesystem::path& path, std::string name,
                               std::unique_ptr<ScratchFile> unpacked, const Limits& limits)
    : impl_(std::make_unique<Impl>(path, std::move(name), std::move(unpacked), limits)) {}
DatabaseReader::~DatabaseReader() = default;

const std::vector<Connection>& DatabaseReader::connections() const { return impl_->connections(); }
std::optional<TimeNs> DatabaseReader::begin_time() const { return impl_->begin(); }
std::optional<TimeNs> DatabaseReader::end_time() const { return impl_->end(); }
void DatabaseReader::select(std::span<const std::uint32_t> ids) { impl_->select(ids); }
bool DatabaseReader::next(RawMessage& message) { return impl_->next(message); }
InputStatus DatabaseReader::status() const { return impl_->status(); }
const std::vector<std::string>& DatabaseReader::warnings() const { return impl_->warnings(); }

}  // namespace aslio::io::rosbag2
