#include <sys/syscall.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cerrno>
#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>

#include "aslio/core/errors.hpp"
#include "aslio/io/cloud_file.hpp"
#include "aslio/io/json.hpp"
#include "aslio/io/source.hpp"
#include "aslio/io/writers.hpp"
#include "io/bag_fixture.hpp"

namespace {

int synced = 0;
bool sync_fails = false;

}  // namespace

/// Stands before that of the C library: what is asked to be on the disk, and a disk that says no.
extern "C" int fsync(int file) {
  ++synced;
  if (!sync_fails) return static_cast<int>(::syscall(SYS_fsync, file));
  errno = EIO;
  return -1;
}

namespace aslio::io::test {
namespace {

std::string text_of(const std::filesystem::path& path) {
  const auto bytes = read_bytes(path);
  return {bytes.begin(), bytes.end()};
}

std::size_t entries(const std::filesystem::path& folder) {
  return static_cast<std::size_t>(
      std::distance(std::filesystem::directory_iterator(folder), std::filesystem::directory_iterator()));
}

}  // namespace

TEST_CASE("a file stands under its name only once it is whole") {
  TemporaryFolder folder;
  {
    AtomicFile file(folder / "a.txt");
    file.write("half");
    CHECK_FALSE(std::filesystem::exists(folder / "a.txt"));
  }
  CHECK(entries(folder.path()) == 0);
  AtomicFile file(folder / "a.txt");
  file.write("0000 and the rest");
  file.patch(0, "1234");
  file.write(".");
  CHECK(file.position() == 18);
  CHECK_THROWS_AS(file.patch(16, "abc"), DataError);
  file.close();
  CHECK(text_of(folder / "a.txt") == "1234 and the rest.");
  CHECK(entries(folder.path()) == 1);
}

TEST_CASE("a file that tells that others are whole is on the disk before it has its name") {
  const TemporaryFolder folder;
  AtomicFile file(folder / "a.txt");
  file.write("whole");
  const int before = synced;
  file.close_durably();
  CHECK(synced == before + 1);
  CHECK(text_of(folder / "a.txt") == "whole");
  sync_fails = true;
  const auto write = [&] {
    AtomicFile torn(folder / "b.txt");
    torn.write("not on the disk");
    torn.close_durably();
  };
  CHECK(contains(data_error(write), "b.txt: cannot write"));
  sync_fails = false;
  CHECK(entries(folder.path()) == 1);
  AtomicFile device("/dev/null");
  CHECK_NOTHROW(device.close_durably());
}

TEST_CASE("what a killed process left is removed by the next to write that name, once it is old") {
  const TemporaryFolder folder;
  const auto leave = [&](const std::string& name, int hours) {
    std::ofstream(folder / name) << "half";
    const auto then = std::filesystem::file_time_type::clock::now() - std::chrono::hours(hours);
    std::filesystem::last_write_time(folder / name, then);
    return folder / name;
  };
  // No process has the first number.
  const std::string dead = "2147483647", own = std::to_string(::getpid());
  const std::vector<std::filesystem::path> gone{leave("a.txt." + dead + "-0.part", 2),
                                                leave("a.txt." + dead + "-17.part", 2)};
  std::vector<std::filesystem::path> stay{leave("a.txt." + dead + "-1.part", 0),   // of another machine, perhaps
                                          leave("a.txt." + own + "-7.part", 2),    // its process lives
                                          leave("b.txt." + dead + "-0.part", 2)};  // of another file
  // Names that no AtomicFile of a.txt gives.
  for (const std::string& name :
       {"b." + dead + "-0.part", dead + "-0.part.bak", dead + "-0x.part", dead + ".part", "-" + dead + "-0.part",
        "0" + dead + "-0.part", std::string("99999999999999-0.part"), std::string("part")}) {
    stay.push_back(leave("a.txt." + name, 2));
  }
  AtomicFile file(folder / "a.txt");
  file.write("whole");
  file.close();
  CHECK(text_of(folder / "a.txt") == "whole");
  for (const auto& path : gone) CHECK_FALSE(std::filesystem::exists(path));
  for (const auto& path : stay) {
    INFO(path);
    CHECK(std::filesystem::exists(path));
  }
}

TEST_CASE("a full disk and an unwritable folder are errors that name the path") {
  const auto fill = [] {
    AtomicFile file("/dev/full");
    for (int i = 0; i < 100; ++i) file.write(std::string(10'000, 'x'));
    file.close();
  };
  CHECK(contains(data_error(fill), "/dev/full: cannot write: No space left"));
  AtomicFile lacking("/dev/full");
  const auto overfill = [&] {
    for (int i = 0; i < 100; ++i) lacking.write(std::string(10'000, 'x'));
  };
  CHECK(contains(data_error(overfill), "No space left"));
  CHECK(contains(data_error([&] { lacking.close(); }), "No space left"));  // though nothing is left to be written
  const auto late = [] {
    AtomicFile file("/dev/full");
    file.write("small enough for the buffer");
    file.close();
  };
  CHECK(contains(data_error(late), "No space left"));
  TemporaryFolder folder;
  CHECK(contains(data_error([&] { AtomicFile file(folder.path() / "absent" / "a.txt"); }), "create the folder first"));
  CHECK(contains(data_error([&] { AtomicFile file(folder.path()); }), "Is a directory"));
  if (::geteuid() != 0) {  // root may write anywhere
    std::filesystem::permissions(folder.path(),
                                 std::filesystem::perms::owner_read | std::filesystem::perms::owner_exec);
    CHECK(contains(data_error([&] { AtomicFile file(folder / "a.txt"); }), "Permission denied"));
    std::filesystem::permissions(folder.path(), std::filesystem::perms::owner_all);
  }
  CHECK(contains(data_error([] { AtomicFile file("/proc/a.txt"); }), "/proc/a.txt: cannot create"));
}

TEST_CASE("a trajectory comes back from TUM with exact times") {
  TemporaryFolder folder;
  std::mt19937_64 random(3);
  std::vector<StampedPose> poses;
  for (int i = 0; i < 200; ++i) {
    StampedPose pose;
    pose.t = 1'600'000'000 * kSecond + static_cast<TimeNs>(random() % 1'000'000'000) + i * kSecond;
    const auto unit = [&] { return static_cast<double>(random() % 2001) / 1000.0 - 1.0; };
    pose.T = {exp_so3(3.0 * Vec3(unit(), unit(), unit())), 100.0 * Vec3(unit(), unit(), unit())};
    poses.push_back(pose);
  }
  poses.insert(poses.begin(), StampedPose{-1'500'000'001, {}});
  write_tum(folder / "t.tum", poses);
  const auto back = read_tum(folder / "t.tum");
  REQUIRE(back.size() == poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    REQUIRE(back[i].t == poses[i].t);
    REQUIRE(back[i].T.p == poses[i].T.p);
    REQUIRE((back[i].T.R - poses[i].T.R).norm() < 1e-14);
  }
}

TEST_CASE("lines of TUM and KITTI") {
  StampedPose pose{1'600'000'000'000'000'001, {exp_so3(Vec3(0, 0, 4.0)), Vec3(1, -2.5, 0.1)}};
  const std::string line = tum_line(pose);
  CHECK(line.starts_with("1600000000.000000001 1 -2.5 0.1 "));
  CHECK(line.back() == '\n');
  CHECK(std::stod(line.substr(line.rfind(' '))) > 0);  // w
  CHECK(kitti_line({Mat3::Identity(), Vec3(1, 2, 3)}) == "1 0 0 1 0 1 0 2 0 0 1 3\n");
  TemporaryFolder folder;
  const std::vector<StampedPose> two{pose, pose};
  write_kitti(folder / "k.txt", two);
  CHECK(text_of(folder / "k.txt") == kitti_line(pose.T) + kitti_line(pose.T));
}

TEST_CASE("errors in a TUM file name the line") {
  TemporaryFolder folder;
  const auto error = [&](const std::string& line) {
    std::ofstream(folder / "t.tum") << "# comment\n0 0 0 0 0 0 0 1\n\n" << line << '\n';
    return data_error([&] { read_tum(folder / "t.tum"); });
  };
  CHECK(error("1.5 1 2 3 0 0 0 1").empty());
  CHECK(error("1.60000000012345678e+09 1 2 3 0 0 0 1").empty());
  CHECK(contains(error("1 2 3"), "t.tum:4: 3 columns"));
  CHECK(contains(error("1 2 3 4 0 0 0 1 9"), "9 columns"));
  CHECK(contains(error("1,5 1 2 3 0 0 0 1"), "not a time in seconds: '1,5'"));
  CHECK(contains(error("1600000000123456789 1 2 3 0 0 0 1"),
                 "t.tum:4: not a time in seconds, but as it seems in nanoseconds: divide the stamps by 1e9: '16"));
  CHECK(contains(error("1600000000123456 1 2 3 0 0 0 1"), "microseconds: divide the stamps by 1e6"));
  CHECK(contains(error("1600000000123 1 2 3 0 0 0 1"), "milliseconds: divide the stamps by 1e3"));
  // Two times that are farther away would have a difference of more than 63 bits.
  CHECK(error("4600000000 1 2 3 0 0 0 1").empty());
  for (const std::string far : {"4600000001", "-4600000001", "4.7e9", "-9e9"}) {
    CHECK(contains(error(far + " 1 2 3 0 0 0 1"), "t.tum:4: not a time in seconds: '" + far + "'"));
  }
  for (const std::string late : {"0 1 2 3 0 0 0 1", "-1.5 1 2 3 0 0 0 1"}) {
    CHECK(contains(error(late),
                   "t.tum:4: its time is not later than 0.000000000 s of the pose before: sort the poses and remove "
                   "duplicates: '" +
                       late + "'"));
  }
  std::ofstream(folder / "empty.tum") << "# only a comment\n";
  CHECK(contains(data_error([&] { read_tum(folder / "empty.tum"); }), "empty.tum: holds no pose: is it the right"));
  CHECK(contains(error("1 nan 2 3 0 0 0 1"), "not a finite number: 'nan'"));
  CHECK(contains(error("1 1 2 x 0 0 0 1"), "t.tum:4: not a finite number: 'x'"));
  CHECK(contains(error("1 1 2 3 0 0 0 0"), "norm 0"));
  CHECK(contains(data_error([&] { read_tum(folder / "absent"); }), "absent"));
}

TEST_CASE("what is nested too deep to be walked is no JSON") {
  const auto nested = [](std::size_t depth) { return std::string(depth, '[') + std::string(depth, ']'); };
  CHECK(parse_json(nested(60)).has_value());
  CHECK_FALSE(parse_json(nested(70)).has_value());
  CHECK_FALSE(parse_json(nested(1'000'000)).has_value());
  CHECK_FALSE(parse_json("{").has_value());
  CHECK(parse_json(R"({"a": [1, {"b": null}]})")->dump() == R"({"a":[1,{"b":null}]})");
}

TEST_CASE("maps are written and read back") {
  const std::string name = GENERATE("map.ply", "map.pcd");
  const int count = GENERATE(0, 1000);
  TemporaryFolder folder;
  const auto writer = open_map_writer(folder / name);
  for (int i = 0; i < count; ++i) {
    writer->add({static_cast<float>(i), -0.5F, 1e-3F * static_cast<float>(i)}, static_cast<float>(i % 7));
  }
  CHECK_FALSE(std::filesystem::exists(folder / name));
  writer->close();
  const std::string text = text_of(folder / name);
  const std::string end = name == "map.ply" ? "end_header\n" : "DATA binary\n";
  CHECK(text.size() == text.find(end) + end.size() + 16 * static_cast<std::size_t>(count));
#ifdef ASLIO_TEST_PCL
  if (count == 0) return;  // PCL refuses empty clouds
  const auto points = read_cloud(folder / name);
  REQUIRE(points.size() == 1000);
  CHECK(points[999].p == Eigen::Vector3f(999.0F, -0.5F, 1e-3F * 999.0F));
  CHECK(points[999].intensity == 5.0F);
#endif
}

TEST_CASE("unknown map formats are refused") {
  TemporaryFolder folder;
  CHECK_THROWS_AS(open_map_writer(folder / "map.xyz"), ConfigError);
  CHECK_THROWS_AS(read_cloud(folder / "map.xyz"), ConfigError);
#ifdef ASLIO_TEST_PCL
  const auto refusal = [&](const std::string& name, const std::string& text) {
    write_bytes(folder / name, std::vector<std::uint8_t>(text.begin(), text.end()));
    return data_error([&] { read_cloud(folder / name); });
  };
  CHECK(contains(refusal("bad.pcd", "no"), "bad.pcd: not a PCD file: its header lacks 'FIELDS'"));
  CHECK(contains(refusal("bad.ply", "ply\nformat ascii"), "lacks 'element vertex'"));
  const std::string head = "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n";
  CHECK(
      contains(refusal("big.pcd", head + "WIDTH 4000000000\nHEIGHT 4000000000\nPOINTS 1\nDATA binary\n"), "too short"));
  CHECK(contains(refusal("big.ply", "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nend_header\n"),
                 "too short"));
#endif
}

TEST_CASE("the digest depends on every byte") {
  TemporaryFolder folder;
  write_bytes(folder / "a", {'a', 'b', 'c'});
  CHECK(input_digest(folder / "a") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  std::filesystem::create_directory(folder / "d");
  write_bytes(folder.path() / "d" / "x", {'1'});
  const std::string before = input_digest(folder / "d");
  std::filesystem::rename(folder.path() / "d" / "x", folder.path() / "d" / "y");
  CHECK(input_digest(folder / "d") != before);
}

}  // namespace aslio::io::test
