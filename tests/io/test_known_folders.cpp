// Folders of public data sets, each made as its documents describe it.
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

/// Numbers of fixed sizes, one after the other.
class Packed {
 public:
  template <class T>
  Packed& add(T value) {
    const auto* from = reinterpret_cast<const char*>(&value);
    bytes_.append(from, sizeof(value));
    return *this;
  }
  Packed& xyz(int i) { return add(5.0F + static_cast<float>(i)).add(1.0F).add(-0.5F); }

  void write(const fs::path& path) const {
    fs::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary) << bytes_;
  }

 private:
  std::string bytes_;
};

constexpr int kPoints = 40;

/// Ten scans in one second, named by their stamps in `unit` ns; `point` adds a point, of which there are 40.
void write_scans(const fs::path& folder, TimeNs start, TimeNs unit, const std::function<void(Packed&, int)>& point) {
  for (int k = 0; k < 10; ++k) {
    Packed scan;
    for (int i = 0; i < kPoints; ++i) point(scan, i);
    scan.write(folder / fmt::format("{}.bin", (start + k * kSecond / 10) / unit));
  }
}

/// A second at 100 Hz; `line` without its line feed.
void write_imu(const fs::path& file, const std::string& header, TimeNs start,
               const std::function<std::string(TimeNs)>& line) {
  fs::create_directories(file.parent_path());
  std::ofstream table(file);
  table << header;
  for (int i = 0; i < 100; ++i) table << line(start + i * kSecond / 100) << '\n';
}

void write_xsens(const fs::path& file, TimeNs start) {
  write_imu(file, "", start,
            [](TimeNs t) { return fmt::format("{},0,0,0,1,0.1,0.2,0.3,0.01,0.02,0.03,0.1,0.2,9.8,0.4,0.5,0.6", t); });
}

struct Read {
  std::vector<LidarPacket> packets;
  std::vector<ImuSample> imu;
  SourceNotes notes;
};

Read read(const fs::path& path, const SensorConfig& sensor = {}) {
  Read all;
  const auto source = open_source(path, sensor);
  while (auto measurement = source->next()) {
    if (auto* packet = std::get_if<LidarPacket>(&*measurement)) {
      all.packets.push_back(std::move(*packet));
    } else {
      all.imu.push_back(std::get<ImuSample>(*measurement));
    }
  }
  all.notes = source->notes();
  return all;
}

SensorConfig of_topic(const std::string& lidar) {
  SensorConfig sensor;
  sensor.lidar_topic = lidar;
  return sensor;
}

}  // namespace

TEST_CASE("HeLiPR: four LiDARs with layouts of their own") {
  TemporaryFolder folder;
  const TimeNs start =
      1'691'936'557'946'849'179 - 2 * kSecond / 10;  // the Aeva has intensities from the fourth scan on
  const auto time = [](int i) { return static_cast<std::uint32_t>(2'500'000 * i); };
  const fs::path lidar = folder / "LiDAR";
  write_scans(lidar / "Ouster", start, 1, [&](Packed& p, int i) {
    p.xyz(i).add(7.0F).add(time(i)).add(std::uint16_t{9}).add(static_cast<std::uint16_t>(i)).add(std::uint16_t{3});
  });
  write_scans(lidar / "Velodyne", start, 1, [&](Packed& p, int i) {
    p.xyz(i).add(7.0F).add(static_cast<std::uint16_t>(i)).add(0.0025F * static_cast<float>(i));
  });
  write_scans(lidar / "Avia", start, 1, [&](Packed& p, int i) {
    p.xyz(i).add(std::uint8_t{7}).add(std::uint8_t{0x10}).add(static_cast<std::uint8_t>(i % 6)).add(time(i));
  });
  for (int k = 0; k < 10; ++k) {
    Packed scan;
    const TimeNs stamp = start + k * kSecond / 10;
    for (int i = 0; i < kPoints; ++i) {
      scan.xyz(i).add(3.0F).add(-0.1F).add(static_cast<std::int32_t>(time(i))).add(static_cast<std::uint8_t>(i));
      if (stamp > 1'691'936'557'946'849'179) scan.add(7.0F);
    }
    scan.write(lidar / "Aeva" / fmt::format("{}.bin", stamp));
  }
  write_xsens(folder / "Inertial_data/xsens_imu.csv", start);
  CHECK(contains(data_error([&] { read(folder.path()); }), "there is more than one LiDAR topic"));
  for (const std::string topic : {"Ouster", "Velodyne", "Avia", "Aeva"}) {
    INFO(topic);
    SensorConfig sensor = of_topic(topic);
    sensor.model.scan_lines = 6;
    const Read all = read(folder.path(), sensor);
    REQUIRE(all.packets.size() == 10);
    REQUIRE(all.imu.size() == 100);
    CHECK(all.imu[0].gyro.isApprox(Vec3(0.01, 0.02, 0.03)));
    CHECK(all.imu[0].acc.isApprox(Vec3(0.1, 0.2, 9.8)));
    for (std::size_t k = 0; k < 10; ++k) {
      const LidarPacket& packet = all.packets[k];
      CHECK(packet.stamp == start + static_cast<TimeNs>(k) * kSecond / 10);
      REQUIRE(packet.points.size() == kPoints);
      const TimedPoint& last = packet.points.back();
      CHECK(last.x == 44);
      CHECK(std::abs(last.t - packet.stamp - 97'500'000) < 10);
      CHECK(last.line == (topic == "Avia" ? 39 % 6 : 39));
      CHECK(last.intensity == (topic == "Aeva" && k < 3 ? 3 : 7));
    }
  }
  const InputReport report = inspect(folder.path(), of_topic("Ouster"));
  CHECK(report.kind == "HeLiPR sequence");
  CHECK(report.usable);
  REQUIRE(report.topics.size() == 5);
  for (const TopicReport& topic : report.topics) CHECK(topic.malformed == 0);
}

TEST_CASE("MulRan has folders named as HeLiPR's are, but points of 16 bytes") {
  TemporaryFolder folder;
  write_scans(folder / "Ouster", kStart, 1, [](Packed& p, int i) { p.xyz(i).add(7.0F); });
  write_xsens(folder / "xsens_imu.csv", kStart);
  SensorConfig sensor;
  sensor.scan_columns = "x y z intensity";
  sensor.imu_columns = "timestamp qx qy qz qw ex ey ez gx gy gz ax ay az mx my mz";
  sensor.require_point_times = false;
  const Read all = read(folder.path(), sensor);
  CHECK(all.packets.size() == 10);
  CHECK(all.imu.size() == 100);
}

TEST_CASE("Boreas: scans stamped in their middle, the IMU by the columns of its file") {
  TemporaryFolder folder;
  write_scans(folder / "lidar", kStart, 1000, [](Packed& p, int i) {
    p.xyz(i).add(7.0F).add(static_cast<float>(i)).add(-0.05F + 0.0025F * static_cast<float>(i));
  });
  fs::create_directories(folder / "applanix");
  CHECK(contains(data_error([&] { read(folder.path()); }),
                 "there is no IMU in this Boreas sequence: expected is imu/dmu_imu.csv"));
  write_imu(
      folder / "applanix/imu.csv", "GPSTime,angvel_z,angvel_y,angvel_x,accelz,accely,accelx\n", kStart,
      [](TimeNs t) { return fmt::format("{}.{:06d},0.03,0.02,0.01,9.8,0.2,0.1", t / kSecond, t % kSecond / 1000); });
  const Read all = read(folder.path());
  REQUIRE(all.packets.size() == 10);
  CHECK(all.packets[0].stamp == kStart);
  CHECK(std::abs(all.packets[0].points[0].t - kStart + 50'000'000) < 10);
  CHECK(all.packets[0].points[39].line == 39);
  REQUIRE(all.imu.size() == 100);
  CHECK(all.imu[1].t == kStart + kSecond / 100);
  CHECK(all.imu[0].gyro.isApprox(Vec3(0.01, 0.02, 0.03)));
  CHECK(all.imu[0].acc.isApprox(Vec3(0.1, 0.2, 9.8)));
  CHECK(contains(all.notes.warnings, "applanix/imu.csv went into the reference trajectory"));
  CHECK(contains(all.notes.verdicts, "lidar stamps: of the middle of a sweep"));

  write_imu(folder / "imu/dmu_imu.csv", "time,wx,wy,wz,ax,ay,az\n", kStart,
            [](TimeNs t) { return fmt::format("{},0.04,0.05,0.06,0.1,0.2,9.7", t); });
  const Read trip = read(folder.path());
  CHECK(trip.imu[0].gyro.isApprox(Vec3(0.04, 0.05, 0.06)));
  CHECK_FALSE(contains(trip.notes.warnings, "went into the reference"));
}

TEST_CASE("Boreas Road Trip: a second LiDAR with flags of 64 bits") {
  TemporaryFolder folder;
  fs::create_directories(folder / "applanix");
  write_scans(folder / "lidar", kStart, 1000, [](Packed& p, int i) {
    p.xyz(i).add(7.0F).add(static_cast<float>(i)).add(-0.05F + 0.0025F * static_cast<float>(i));
  });
  write_scans(folder / "aeva", kStart, 1000, [](Packed& p, int i) {
    p.xyz(i).add(-0.1F).add(7.0F).add(1.0F).add(2.0F).add(0.0025F * static_cast<float>(i)).add(0.0);
  });
  write_imu(folder / "imu/aeva_imu.csv", "time,wx,wy,wz,ax,ay,az\n", kStart,
            [](TimeNs t) { return fmt::format("{},0.04,0.05,0.06,0.1,0.2,9.7", t / 1000); });
  const Read all = read(folder.path(), of_topic("aeva"));
  REQUIRE(all.packets.size() == 10);
  CHECK(all.packets[9].points[39].intensity == 7);
  CHECK(std::abs(all.packets[9].points[39].t - all.packets[9].stamp - 97'500'000) < 10);
  CHECK(all.imu[99].t == kStart + 99 * kSecond / 100);
}

TEST_CASE("Newer College, raw: clouds named by s and ns, counted samples of an IMU") {
  for (const std::string& header :
       {std::string("#counter,sec,nsec,wx,wy,wz,ax,ay,az\n"), std::string("# counter, sec, nansec, ...\n")}) {
    TemporaryFolder folder;
    ScanFolder made;
    made.extension = ".pcd";
    made.start = kStart + 7;
    made.lidar_folder = "raw_format/ouster_scan";
    made.imu_file = "other/imu.csv";
    made.name = [](TimeNs t) { return fmt::format("cloud_{}_{}", t / kSecond, t % kSecond); };
    made.write(folder.path());
    int count = 0;
    write_imu(folder / "raw_format/ouster_imu/ouster_imu.csv", header, kStart, [&](TimeNs t) {
      return fmt::format("{},{},{},0.01,0.02,0.03,0.1,0.2,9.8", count++, t / kSecond, t % kSecond);
    });
    const Read all = read(folder.path());
    REQUIRE(all.packets.size() == 10);
    for (std::size_t k = 0; k < 10; ++k)
      CHECK(all.packets[k].stamp == kStart + 7 + static_cast<TimeNs>(k) * kSecond / 10);
    REQUIRE(all.imu.size() == 100);
    CHECK(all.imu[5].t == kStart + 5 * kSecond / 100);
    CHECK(all.imu[5].acc.isApprox(Vec3(0.1, 0.2, 9.8)));
    CHECK(inspect(folder.path()).kind == "Newer College sequence");
  }
}

TEST_CASE("a sequence of KITTI's odometry benchmark has no IMU: its raw drive is named") {
  TemporaryFolder folder;
  const fs::path sequence = folder / "sequences/08";
  std::string times;
  for (int k = 0; k < 12; ++k) {
    Packed scan;
    for (int i = 0; i < kPoints; ++i) scan.xyz(i).add(0.3F);
    scan.write(sequence / "velodyne" / fmt::format("{:06d}.bin", k));
    times += fmt::format("{:.6e}\n", 0.1036 * k);
  }
  std::ofstream(sequence / "times.txt") << times;
  CHECK(contains(data_error([&] { read(sequence); }),
                 "there is no IMU in this KITTI odometry sequence: the odometry benchmark of KITTI has none"));
  CHECK(contains(data_error([&] { read(sequence / ""); }), "2011_09_30_drive_0028 (frames 1100 to 5170)"));
  const InputReport report = inspect(sequence);
  CHECK_FALSE(report.usable);
  CHECK(contains(report.reason, "take the raw drive"));
  REQUIRE(report.topics.size() == 1);
  CHECK(report.topics[0].messages == 12);
  CHECK(report.topics[0].rate == Approx(1 / 0.1036));
  CHECK(report.topics[0].points_per_message == Approx(40));

  write_imu(sequence / "imu.csv", "t,wx,wy,wz,ax,ay,az\n", 0,
            [](TimeNs t) { return fmt::format("{},0.01,0.02,0.03,0.1,0.2,9.8", to_seconds(t)); });
  SensorConfig sensor;
  sensor.require_point_times = false;
  CHECK(read(sequence, sensor).packets.size() == 12);
}

}  // namespace aslio::io::test
