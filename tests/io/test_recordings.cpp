// On the recordings in ASLIO_RECORDINGS_DIR, unpacked once into the build folder. Missing data fail the test.
#include <catch2/catch.hpp>
#include <ctime>

#include "../../framework/io/src/io/folder/open_folder.hpp"
#include "aslio/io/cdr.hpp"
#include "aslio/io/rosbag2/writer.hpp"
#include "io/bag_fixture.hpp"
#include "io/rewritten.hpp"
#include "recordings/unpacked.hpp"

namespace aslio::io::test {

TEST_CASE("the whole corridor of the Avia is read, fast") {
  const std::filesystem::path bag = aslio::test::unpacked_avia();
  const std::clock_t begin = std::clock();
  const auto source = open_source(bag, {});
  const Counts counts = drain(*source);
  const double cpu = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  CHECK(counts.packets == 265);
  CHECK(counts.imu == 5313);
  CHECK(counts.points == 5'967'664);
  CHECK(counts.dropped == 0);
  CHECK(source->status() == InputStatus::complete);
  CHECK(contains(source->notes().verdicts, "g (found"));
  CHECK(cpu < 26.6 * 0.02);  // a sanitizer build takes several times the 2 ms per second of data of a release build
}

TEST_CASE("the corridor is understood by inspection") {
  const InputReport report = inspect(aslio::test::unpacked_avia());
  CHECK(report.usable);
  REQUIRE(report.topics.size() == 2);
  CHECK(report.topics[0].rate == Approx(200).epsilon(1e-4));
  CHECK(report.topics[1].rate == Approx(10).epsilon(1e-4));
  CHECK(report.duration() == Approx(26.56));
}

TEST_CASE("the KITTI drive is read whole") {
  SensorConfig sensor;
  const auto source = open_source(aslio::test::unpacked_kitti(), sensor);
  const TimeNs begin = *source->begin_time();
  const Counts counts = drain(*source);
  CHECK(counts.packets == 154);
  CHECK(counts.imu == 154);
  CHECK(counts.points > 18'000'000);
  CHECK(begin == 1'317'042'272'283'701'593);
  CHECK(contains(source->notes().verdicts, "interpolated"));
}

/// Writes a recording in a container of its own, into `folder`; returns what is then read.
struct Container {
  const char* name;
  Encoding encoding;
  std::function<std::unique_ptr<MessageWriter>(const std::filesystem::path& folder)> open;
};

std::unique_ptr<MessageWriter> split_database(const std::filesystem::path& folder) {
  rosbag2::FolderOptions options;
  options.part_s = 6;
  options.make = [](const std::filesystem::path& stem) -> rosbag2::FolderOptions::OpenPart {
    const std::filesystem::path path = stem.string() + ".db3";
    return {std::make_unique<rosbag2::DatabaseWriter>(path), path.filename().string()};
  };
  return rosbag2::open_folder_writer(folder, options);
}

std::vector<Container> containers() {
  using Path = std::filesystem::path;
  const auto mcap = [](const char* compression) {
    return [compression](const Path& folder) {
      McapOptions options;
      options.compression = compression;
      options.chunk_bytes = 1U << 20U;
      return mcap_writer(folder / "all.mcap", options);
    };
  };
  const auto database = [](bool compress) {
    return [compress](const Path& folder) -> std::unique_ptr<MessageWriter> {
      return std::make_unique<rosbag2::DatabaseWriter>(folder / "all.db3", rosbag2::DatabaseOptions{true, compress});
    };
  };
  return {{"db3", Encoding::cdr, database(false)},
          {"db3, compressed messages", Encoding::cdr, database(true)},
          {"db3, five parts", Encoding::cdr, split_database},
          {"mcap, cdr, zstd", Encoding::cdr, mcap("zstd")},
          {"mcap, cdr, lz4", Encoding::cdr, mcap("lz4")},
          {"mcap, ros1msg, zstd", Encoding::ros1, mcap("zstd")}};
}

TEST_CASE("the corridor has the same measurements, to the bit, in every container") {
  const std::filesystem::path bag = aslio::test::unpacked_avia();
  const std::string expected = digest(*open_source(bag, {}));
  for (const Container& container : containers()) {
    INFO(container.name);
    const TemporaryFolder folder;
    const auto writer = container.open(folder.path());
    rosbag::BagReader reader(bag);
    CHECK(copy_messages(reader, *writer, container.encoding).empty());
    writer->close();
    CHECK(digest(*open_source(folder.path(), {})) == expected);
  }
  const TemporaryFolder topics;
  split_by_topic(bag, topics.path());
  CHECK(digest(*open_source(topics.path(), {})) == expected);
}

TEST_CASE("a drive of KITTI has the same measurements as a database") {
  const std::filesystem::path drive = aslio::test::unpacked_kitti("0013");
  SensorConfig sensor;
  sensor.model.sweep_period = 0.1;
  const TemporaryFolder folder;
  rosbag2::DatabaseWriter writer(folder / "all.db3");
  const auto reader = open_folder(drive, sensor);
  CHECK(copy_messages(*reader, writer, Encoding::cdr).empty());
  writer.close();
  CHECK(digest(*open_source(folder / "all.db3", sensor)) == digest(*open_source(drive, sensor)));
}

}  // namespace aslio::io::test
