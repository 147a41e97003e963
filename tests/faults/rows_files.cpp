// Faults 53 to 61: files that are damaged, or not what they should be.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <fstream>

#include "aslio/core/errors.hpp"
#include "aslio/io/source.hpp"
#include "faults/table.hpp"

namespace aslio::test::faults {
namespace {

namespace fs = std::filesystem;
using io::rosbag::Compression;

/// A short part of the walk is enough where a file is damaged.
Fault two_seconds() { return keep({0, 2}); }

std::function<Outcome()> with(How how) {
  return [how = std::move(how)] { return run_with(two_seconds(), how); };
}

std::function<void(const fs::path&)> overwritten(std::size_t at, std::vector<std::uint8_t> bytes) {
  return [at, bytes = std::move(bytes)](const fs::path& bag) {
    std::fstream file(bag, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(static_cast<std::streamoff>(at));
    file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  };
}

std::function<void(const fs::path&)> flipped(std::size_t at, unsigned bit) {
  return [=](const fs::path& bag) {
    std::string bytes = content(bag);
    bytes.at(at) = static_cast<char>(static_cast<unsigned char>(bytes.at(at)) ^ (1U << bit));
    write_text(bag, bytes);
  };
}

/// Where the record of the first chunk begins: after the line of the version and the padded bag header.
constexpr std::size_t kFirstChunk = 4109;

/// The first chunk claims so many bytes.
void claim(const fs::path& bag, std::uint32_t size) {
  const std::size_t at = content(bag).find("size=", kFirstChunk);
  REQUIRE(at != std::string::npos);
  std::vector<std::uint8_t> bytes(4);
  std::memcpy(bytes.data(), &size, 4);
  overwritten(at + 5, bytes)(bag);
}

double peak_mb() {
  std::ifstream file("/proc/self/status");
  std::string word;
  while (file >> word && word != "VmHWM:") {
  }
  double kilobytes = 0;
  file >> kilobytes;
  return kilobytes * 1024e-6;
}

/// What reading a bag adds to the largest memory of this process [MB].
double growth_of_reading(const std::function<void(const fs::path&)>& damage) {
  const TemporaryFolder folder;
  const fs::path bag = folder / "damaged.bag";
  write_bag(bag, altered(clean_walk().data, two_seconds()));
  damage(bag);
  std::ofstream("/proc/self/clear_refs") << "5";
  const double before = peak_mb();
  try {
    const auto source = io::open_source(bag, {});
    while (source->next()) {
    }
  } catch (const DataError&) {  // is one way to end
  }
  return peak_mb() - before;
}

/// Sizes of some messages that contradict their bytes, each in another way.
void contradict(io::rosbag::CloudLayout& layout, std::vector<std::uint8_t>& data, std::size_t index) {
  switch (index) {
    case 4:
      layout.fields[2].offset = layout.point_step;
      return;
    case 7:
      layout.point_step = 0xFFFFFFFF;
      return;
    case 10:
      layout.row_step = 8;
      layout.height = 3;
      return;
    case 13:
      layout.width = 0xFFFFFFFF;
      layout.height = 0xFFFFFFFF;
      return;
    case 16:
      data.resize(data.size() / 2);
      return;
    default:
      return;
  }
}

std::vector<Row> damaged() {
  std::vector<Row> rows;
  rows.push_back(
      {.number = 53,
       .name = "bag_truncated_mid_chunk",
       .injected = "the bag ends after 60 % of its bytes",
       .expected = {.status = {"truncated"}, .exit = {3}, .counters = {{"packets", 8}}},
       .run = with({.damage = [](const fs::path& bag) { fs::resize_file(bag, fs::file_size(bag) * 6 / 10); }}),
       .also = "poses of the complete part are there",
       .check = [](const Outcome& o) { CHECK(o.times.size() >= 8); }});
  rows.push_back({.number = 54,
                  .name = "bag_index_missing",
                  .injected = "the bag has no index, as after a recorder was killed",
                  .expected = {.status = {"ok", "truncated"}, .exit = {0, 3}},
                  .run = with({.form = {.options = {Compression::none, 768 * 1024, false}}}),
                  .also = "the trajectory equals that with an index, to the last byte",
                  .check = [](const Outcome& o) { CHECK((o.trajectory == run_with(two_seconds()).trajectory)); }});
  rows.push_back(
      {.number = 55,
       .name = "bag_bitflip_header",
       .injected = "one bit is flipped in the first bytes of the file; and at ten other places of its headers",
       .expected = {.exit = {3}},
       .run = with({.damage = flipped(3, 2)}),
       .also = "the other ten end with exit code 0, 3 or 4",
       .check = [](const Outcome&) {
         for (const std::size_t at : {8, 13, 14, 20, 30, 45, 4109, 4113, 4118, 4130}) {
           CAPTURE(at);
           const Outcome o = run_with(keep({0, 1}), {.damage = flipped(at, 4)});
           CHECK((o.exit_code == 0 || o.exit_code == 3 || o.exit_code == 4));
         }
       }});
  const auto longest = overwritten(kFirstChunk, {0xFF, 0xFF, 0xFF, 0xFF});
  rows.push_back({.number = 56,
                  .name = "length_field_0xFFFFFFFF",
                  .injected = "the length of a header is 0xFFFFFFFF",
                  .expected = {.exit = {3}},
                  .run = with({.damage = longest}),
                  .also = "reading it takes less than 64 MB",
                  .check = [longest](const Outcome&) { CHECK(growth_of_reading(longest) < 64); }});
  const auto bomb = [](const fs::path& bag) { claim(bag, 100U << 20U); };
  rows.push_back({.number = 57,
                  .name = "chunk_decompress_bomb",
                  .injected = "a compressed chunk claims to hold 100 MB",
                  .expected = {.exit = {3}, .says = {"104857600 declared"}},
                  .run = with({.form = {.options = {Compression::lz4, 768 * 1024, true}}, .damage = bomb})});
  return rows;
}

std::vector<Row> of_another_kind() {
  std::vector<Row> rows;
  rows.push_back({.number = 58,
                  .name = "topic_wrong_type",
                  .injected = "the sensor file swaps the topics",
                  .expected = {.exit = {3}, .says = {"look swapped"}},
                  .run = with({.sensor_lines = {"lidar_topic: /imu", "imu_topic: /points"}})});
  rows.push_back(
      {.number = 59,
       .name = "md5_def_mismatch",
       .injected = "the LiDAR topic carries another version of the message",
       .expected = {.exit = {3}, .says = {"checksum"}},
       .run = with({.sensor_lines = {"lidar_topic: /points"},
                    .form = {.lidar_type = {io::rosbag::kPointCloud2.name, "0123456789abcdef0123456789abcdef",
                                            io::rosbag::kPointCloud2.definition}}})});
  rows.push_back(
      {.number = 60,
       .name = "pointcloud2_sizes_overflow",
       .injected = "sizes of five clouds contradict their bytes: an offset, point_step, row_step, width * height, data",
       .expected = {.status = {"degraded"}, .counters = {{"malformed_messages", 5}}, .says = {"malformed"}},
       .run = with({.form = {.edit = &contradict}})});
  rows.push_back({.number = 61,
                  .name = "big_endian_flag",
                  .injected = "clouds of little-endian values are flagged big-endian",
                  .expected = {.status = {"ok"}, .says = {"they are little-endian and are read so"}},
                  .run = with({.form = {.edit = [](io::rosbag::CloudLayout& layout, std::vector<std::uint8_t>&,
                                                   std::size_t) { layout.is_bigendian = true; }}})});
  return rows;
}

}  // namespace

std::vector<Row> file_rows() {
  std::vector<Row> rows = damaged();
  for (Row& row : of_another_kind()) rows.push_back(std::move(row));
  return rows;
}

}  // namespace aslio::test::faults
