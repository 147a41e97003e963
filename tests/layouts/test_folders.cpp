/// Files of scans as HeLiPR, Boreas, FoMo and KITTI have them.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <numeric>

#include "layouts/written.hpp"

using namespace aslio;
using namespace aslio::test;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;
using io::LidarForm;

namespace {

io::Layout folder_of(LidarForm form, std::vector<std::string> files) {
  io::Layout layout;
  layout.container = io::Container::folder;
  layout.files = std::move(files);
  layout.lidar.form = form;
  layout.reference.format = io::ReferenceFile::none;
  return layout;
}

std::vector<std::uint8_t> bytes_of(const std::filesystem::path& file) {
  const std::string text = text_of(file);
  return {text.begin(), text.end()};
}

void check_points(const Walk& walk, const std::vector<LidarPacket>& packets, TimeNs resolution) {
  REQUIRE(packets.size() == walk.packets.size());
  for (std::size_t i = 0; i < packets.size(); ++i) {
    const auto got = sorted(packets[i].points), made = sorted(walk.packets[i].points);
    REQUIRE(got.size() == made.size());
    for (std::size_t k = 0; k < got.size(); ++k) {
      const bool same = got[k].x == made[k].x && got[k].y == made[k].y && got[k].z == made[k].z &&
                        got[k].line == made[k].line && std::abs(got[k].t - made[k].t) <= resolution;
      REQUIRE(same);
    }
  }
}

}  // namespace

TEST_CASE("layouts: HeLiPR has scans of 26 bytes a point and an IMU of 17 columns") {
  const Walk& walk = spinning_walk();
  io::Layout layout =
      folder_of(LidarForm::helipr_ouster, {"LiDAR/Ouster/{stamp}.bin", "LiDAR/Inertial_data/xsens_imu.csv"});
  layout.imu.columns = {"t", "-", "-", "-", "-", "-", "-", "-", "wx", "wy", "wz", "ax", "ay", "az", "-", "-", "-"};
  const Written written(walk, layout);
  const LidarPacket& sweep = walk.packets.front();
  const auto scan = bytes_of(written / "LiDAR/Ouster/1700000000000000000.bin");
  REQUIRE(scan.size() == 26 * sweep.points.size());
  CHECK(at<float>(scan, 26 * 5 + 8) == sweep.points[5].z);
  CHECK(at<std::uint32_t>(scan, 26 * 5 + 16) == static_cast<std::uint32_t>(sweep.points[5].t - sweep.stamp));
  CHECK(at<std::uint16_t>(scan, 26 * 5 + 22) == sweep.points[5].line);
  const auto rows = lines(written / "LiDAR/Inertial_data/xsens_imu.csv");
  REQUIRE(rows.size() == walk.imu().size());
  CHECK_THAT(rows.front(), StartsWith("1700000000000000000,0,0,0,0,0,0,0,"));
  CHECK(std::count(rows.front().begin(), rows.front().end(), ',') == 16);
  const Split back = split(read({written.folder / "data"}, sensor_of(walk, layout)));
  check_points(walk, back.packets, 0);
  REQUIRE(back.imu.size() == walk.imu().size());
  for (std::size_t i = 0; i < back.imu.size(); ++i) {
    const bool same = back.imu[i].t == walk.imu()[i].t && back.imu[i].gyro == walk.imu()[i].gyro &&
                      back.imu[i].acc == walk.imu()[i].acc;
    REQUIRE(same);
  }
}

TEST_CASE("layouts: Boreas names a scan by the middle of its sweep in us, and its times count from there") {
  const Walk& walk = spinning_walk();
  io::Layout layout = folder_of(LidarForm::boreas, {"{sequence}/lidar/{stamp}.bin", "{sequence}/imu/dmu_imu.csv"});
  layout.lidar.stamp = io::SweepMoment::middle;
  layout.lidar.name_unit = io::TimeUnit::us;
  layout.imu.header = true;
  layout.reference.format = io::ReferenceFile::csv;
  layout.reference.file = "{sequence}/applanix/gps_post_process.csv";
  const Written written(walk, layout);
  const auto scan = bytes_of(written / "walk/lidar/1700000000050000.bin");
  const LidarPacket& sweep = walk.packets.front();
  REQUIRE(scan.size() == 24 * sweep.points.size());
  CHECK(at<float>(scan, 16) == sweep.points.front().line);
  CHECK(at<float>(scan, 20) == Approx(-0.05).margin(3e-4));
  const auto rows = lines(written / "walk/imu/dmu_imu.csv");
  CHECK(rows.front() == "t,wx,wy,wz,ax,ay,az");
  CHECK(rows.size() == walk.imu().size() + 1);
  const Split back = split(read({written / "walk"}, sensor_of(walk, layout)));
  check_points(walk, back.packets, 4);
}

TEST_CASE("layouts: FoMo has absolute microseconds in each point") {
  const Walk& walk = spinning_walk();
  io::Layout layout = folder_of(LidarForm::fomo, {"robosense/{stamp}.bin", "vectornav.csv"});
  layout.lidar.name_unit = io::TimeUnit::us;
  layout.imu.header = true;
  layout.imu.columns = {"t", "wx", "wy", "wz", "ax", "ay", "az"};
  const Written written(walk, layout);
  const auto scan = bytes_of(written / "robosense/1700000000000000.bin");
  const LidarPacket& sweep = walk.packets.front();
  REQUIRE(scan.size() == 26 * sweep.points.size());
  const std::size_t last = sweep.points.size() - 1;
  CHECK(at<std::uint64_t>(scan, 26 * last + 18) == static_cast<std::uint64_t>(sweep.points[last].t / 1000));
  CHECK(at<std::uint16_t>(scan, 26 * last + 16) == sweep.points[last].line);
}

TEST_CASE("layouts: a drive of KITTI has a turn from the rear to the rear, laser after laser") {
  const Walk& walk = spinning_walk();
  io::Layout layout;
  layout.container = io::Container::kitti;
  layout.files = {"2023_11_14/{sequence}_sync"};
  layout.reference.format = io::ReferenceFile::none;
  const Written written(walk, layout);
  const std::filesystem::path drive = written / "2023_11_14/walk_sync";
  const auto begins = lines(drive / "velodyne_points/timestamps_start.txt");
  REQUIRE(begins.size() == walk.packets.size() - 1);
  CHECK(begins.front() == "2023-11-14 22:13:20.050000000");
  CHECK(lines(drive / "velodyne_points/timestamps_end.txt").front() == "2023-11-14 22:13:20.150000000");
  const auto scan = bytes_of(drive / "velodyne_points/data/0000000000.bin");
  // The first beam of the file is of the highest line, 15 deg up, and looks ahead or a little to the left.
  const float x = at<float>(scan, 0), y = at<float>(scan, 4), z = at<float>(scan, 8);
  CHECK(std::atan2(z, std::hypot(x, y)) * 57.29578 == Approx(15.0).margin(1e-3));
  CHECK(std::atan2(y, x) * 57.29578 >= 0);
  CHECK(std::atan2(y, x) * 57.29578 < 10);
  const auto packet = lines(written / "2023_11_14/walk_extract/oxts/data/0000000000.txt");
  CHECK(std::count(packet.front().begin(), packet.front().end(), ' ') == 29);
  CHECK_THAT(text_of(written / "2023_11_14/calib_imu_to_velo.txt"), StartsWith("R: 1 0 0 0 1 0 0 0 1\nT: "));
  const Split back = split(read({drive}, sensor_of(walk, layout)));
  REQUIRE(back.packets.size() == walk.packets.size() - 1);
  REQUIRE(back.imu.size() == walk.imu().size());
  CHECK(back.imu[7].t == walk.imu()[7].t);
  CHECK(back.imu[7].acc == walk.imu()[7].acc);
  std::vector<TimedPoint> all;
  for (const LidarPacket& made : walk.packets) all.insert(all.end(), made.points.begin(), made.points.end());
  const TimeNs first = walk.simulation.begin_time() + 50'000'000;
  std::erase_if(all, [&](const TimedPoint& point) { return point.t <= first; });
  std::vector<TimedPoint> got;
  for (const LidarPacket& packet_read : back.packets)
    got.insert(got.end(), packet_read.points.begin(), packet_read.points.end());
  REQUIRE(got.size() <= all.size());
  // A scan tells no time: that of a point follows from its azimuth, which single precision has to 1e-7 of a turn.
  std::sort(got.begin(), got.end(),
            [](const auto& a, const auto& b) { return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z); });
  std::sort(all.begin(), all.end(),
            [](const auto& a, const auto& b) { return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z); });
  std::size_t found = 0;
  TimeNs worst = 0;
  for (const TimedPoint& point : got) {
    const auto made = std::lower_bound(all.begin(), all.end(), point, [](const auto& a, const auto& b) {
      return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
    });
    if (made == all.end() || made->x != point.x || made->y != point.y || made->z != point.z) continue;
    ++found;
    worst = std::max(worst, std::abs(made->t - point.t));
  }
  CHECK(found == got.size());
  CHECK(worst < 100);
}
