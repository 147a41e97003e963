// Folders of scans with a table of an IMU.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <fstream>

#include "io/bag_fixture.hpp"
#include "io/folder_fixture.hpp"

namespace aslio::io::test {
namespace {

namespace fs = std::filesystem;

std::vector<LidarPacket> packets_of(const fs::path& path, const SensorConfig& sensor) {
  std::vector<LidarPacket> packets;
  const auto source = open_source(path, sensor);
  while (const auto measurement = source->next()) {
    if (const auto* packet = std::get_if<LidarPacket>(&*measurement)) packets.push_back(*packet);
  }
  return packets;
}

std::string refusal(const fs::path& path, const SensorConfig& sensor = {}) {
  return data_error([&] { packets_of(path, sensor); });
}

SensorConfig declared(const std::string& columns) {
  SensorConfig sensor;
  sensor.scan_columns = columns;
  return sensor;
}

}  // namespace

TEST_CASE("a folder of .bin scans and a table of an IMU is read as a bag is") {
  TemporaryFolder folder;
  ScanFolder made;
  made.write(folder.path());
  const auto source = open_source(folder.path(), declared(made.columns));
  CHECK(*source->begin_time() == kStart);
  CHECK(contains(source->notes().verdicts, "lidar stamps: by the names of the scans, ns"));
  CHECK(contains(source->notes().verdicts, "imu stamps: imu.csv, in ns"));
  CHECK(contains(source->notes().verdicts, "imu acceleration: m/s^2"));
  CHECK(contains(source->notes().verdicts, "imu rate: 100.0 Hz"));
  CHECK(contains(source->notes().verdicts, "field 'time' (float32), s, relative to the header stamp"));
  const Counts counts = drain(*source);
  CHECK(counts.packets == 10);
  CHECK(counts.imu == 100);
  CHECK(counts.points == 10 * 40);
  const auto packets = packets_of(folder.path(), declared(made.columns));
  for (std::size_t k = 0; k < packets.size(); ++k) {
    CHECK(packets[k].stamp == kStart + static_cast<TimeNs>(k) * kSecond / 10);
    CHECK(packets[k].points[39].line == 39 % 16);
    CHECK(std::abs(packets[k].points[39].t - packets[k].stamp - 97'500'000) < 10);
  }

  const InputReport report = inspect(folder.path(), declared(made.columns));
  CHECK(report.usable);
  CHECK(report.kind == "folder of scans");
  REQUIRE(report.topics.size() == 2);
  CHECK(report.topics[0].topic == "imu.csv");
  CHECK(report.topics[0].rate == Approx(100));
  CHECK(report.topics[1].topic == "lidar");
  CHECK(report.topics[1].messages == 10);
  CHECK(report.topics[1].points_per_message == Approx(40));
  CHECK(contains(report.topics[1].fields, "intensity float32, time float32, ring float32"));
}

TEST_CASE("stamps of scans are found in their names, whatever the unit") {
  const TimeNs ns = kStart + 123'000'000;
  struct Naming {
    std::string verdict;
    std::function<std::string(TimeNs)> name;
  };
  const std::vector<Naming> namings{
      {"names of the scans, ns", [](TimeNs t) { return fmt::format("{}", t); }},
      {"names of the scans, us", [](TimeNs t) { return fmt::format("{}", t / 1000); }},
      {"names of the scans, ms", [](TimeNs t) { return fmt::format("scan{}", t / 1'000'000); }},
      {"names of the scans, s and ns", [](TimeNs t) { return fmt::format("{}.{:09d}", t / kSecond, t % kSecond); }},
      {"names of the scans, s and ns", [](TimeNs t) { return fmt::format("{}.{}", t / kSecond, t % kSecond); }},
      {"names of the scans, s and ns", [](TimeNs t) { return fmt::format("cloud_{}_{}", t / kSecond, t % kSecond); }},
      {"names of the scans, s", [](TimeNs t) { return fmt::format("{:.3f}", to_seconds(t)); }}};
  for (const Naming& naming : namings) {
    TemporaryFolder folder;
    ScanFolder made;
    made.start = ns;
    made.name = naming.name;
    made.write(folder.path());
    const auto source = open_source(folder.path(), declared(made.columns));
    INFO(naming.verdict);
    CHECK(contains(source->notes().verdicts, naming.verdict));
    const auto packets = packets_of(folder.path(), declared(made.columns));
    REQUIRE(packets.size() == 10);
    for (std::size_t k = 0; k < 10; ++k) CHECK(packets[k].stamp == ns + static_cast<TimeNs>(k) * kSecond / 10);
  }
}

TEST_CASE("counted scans take their times from a list") {
  TemporaryFolder folder;
  ScanFolder made;
  made.counted = true;
  made.write(folder.path());
  CHECK(contains(refusal(folder.path(), declared(made.columns)),
                 "lidar: '0': the names of the scans are no times; name them by their stamps"));
  std::string plain, named = "name,stamp\n";
  for (int k = 0; k < 10; ++k) {
    plain += fmt::format("{:.6f}\n", to_seconds(k * kSecond / 10) + 1.6e9);
    named += fmt::format("{}.bin,{}\n", k, kStart / 1000 + k * 100'000);
  }
  for (const std::string& list : {plain, named}) {
    std::ofstream(folder / "timestamps.txt") << list;
    const auto packets = packets_of(folder.path(), declared(made.columns));
    REQUIRE(packets.size() == 10);
    for (std::size_t k = 0; k < 10; ++k) {
      CHECK(packets[k].stamp == kStart + static_cast<TimeNs>(k) * kSecond / 10);
      CHECK(packets[k].points[0].x == Approx(5 + static_cast<double>(k)));  // 10.bin is not before 2.bin
    }
  }
  std::ofstream(folder / "lidar/times.txt") << "0.1\n0.2\n";
  CHECK(contains(refusal(folder.path(), declared(made.columns)), "times.txt: 2 times for the 10 scans of "));
  std::ofstream(folder / "lidar/times.txt") << "0.1\nnever\n";
  CHECK(contains(refusal(folder.path(), declared(made.columns)), "times.txt:2: 'never' is no time"));
  fs::remove(folder / "lidar/times.txt");
  std::ofstream(folder / "timestamps.txt") << "3.bin 0.1\n";
  CHECK(contains(refusal(folder.path(), declared(made.columns)), "timestamps.txt: no line for 0.bin"));
}

TEST_CASE("columns of an IMU are found by their names") {
  const std::vector<std::string> headers{
      "timestamp,wx,wy,wz,ax,ay,az",
      "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],a_RS_S_x [m s^-2],a_RS_S_y [m "
      "s^-2],a_RS_S_z [m s^-2]",
      "Time, Gyro_X, Gyro_Y, Gyro_Z, Accel_X, Accel_Y, Accel_Z",
      "t;gyr.x;gyr.y;gyr.z;acc.x;acc.y;acc.z",
      "field.header.stamp,field.angular_velocity.x,field.angular_velocity.y,field.angular_velocity.z,"
      "field.linear_acceleration.x,field.linear_acceleration.y,field.linear_acceleration.z",
      "# timestamp wx wy wz ax ay az",
      "GPSTime,angvel_x,angvel_y,angvel_z,accelx,accely,accelz"};
  for (const std::string& header : headers) {
    TemporaryFolder folder;
    ScanFolder made;
    made.imu_header = header;
    made.write(folder.path());
    INFO(header);
    const auto source = open_source(folder.path(), declared(made.columns));
    while (const auto measurement = source->next()) {
      const auto* sample = std::get_if<ImuSample>(&*measurement);
      if (sample == nullptr) continue;
      CHECK(sample->t == kStart);
      CHECK(sample->gyro.isApprox(Vec3(0.01, 0.02, 0.03)));
      CHECK(sample->acc.isApprox(Vec3(0.1, 0.2, 9.8)));
      break;
    }
  }
}

TEST_CASE("the time of an IMU may be in s, ms, us, ns, or s and ns apart") {
  const std::vector<std::pair<std::string, std::function<std::string(TimeNs)>>> times{
      {"in s", [](TimeNs t) { return fmt::format("{}.{:09d}", t / kSecond, t % kSecond); }},
      {"in s", [](TimeNs t) { return fmt::format("{}.{:09d}e0", t / kSecond, t % kSecond); }},
      {"in ms", [](TimeNs t) { return fmt::format("{}", t / 1'000'000); }},
      {"in us", [](TimeNs t) { return fmt::format("{}", t / 1000); }},
      {"columns of s and ns", [](TimeNs t) { return fmt::format("{},{}", t / kSecond, t % kSecond); }}};
  for (const auto& [verdict, time] : times) {
    TemporaryFolder folder;
    ScanFolder made;
    made.imu_time = time;
    if (verdict.starts_with("columns")) made.imu_header = "#sec,nsec,wx,wy,wz,ax,ay,az";
    made.write(folder.path());
    const auto source = open_source(folder.path(), declared(made.columns));
    INFO(verdict);
    CHECK(contains(source->notes().verdicts, "imu stamps: imu.csv, " + verdict));
    CHECK(*source->begin_time() == kStart);
    CHECK(contains(source->notes().verdicts, "imu rate: 100.0 Hz"));
    CHECK(drain(*source).imu == 100);
  }
}

TEST_CASE("a table of an IMU that cannot be read says why, and where") {
  TemporaryFolder folder;
  ScanFolder made;
  made.write(folder.path());
  const SensorConfig sensor = declared(made.columns);
  const std::string header = "timestamp,wx,wy,wz,ax,ay,az\n";
  const auto table = [&](const std::string& text) { std::ofstream(folder / "imu.csv") << text; };
  table(header + "1600000000000000000,0,0,0,0,0,9.8\n1600000000010000000,0,0,zero,0,0,9.8\n");
  CHECK(contains(refusal(folder.path(), sensor), "imu.csv:3: 'zero' in column 4 is no number"));
  table(header + "1600000000000000000,0,0\n1600000000010000000,0,0,0,0,0,9.8\n");
  CHECK(contains(refusal(folder.path(), sensor), "imu.csv:2: it has 3 columns, not 7"));
  table(header + "1600000000000000000,0,0,0,0,0,9.8\n1600000001000000000,0,0,0,0,0,9.8\n");
  CHECK(contains(refusal(folder.path(), sensor), "imu.csv: the steps of its times are those of an IMU"));
  table(header + std::string(5000, '1') + "\n");
  CHECK(contains(refusal(folder.path(), sensor), "imu.csv:2: the line is longer than 4095 characters"));
  table(header);
  CHECK(contains(refusal(folder.path(), sensor), "imu.csv: there is no IMU sample"));
  table("1600000000000000000,0,0,0,0,0,9.8\n");
  CHECK(contains(refusal(folder.path(), sensor), "there is no IMU in this folder of scans: put a table"));
  CHECK_FALSE(inspect(folder.path(), sensor).usable);
  table("1600000000000000000,0.5,0,0,0,0,9.8\n1600000000010000000,0,0,0,0,0,9.8\n1600000000020000000,0,0");
  SensorConfig named = sensor;
  named.imu_columns = "timestamp wx wy wz ax ay az";
  const auto source = open_source(folder.path(), named);
  CHECK(contains(source->notes().warnings, "imu.csv: the last line is cut off"));
  CHECK(drain(*source).imu == 2);
}

TEST_CASE("scans without point times are asked for as in a bag") {
  TemporaryFolder folder;
  ScanFolder made;
  made.columns = "x y z intensity";
  made.write(folder.path());
  CHECK(contains(refusal(folder.path(), declared(made.columns)),
                 "record with per-point times, check `sweep_period`, or set `require_point_times: false`"));
  SensorConfig sensor = declared(made.columns);
  sensor.require_point_times = false;
  const auto source = open_source(folder.path(), sensor);
  CHECK(contains(source->notes().warnings, "all points take the header stamp, no motion correction"));
  CHECK(drain(*source).points == 400);
}

TEST_CASE("scans may lie in the folder itself, and a list beside it") {
  TemporaryFolder folder;
  ScanFolder made;
  made.counted = true;
  made.lidar_folder = "walk";
  made.imu_file = "walk/imu.csv";
  made.write(folder.path());
  std::string list;
  for (int k = 0; k < 10; ++k) list += fmt::format("{}\n", kStart + k * kSecond / 10);
  folder.write("timestamps.txt", list);
  for (const fs::path& path : {folder / "walk", folder / "walk/"}) {
    const InputReport report = inspect(path, declared(made.columns));
    CHECK(report.usable);
    REQUIRE(report.topics.size() == 2);
    CHECK(report.topics[1].topic == "walk");
    CHECK(report.begin == kStart);
  }
}

TEST_CASE("PCD and PLY scans tell their columns") {
  for (const std::string extension : {".pcd", ".ply"}) {
    TemporaryFolder folder;
    ScanFolder made;
    made.extension = extension;
    made.write(folder.path());
    const auto source = open_source(folder.path(), {});
    INFO(extension);
    CHECK(contains(source->notes().verdicts, "field 'time' (float32), s, relative to the header stamp"));
    const Counts counts = drain(*source);
    CHECK(counts.packets == 10);
    CHECK(counts.points == 400);
  }
}

TEST_CASE("a folder that holds no recording says what it holds and what is expected") {
  TemporaryFolder folder;
  CHECK(contains(refusal(folder.path()), "it holds nothing; expected is a bag, or one of:"));
  folder.write("notes.txt", "1 2 3\n");
  folder.write("a.png", "");
  folder.write("b.png", "");
  fs::create_directories(folder / "images");
  const std::string text = refusal(folder.path());
  CHECK(contains(text, "it holds 2 .png, 1 .txt, images/; expected"));
  CHECK(contains(text, "KITTI raw drive: velodyne_points/ and oxts/"));
  CHECK(contains(data_error([&] { inspect(folder.path()); }), "it holds 2 .png"));
  ScanFolder().write(folder.path());
  CHECK(contains(refusal(folder.path()), "name them in `scan_columns` of the sensor file"));
  CHECK(contains(refusal(folder.path()), "its 960 bytes are points of 3 or 4 or 5 or 6 or 8 or 10 numbers of 4 bytes"));
  std::ofstream(folder / "lidar/1600000000000000000.pcd") << "x";
  CHECK(contains(refusal(folder.path(), declared("x y z i t r")), "scans of two formats"));
}

TEST_CASE("a scan that is cut short, and clocks that do not meet") {
  TemporaryFolder folder;
  ScanFolder made;
  made.write(folder.path());
  fs::resize_file(folder / fmt::format("lidar/{}.bin", kStart + kSecond / 2), 24 * 7 + 5);
  const SensorConfig sensor = declared(made.columns);
  const auto source = open_source(folder.path(), sensor);
  CHECK(drain(*source).points == 9 * 40 + 7);
  CHECK(source->status() == InputStatus::truncated);
  CHECK(contains(source->notes().warnings, "500000000.bin: the file ends inside a point"));
  CHECK(inspect(folder.path(), sensor).status == InputStatus::truncated);

  ScanFolder late;
  late.imu_shift = 100 * kSecond;
  late.write(folder.path());
  CHECK(contains(refusal(folder.path(), sensor), "do not meet: their clocks differ, or they are of two recordings"));
}

}  // namespace aslio::io::test
