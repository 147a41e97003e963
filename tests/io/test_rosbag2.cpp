// rosbag2 databases, folders of parts, and several inputs as one: the same measurements as from the bag.
#include <sqlite3.h>

#include <catch2/catch.hpp>
#include <fstream>

#include "aslio/core/errors.hpp"
#include "aslio/io/cdr.hpp"
#include "aslio/io/rosbag2/writer.hpp"
#include "io/bag_fixture.hpp"
#include "io/rewritten.hpp"

namespace aslio::io::test {
namespace {

namespace fs = std::filesystem;

std::vector<TimeNs> times(MessageReader& reader) {
  std::vector<TimeNs> all;
  for (RawMessage message; reader.next(message);) all.push_back(message.time);
  return all;
}

void run_sql(const fs::path& path, const std::string& sql) {
  sqlite3* database = nullptr;
  REQUIRE(sqlite3_open(path.c_str(), &database) == SQLITE_OK);
  char* why = nullptr;
  const int result = sqlite3_exec(database, sql.c_str(), nullptr, nullptr, &why);
  INFO(sql << ": " << (why == nullptr ? "" : why));
  CHECK(result == SQLITE_OK);
  sqlite3_free(why);
  sqlite3_close(database);
}

}  // namespace

TEST_CASE("a database yields the measurements of the bag that it was written from") {
  TemporaryFolder folder;
  Recording().write(folder / "a.bag");
  const std::vector<std::string> expected = measurements(*open_source(folder / "a.bag", {}));
  REQUIRE(expected.size() == 220);
  for (const bool index : {true, false}) {
    for (const bool compress : {true, false}) {
      const fs::path path = folder / fmt::format("{}{}.db3", index, compress);
      rosbag2::DatabaseWriter writer(path, {index, compress});
      rewrite(folder / "a.bag", writer);
      CHECK(measurements(*open_source(path, {})) == expected);
    }
  }
}

TEST_CASE("a cloud keeps every bit in CDR") {
  TemporaryFolder folder;
  Recording recording;
  recording.lidar_type = rosbag::kPointCloud2;
  recording.lidar = [](int, TimeNs stamp) { return cloud_message(stamp); };
  recording.write(folder / "a.bag");
  rosbag2::DatabaseWriter writer(folder / "a.db3");
  rewrite(folder / "a.bag", writer);
  CHECK(measurements(*open_source(folder / "a.db3", {})) == measurements(*open_source(folder / "a.bag", {})));
}

TEST_CASE("a compressed database is read from a hidden file that leaves no trace") {
  TemporaryFolder folder;
  Recording().write(folder / "a.bag");
  rosbag2::DatabaseWriter writer(folder / "a.db3");
  rewrite(folder / "a.bag", writer);
  const std::vector<std::string> expected = measurements(*open_source(folder / "a.db3", {}));
  write_bytes(folder / "a.db3.zstd", packed_zstd(read_bytes(folder / "a.db3")));
  fs::create_directory(folder / "scratch");
  const auto reader = open_messages(folder / "a.db3.zstd", folder / "scratch");
  CHECK(fs::is_empty(folder / "scratch"));
  CHECK(times(*reader).size() == 220);
  CHECK(measurements(*open_source(folder / "a.db3.zstd", {})) == expected);
  SECTION("cut short, it gives what is there") {
    std::vector<std::uint8_t> bytes = read_bytes(folder / "a.db3.zstd");
    bytes.resize(bytes.size() * 2 / 3);
    write_bytes(folder / "cut.db3.zstd", bytes);
    try {
      const auto cut = open_messages(folder / "cut.db3.zstd");
      CHECK(times(*cut).size() < 220);
      CHECK(cut->status() == InputStatus::truncated);
    } catch (const DataError& error) {
      CHECK(contains(error.what(), "cut.db3.zstd"));
    }
  }
  SECTION("a folder that cannot be written is named") {
    CHECK(contains(data_error([&] { open_messages(folder / "a.db3.zstd", "/proc"); }), "set TMPDIR"));
  }
}

TEST_CASE("messages come by time, whatever the order of the rows") {
  TemporaryFolder folder;
  for (const bool index : {true, false}) {
    const fs::path path = folder / (index ? "i.db3" : "n.db3");
    rosbag2::DatabaseWriter writer(path, {index, false});
    const std::uint32_t a = writer.add({0, "/a", "std_msgs/msg/String", "", "", Encoding::cdr});
    const std::uint32_t b = writer.add({0, "/b", "std_msgs/msg/String", "", "", Encoding::cdr});
    const std::vector<std::uint8_t> bytes{0, 1, 0, 0, 42};
    for (const TimeNs t : {30, 10, 20, 10}) writer.write(t == 20 ? b : a, t, bytes);
    writer.close();
    const auto reader = open_messages(path);
    CHECK(times(*reader) == std::vector<TimeNs>{10, 10, 20, 30});
    CHECK(reader->begin_time() == 10);
    CHECK(reader->end_time() == 30);
    const std::uint32_t second = reader->connections().at(1).id;
    reader->select({&second, 1});
    CHECK(times(*reader) == std::vector<TimeNs>{20});
  }
}

TEST_CASE("old schemas, an empty serialisation format and no message are read") {
  TemporaryFolder folder;
  const std::string tables =
      "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, serialization_format TEXT "
      "NOT "
      "NULL);CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, data "
      "BLOB NOT NULL);";
  run_sql(folder / "old.db3", tables + "INSERT INTO topics VALUES (7, '/imu', 'sensor_msgs/msg/Imu', '')");
  const auto reader = open_messages(folder / "old.db3");
  REQUIRE(reader->connections().size() == 1);
  CHECK(reader->connections()[0].encoding == Encoding::cdr);
  CHECK_FALSE(reader->begin_time());
  CHECK(times(*reader).empty());
}

TEST_CASE("a database that is no recording, or a hostile one, is refused by name") {
  TemporaryFolder folder;
  run_sql(folder / "other.db3", "CREATE TABLE cars(id INTEGER)");
  CHECK(contains(data_error([&] { open_messages(folder / "other.db3"); }), "it has no table `messages`") !=
        contains(data_error([&] { open_messages(folder / "other.db3"); }), "it has no table `topics` (tables: cars)"));
  run_sql(folder / "view.db3",
          "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT);"
          "CREATE VIEW messages AS WITH RECURSIVE n(id) AS (SELECT 1 UNION ALL SELECT id + 1 FROM n) "
          "SELECT id, 1 AS topic_id, id AS timestamp, x'00' AS data FROM n");
  CHECK(contains(data_error([&] { open_messages(folder / "view.db3"); }), "it has no table `messages`"));
}

TEST_CASE("a database cut at any page yields whole messages, or says what is wrong") {
  TemporaryFolder folder;
  Recording().write(folder / "a.bag");
  rosbag2::DatabaseWriter writer(folder / "a.db3");
  rewrite(folder / "a.bag", writer);
  const std::vector<std::uint8_t> whole = read_bytes(folder / "a.db3");
  std::size_t readable = 0;
  for (std::size_t size = 0; size < whole.size(); size += 1024) {
    write_bytes(folder / "cut.db3", {whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)});
    try {
      const auto reader = open_messages(folder / "cut.db3");
      CHECK(reader->status() == InputStatus::truncated);
      CHECK_FALSE(reader->warnings().empty());
      readable = std::max(readable, times(*reader).size());
    } catch (const DataError& error) {
      CHECK(contains(error.what(), "cut.db3"));
    }
  }
  CHECK(readable > 100);
}

TEST_CASE("flipped bits of a database never crash, nor run on") {
  TemporaryFolder folder;
  Recording recording;
  recording.seconds = 0.3;
  recording.write(folder / "a.bag");
  rosbag2::DatabaseWriter writer(folder / "a.db3");
  rewrite(folder / "a.bag", writer);
  const std::vector<std::uint8_t> whole = read_bytes(folder / "a.db3");
  std::uint64_t state = 101;
  for (int trial = 0; trial < 400; ++trial) {
    std::vector<std::uint8_t> bytes = whole;
    for (int flip = 0; flip < 3; ++flip) {
      state = state * 6364136223846793005U + 1442695040888963407U;
      bytes[(state >> 33U) % bytes.size()] ^= static_cast<std::uint8_t>(1U << ((state >> 20U) % 8));
    }
    write_bytes(folder / "flipped.db3", bytes);
    try {
      const auto reader = open_messages(folder / "flipped.db3");
      const std::size_t messages = times(*reader).size();
      CHECK(messages < 1000);
    } catch (const DataError& error) {
      CHECK(contains(error.what(), "flipped.db3"));
    }
  }
}

TEST_CASE("a folder of parts is one recording") {
  TemporaryFolder folder;
  Recording().write(folder / "a.bag");
  rosbag2::FolderOptions options;
  options.part_s = 0.5;
  options.make = [](const fs::path& stem) -> rosbag2::FolderOptions::OpenPart {
    const fs::path path = stem.string() + ".db3";
    return {std::make_unique<rosbag2::DatabaseWriter>(path), path.filename().string()};
  };
  const auto writer = rosbag2::open_folder_writer(folder / "run", options);
  rewrite(folder / "a.bag", *writer);
  const std::vector<std::string> expected = measurements(*open_source(folder / "a.bag", {}));
  REQUIRE(fs::exists(folder / "run/run_3.db3"));
  CHECK(measurements(*open_source(folder / "run", {})) == expected);
  CHECK(measurements(*open_source(folder / "run/run_*.db3", {})) == expected);
  SECTION("without metadata.yaml by the names") {
    fs::remove(folder / "run/metadata.yaml");
    CHECK(measurements(*open_source(folder / "run", {})) == expected);
  }
  SECTION("a part that is missing is named, and the time without a message") {
    rosbag2::FolderOptions longer = options;
    longer.part_s = 0.2;
    Recording recording;
    recording.seconds = 4;
    recording.write(folder / "long.bag");
    const auto again = rosbag2::open_folder_writer(folder / "long", longer);
    rewrite(folder / "long.bag", *again);
    for (int part = 5; part < 12; ++part) fs::remove(folder / fmt::format("long/long_{}.db3", part));
    const auto source = open_source(folder / "long", {});
    CHECK(contains(source->notes().warnings, "metadata.yaml lists long_5.db3, which is not there"));
    CHECK(contains(source->notes().warnings, "there is no message for 1.4"));
    CHECK(contains(source->notes().warnings, "between long_4.db3 and long_12.db3"));
    fs::remove(folder / "long/metadata.yaml");
    CHECK(contains(open_source(folder / "long", {})->notes().warnings, "there is no part 5"));
  }
}

TEST_CASE("a file per topic is one recording") {
  TemporaryFolder folder;
  Recording().write(folder / "a.bag");
  fs::create_directory(folder / "topics");
  split_by_topic(folder / "a.bag", folder / "topics");
  const std::vector<std::string> expected = measurements(*open_source(folder / "a.bag", {}));
  CHECK(measurements(*open_source(folder / "topics", {})) == expected);
  const std::vector<fs::path> both{folder / "topics/livox_imu.bag", folder / "topics/livox_lidar.bag"};
  CHECK(measurements(*open_source(both, {})) == expected);
  CHECK(contains(data_error([&] { open_source(std::vector<fs::path>{both[0], both[0]}, {}); }), "is named twice"));
}

TEST_CASE("recordings of different times in one folder are not mixed") {
  TemporaryFolder folder;
  Recording recording;
  recording.write(folder / "one.bag");
  recording.recorded = [](TimeNs stamp) { return stamp + 3600 * kSecond; };
  recording.imu_stamp = [](int, TimeNs stamp) { return stamp + 3600 * kSecond; };
  recording.write(folder / "two.bag");
  const std::string text = data_error([&] { open_source(folder.path(), {}); });
  CHECK(contains(text, "it holds several recordings, one and two are of different times"));
}

TEST_CASE("a folder without recordings says what is looked for") {
  TemporaryFolder folder;
  CHECK(contains(data_error([&] { open_source(folder.path(), {}); }), "this folder holds no recording"));
  CHECK(contains(data_error([&] { open_source(folder / "*.bag", {}); }), "no file matches this pattern"));
}

}  // namespace aslio::io::test
