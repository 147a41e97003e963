#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <numbers>

#include "io/bag_fixture.hpp"

namespace aslio::io::test {
namespace {

namespace fs = std::filesystem;

std::string stamp(int ns) { return fmt::format("2011-09-26 13:04:32.{:09d}\n", ns); }

void write_packet(const fs::path& oxts, int i, double turning = -1) {
  fs::create_directories(oxts / "data");
  std::ofstream packet(oxts / "data" / fmt::format("{:010d}.txt", i));
  for (int column = 0; column < 30; ++column) {
    packet << (column == 13 ? 9.8 : turning < 0 ? 0.01 * column : column == 17 ? turning : 0.0) << ' ';
  }
}

/// Twelve points 30 degrees apart, from ahead over the left.
std::vector<float> ring_of_points() {
  std::vector<float> points;
  for (int i = 0; i < 12; ++i) {
    const double angle = i * std::numbers::pi / 6 + (i == 6 ? 1e-7 : 0);  // the rear is passed at the begin of a scan
    points.insert(points.end(), {static_cast<float>(5 * std::cos(angle)), static_cast<float>(5 * std::sin(angle)), 0,
                                 0.1F * static_cast<float>(i)});
  }
  return points;
}

/// A drive of five scans and IMU at 10 Hz.
fs::path write_drive(const fs::path& root, int missing_scan = -1) {
  const fs::path drive = root / "2011_09_26" / "2011_09_26_drive_0001_sync";
  fs::create_directories(drive / "velodyne_points" / "data");
  fs::create_directories(drive / "oxts" / "data");
  std::ofstream start(drive / "velodyne_points" / "timestamps_start.txt");
  std::ofstream end(drive / "velodyne_points" / "timestamps_end.txt");
  std::ofstream imu(drive / "oxts" / "timestamps.txt");
  for (int i = 0; i < 5; ++i) {
    start << stamp(i * 100'000'000);
    end << stamp((i + 1) * 100'000'000);
    imu << stamp(i * 100'000'000 + 50'000'000);
    write_packet(drive / "oxts", i);
    if (i == missing_scan) continue;
    std::ofstream scan(drive / "velodyne_points" / "data" / fmt::format("{:010d}.bin", i), std::ios::binary);
    const std::vector<float> points = ring_of_points();
    scan.write(reinterpret_cast<const char*>(points.data()), static_cast<std::streamsize>(points.size() * 4));
  }
  std::ofstream(root / "2011_09_26" / "calib_imu_to_velo.txt")
      << "calib_time: x\nR: 1 0 0 0 1 0 0 0 1\nT: -0.8 0.3 -0.7\n";
  return drive;
}

/// The same drive as it was recorded: scans as text, IMU at 100 Hz.
fs::path write_unsynchronised(const fs::path& root) {
  const fs::path drive = root / "2011_09_26" / "2011_09_26_drive_0001_extract";
  fs::create_directories(drive.parent_path());
  fs::copy(write_drive(root), drive, fs::copy_options::recursive);
  fs::remove_all(drive / "oxts");
  fs::remove_all(drive / "velodyne_points/data");
  fs::create_directories(drive / "oxts/data");
  fs::create_directories(drive / "velodyne_points/data");
  std::ofstream imu(drive / "oxts" / "timestamps.txt");
  for (int i = 0; i < 50; ++i) {
    imu << stamp(i * 10'000'000 + 5'000'000);
    write_packet(drive / "oxts", i);
  }
  const std::vector<float> points = ring_of_points();
  for (int i = 0; i < 5; ++i) {
    std::ofstream scan(drive / "velodyne_points" / "data" / fmt::format("{:010d}.txt", i));
    for (std::size_t p = 0; p < points.size(); p += 4) {
      scan << fmt::format("{} {} {} {}\n", points[p], points[p + 1], points[p + 2], points[p + 3]);
    }
  }
  return drive;
}

std::vector<LidarPacket> packets_of(const fs::path& drive, const SensorConfig& sensor) {
  std::vector<LidarPacket> packets;
  const auto source = open_source(drive, sensor);
  while (const auto measurement = source->next()) {
    if (const auto* packet = std::get_if<LidarPacket>(&*measurement)) packets.push_back(*packet);
  }
  return packets;
}

SensorConfig calibrated() {
  SensorConfig sensor;
  sensor.model.T_imu_lidar.p = Vec3(0.8, -0.3, 0.7);
  sensor.from_file = true;
  return sensor;
}

}  // namespace

TEST_CASE("a drive is found from its folder, its date and its root") {
  TemporaryFolder folder;
  const fs::path drive = write_drive(folder.path());
  for (const fs::path& path : {drive, drive.parent_path(), folder.path()}) {
    const auto source = open_source(path, calibrated());
    const Counts counts = drain(*source);
    CHECK(counts.packets == 5);
    CHECK(counts.imu == 5);
    CHECK(contains(source->notes().verdicts, "IMU at 10.0 Hz: interpolated"));
    CHECK_FALSE(contains(source->notes().warnings, "calib_imu_to_velo"));
  }
  SensorConfig other;
  CHECK_FALSE(
      contains(open_source(drive, other)->notes().warnings, "calib_imu_to_velo"));  // no sensor file to be wrong
  CHECK_FALSE(contains(inspect(drive).warnings, "calib_imu_to_velo"));
  other.from_file = true;
  CHECK(contains(open_source(drive, other)->notes().warnings, "calib_imu_to_velo"));
  fs::create_directories(folder / "other/velodyne_points");
  fs::create_directories(folder / "other/oxts");
  CHECK(contains(data_error([&] { open_source(folder.path(), {}); }), "contains 2 drives"));
}

TEST_CASE("points are timed by azimuth: from the rear over the left, the sensor turning clockwise") {
  TemporaryFolder folder;
  const auto source = open_source(write_drive(folder.path()), calibrated());
  while (const auto measurement = source->next()) {
    const auto* packet = std::get_if<LidarPacket>(&*measurement);
    if (packet == nullptr) {
      CHECK(std::get<ImuSample>(*measurement).gyro.isApprox(Vec3(0.17, 0.18, 0.19)));
      continue;
    }
    REQUIRE(packet->points.size() == 12);
    CHECK(packet->points[0].t - packet->stamp == 50'000'000);
    CHECK(std::abs(packet->points[3].t - packet->stamp - 25'000'000) < 10);
    CHECK(std::abs(packet->points[6].t - packet->stamp - 100'000'000) < 10);
    CHECK(std::abs(packet->points[9].t - packet->stamp - 75'000'000) < 10);
    for (const TimedPoint& point : packet->points) CHECK(point.line == 0);
  }
  // 2011-09-26 13:04:32 UTC
  CHECK(*source->begin_time() == 1'317'042'272 * kSecond);
}

TEST_CASE("a laser of a drive ends where the file comes round to the front again") {
  TemporaryFolder folder;
  const fs::path drive = write_drive(folder.path());
  std::vector<float> points;
  for (int laser = 0; laser < 3; ++laser) {
    // From ahead over the left; the second laser sees nothing on the right, the third begins a little late.
    for (int degree = laser == 2 ? 4 : 0; degree < (laser == 1 ? 200 : 360); degree += 2) {
      const float angle = static_cast<float>(degree) * std::numbers::pi_v<float> / 180;
      points.insert(points.end(), {5 * std::cos(angle), 5 * std::sin(angle), static_cast<float>(-laser), 0.5F});
    }
  }
  std::ofstream scan(drive / "velodyne_points" / "data" / "0000000000.bin", std::ios::binary);
  scan.write(reinterpret_cast<const char*>(points.data()), static_cast<std::streamsize>(points.size() * 4));
  scan.close();
  const auto packets = packets_of(drive, calibrated());
  REQUIRE(packets.front().points.size() == 180 + 100 + 178);
  for (const TimedPoint& point : packets.front().points) REQUIRE(point.line == -static_cast<int>(point.z));
}

TEST_CASE("no point comes after an IMU sample of a later time") {
  TemporaryFolder folder;
  const auto source = open_source(write_drive(folder.path()), calibrated());
  TimeNs last_imu = kTimeMin;
  std::size_t scans = 0;
  while (const auto measurement = source->next()) {
    if (const auto* sample = std::get_if<ImuSample>(&*measurement)) {
      last_imu = sample->t;
      continue;
    }
    ++scans;
    for (const TimedPoint& point : std::get<LidarPacket>(*measurement).points) CHECK(point.t >= last_imu);
  }
  CHECK(scans == 5);
}

TEST_CASE("missing and damaged files of a drive") {
  TemporaryFolder folder;
  const fs::path drive = write_drive(folder.path(), 2);
  const auto source = open_source(drive, calibrated());
  CHECK(contains(source->notes().warnings, "1 scans are listed but missing"));
  CHECK(drain(*source).packets == 4);
  fs::resize_file(drive / "velodyne_points/data/0000000003.bin", 39);
  const auto cut = open_source(drive, calibrated());
  CHECK(drain(*cut).points == 3 * 12 + 2);
  CHECK(cut->status() == InputStatus::truncated);
  std::ofstream(drive / "oxts/data/0000000001.txt") << "1 2 x";
  CHECK(contains(data_error([&] { open_source(drive, {}); }), "0000000001.txt:1:"));
  std::ofstream(drive / "oxts/timestamps.txt") << "2011-09-26 13:04:32.000000000\nyesterday\n";
  CHECK(contains(data_error([&] { open_source(drive, {}); }), "timestamps.txt:2: 'yesterday'"));
  CHECK(contains(data_error([&] { open_source(folder.path() / "2011_09_26" / "..", {}); }), "timestamps.txt:2"));
  for (const std::string year : {"0000", "-999", "1899", "2101", "9999"}) {  // as nanoseconds they need not fit
    std::ofstream(drive / "oxts/timestamps.txt") << year << "-09-26 13:04:32.000000000\n";
    CHECK(contains(data_error([&] { open_source(drive, {}); }), "timestamps.txt:1: '" + year + "-09-26"));
  }
}

TEST_CASE("an empty line in a list of times is a lost frame, and later ones keep their number") {
  TemporaryFolder folder;
  const fs::path drive = write_drive(folder.path(), 2);
  const fs::path velodyne = drive / "velodyne_points";
  const auto stamps = [&] {
    std::vector<TimeNs> times;
    const auto source = open_source(drive, calibrated());
    while (const auto measurement = source->next()) {
      const auto* packet = std::get_if<LidarPacket>(&*measurement);
      times.push_back(packet != nullptr ? packet->stamp : std::get<ImuSample>(*measurement).t);
    }
    return times;
  };
  const auto without_line = [](const fs::path& list, int number, const std::string& behind = "") {
    std::ifstream from(list);
    std::string text, line;
    for (int i = 0; std::getline(from, line); ++i)
      text += (i == number ? "" : line.substr(0, line.find('\r'))) + "\r\n";
    from.close();
    std::ofstream(list) << text + behind;
  };
  const std::vector<TimeNs> expected = stamps();
  REQUIRE(expected.size() == 9);
  without_line(velodyne / "timestamps_start.txt", 2, "\n\n");
  CHECK(stamps() == expected);
  without_line(velodyne / "timestamps_end.txt", 2);
  CHECK(stamps() == expected);
  CHECK(contains(open_source(drive, calibrated())->notes().warnings, "1 scans are listed but missing"));

  without_line(drive / "oxts/timestamps.txt", 1);
  CHECK(contains(data_error([&] { open_source(drive, calibrated()); }),
                 "oxts/timestamps.txt:2: the line is empty, which marks a lost frame, but there is "));
  fs::remove(drive / "oxts/data/0000000001.txt");
  CHECK(stamps().size() == 8);
  CHECK(contains(open_source(drive, calibrated())->notes().warnings, "1 OXTS packets are listed but missing"));
  without_line(velodyne / "timestamps_end.txt", 3);
  CHECK(contains(data_error([&] { inspect(drive); }), "timestamps_end.txt:4: the line is empty"));
  std::ofstream(velodyne / "timestamps_start.txt") << "\n\nyesterday\n";
  CHECK(contains(data_error([&] { inspect(drive); }), "timestamps_start.txt:3: 'yesterday'"));
}

TEST_CASE("a folder in the place of a scan is an error that names it") {
  TemporaryFolder folder;
  const fs::path drive = write_drive(folder.path());
  const fs::path scan = drive / "velodyne_points/data/0000000003.bin";
  fs::remove(scan);
  fs::create_directory(scan);
  const std::string expected = scan.string() + ": cannot be read as a scan (Is a directory); ";
  CHECK(contains(data_error([&] { drain(*open_source(drive, calibrated())); }), expected));
  CHECK(contains(data_error([&] { inspect(drive); }), expected));
}

TEST_CASE("the angular rates of a whole drive are judged") {
  TemporaryFolder folder;
  const fs::path drive = write_drive(folder.path());
  const auto turn = [&](int from, double rate) {
    for (int k = 0; k < 5; ++k) write_packet(drive / "oxts", k, k < from ? 0 : rate);
  };
  const auto warnings = [&](const SensorConfig& sensor) {
    const auto source = open_source(drive, sensor);
    drain(*source);
    return source->notes().warnings;
  };
  SensorConfig sensor = calibrated();
  sensor.gyro_unit = GyroUnit::deg_s;
  CHECK_FALSE(contains(warnings(sensor), "gyro_unit"));
  turn(1, 1.2);
  CHECK(contains(warnings(sensor), "gyro_unit is deg_s, but nothing"));
  CHECK(contains(render(inspect(drive, sensor)), "gyro_unit is deg_s, but nothing"));
  turn(1, 90);
  CHECK_FALSE(contains(warnings(sensor), "gyro_unit"));
  turn(4, 90);
  CHECK(contains(warnings(calibrated()), "1 sample(s) turn faster than"));
}

TEST_CASE("what a sensor file knows of the IMU is taken out of a drive's samples") {  // eq. MOT-11
  TemporaryFolder folder;
  const fs::path drive = write_drive(folder.path());
  const auto first = [&](const SensorConfig& sensor) {
    const auto source = open_source(drive, sensor);
    while (const auto measurement = source->next()) {
      if (const auto* sample = std::get_if<ImuSample>(&*measurement)) return *sample;
    }
    return ImuSample{};
  };
  SensorConfig sensor = calibrated();
  const ImuSample raw = first(sensor);
  sensor.gyro_sensitivity(0, 2) = 0.01;
  sensor.imu_delay = 0.01;
  const ImuSample taken = first(sensor);
  CHECK(taken.gyro.isApprox(raw.gyro - Vec3(0.0019, 0, 0)));
  CHECK(taken.t == raw.t - kSecond / 100);
  CHECK(contains(open_source(drive, sensor)->notes().verdicts, "gyro_sensitivity of the sensor file"));
}

TEST_CASE("inspection of a drive") {
  TemporaryFolder folder;
  const InputReport report = inspect(write_drive(folder.path()), calibrated());
  CHECK(report.usable);
  CHECK(report.kind == "KITTI raw drive");
  REQUIRE(report.topics.size() == 2);
  CHECK(report.topics[0].topic == "oxts");
  CHECK(report.topics[0].messages == 5);
  CHECK(contains(report.topics[0].verdicts, "imu acceleration: m/s^2"));
  CHECK(report.topics[1].topic == "velodyne_points");
  CHECK(report.topics[1].rate == Approx(10));
  CHECK(report.topics[1].points_per_message == Approx(12));
  CHECK(contains(report.topics[1].verdicts, "timed by the azimuth"));
  CHECK(contains(render(report), "interpolated"));
}

TEST_CASE("an unsynchronised drive has scans as text and an IMU at 100 Hz") {
  TemporaryFolder folder, other;
  const fs::path drive = write_unsynchronised(folder.path());
  const auto source = open_source(drive, calibrated());
  CHECK(contains(source->notes().verdicts, "imu rate: 100.0 Hz"));
  CHECK_FALSE(contains(source->notes().verdicts, "unsynchronised drive beside"));
  CHECK(drain(*source).imu == 50);
  const auto text = packets_of(drive, calibrated()), binary = packets_of(write_drive(other.path()), calibrated());
  REQUIRE(text.size() == 5);
  REQUIRE(binary.size() == 5);
  for (std::size_t i = 0; i < 5; ++i) {
    REQUIRE(text[i].points.size() == binary[i].points.size());
    for (std::size_t k = 0; k < text[i].points.size(); ++k) {
      CHECK(text[i].points[k].t == binary[i].points[k].t);
      CHECK(text[i].points[k].x == binary[i].points[k].x);
      CHECK(text[i].points[k].intensity == binary[i].points[k].intensity);
    }
  }
  std::ofstream(drive / "velodyne_points/data/0000000002.txt") << "1 2 3 0.5\n\n1 2 3\n";
  CHECK(contains(data_error([&] { packets_of(drive, calibrated()); }),
                 "0000000002.txt:3: '1 2 3' is not a line of four numbers"));
}

TEST_CASE("a synchronised drive takes the packets of the unsynchronised one beside it") {
  TemporaryFolder folder;
  const fs::path whole = write_unsynchronised(folder.path());
  const fs::path drive = whole.parent_path() / "2011_09_26_drive_0001_sync";
  for (const fs::path& path : {drive, drive / ""}) {
    const auto source = open_source(path, calibrated());
    CHECK(contains(source->notes().verdicts, "imu samples: of the unsynchronised drive beside this one, "));
    CHECK(contains(source->notes().verdicts, "imu rate: 100.0 Hz"));
    const Counts counts = drain(*source);
    CHECK(counts.imu == 50);
    CHECK(counts.packets == 5);
  }
  fs::remove_all(whole / "velodyne_points");
  fs::remove_all(drive / "oxts");
  CHECK(drain(*open_source(folder.path(), calibrated())).imu == 50);
  CHECK(contains(render(inspect(folder.path())), "unsynchronised drive beside this one"));
}

}  // namespace aslio::io::test
