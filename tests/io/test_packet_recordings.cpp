// Real packets in ASLIO_RECORDINGS_DIR, against clouds that other programs made of them.
#include <fmt/format.h>
#include <sqlite3.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <memory>
#include <unordered_map>

#include "../../framework/io/src/io/lidar_decoder.hpp"
#include "../../framework/io/src/io/packets/sweep_message.hpp"
#include "../../framework/io/src/io/packets/velodyne.hpp"
#include "io/bag_fixture.hpp"
#include "recordings/unpacked.hpp"

namespace aslio::io::test {
namespace {

using aslio::test::recorded;

/// The messages of a rosbag2 database, all of one topic here.
std::vector<std::vector<std::uint8_t>> db3_messages(const std::filesystem::path& path) {
  std::vector<std::vector<std::uint8_t>> all;
  sqlite3* open = nullptr;
  const int opened = sqlite3_open_v2(path.c_str(), &open, SQLITE_OPEN_READONLY, nullptr);
  const std::unique_ptr<sqlite3, int (*)(sqlite3*)> db(open, &sqlite3_close);
  REQUIRE(opened == SQLITE_OK);
  sqlite3_stmt* prepared = nullptr;
  REQUIRE(sqlite3_prepare_v2(open, "SELECT data FROM messages ORDER BY id", -1, &prepared, nullptr) == SQLITE_OK);
  const std::unique_ptr<sqlite3_stmt, int (*)(sqlite3_stmt*)> rows(prepared, &sqlite3_finalize);
  while (sqlite3_step(rows.get()) == SQLITE_ROW) {
    const auto* data = static_cast<const std::uint8_t*>(sqlite3_column_blob(rows.get(), 0));
    all.emplace_back(data, data + sqlite3_column_bytes(rows.get(), 0));
  }
  return all;
}

constexpr const char* kVlp16 = "vlp16_packets/1673400471837873222/1673400471837873222_0.db3";

struct ReferencePoint {
  float x = 0, y = 0, z = 0;
  int channel = 0;
};

/// A binary PCD whose points begin with x, y, z in float32.
std::vector<ReferencePoint> read_pcd(const std::filesystem::path& path, std::size_t step, std::size_t channel_at) {
  const std::vector<std::uint8_t> bytes = read_bytes(path);
  const std::string text(bytes.begin(), bytes.begin() + 600), end = "DATA binary\n";
  std::vector<ReferencePoint> points;
  for (std::size_t at = text.find(end) + end.size(); at + step <= bytes.size(); at += step) {
    ReferencePoint& p = points.emplace_back();
    std::memcpy(&p.x, &bytes[at], 12);
    if (channel_at > 0) p.channel = bytes[at + channel_at];
  }
  return points;
}

std::vector<LidarPacket> decode_all(const std::string& folder, const std::string& type, const SensorConfig& sensor,
                                    SourceNotes& notes) {
  Connection connection;
  connection.type = type;
  connection.encoding = Encoding::cdr;
  const auto decoder = make_lidar_decoder(connection, sensor, folder);
  std::vector<LidarPacket> sweeps;
  for (const auto& message : db3_messages(recorded("formats/db3/" + folder))) {
    if (sweeps.empty()) REQUIRE(decoder->judge({message, Encoding::cdr}, notes));
    REQUIRE(decoder->decode({message, Encoding::cdr}, sweeps.emplace_back()).empty());
  }
  CHECK(decoder->remark().empty());
  return sweeps;
}

/// Finds the nearest point, up to 2 cm away.
class Neighbours {
 public:
  explicit Neighbours(const std::vector<ReferencePoint>& points) : points_(points) {
    for (std::size_t i = 0; i < points.size(); ++i) cells_[key(points[i].x, points[i].y, points[i].z)].push_back(i);
  }

  double nearest(double x, double y, double z) const {
    double least = kCell;
    for (int i = 0; i < 27; ++i) {
      const auto cell = cells_.find(key(x + kCell * (i % 3 - 1), y + kCell * (i / 3 % 3 - 1), z + kCell * (i / 9 - 1)));
      if (cell == cells_.end()) continue;
      for (const std::size_t at : cell->second) {
        const ReferencePoint& p = points_[at];
        least = std::min(least, std::hypot(x - double{p.x}, y - double{p.y}, z - double{p.z}));
      }
    }
    return least;
  }

 private:
  static constexpr double kCell = 0.02;
  static std::int64_t key(double x, double y, double z) {
    const auto part = [](double v) { return static_cast<std::int64_t>(std::floor(v / kCell)) & 0xFFFFF; };
    return part(x) << 40 | part(y) << 20 | part(z);
  }
  const std::vector<ReferencePoint>& points_;
  std::unordered_map<std::int64_t, std::vector<std::size_t>> cells_;
};

/// The unit's own table of angles, as the recording was decoded with it.
constexpr const char* kXt32Angles =
    "Channel,Elevation,Azimuth\n1,14.972363,0.082385\n2,13.952372,0.076529\n3,12.938632,0.078240\n"
    "4,11.931141,0.076267\n5,10.926151,0.064337\n6,9.922410,0.059942\n7,8.917419,0.049319\n8,7.917429,0.044992\n"
    "9,6.919938,0.034446\n10,5.919947,0.027658\n11,4.922456,0.020896\n12,3.924965,0.014147\n13,2.929974,0.008668\n"
    "14,1.936233,-0.000548\n15,0.944992,-0.007248\n16,-0.047500,-0.015201\n17,-1.039991,-0.025654\n"
    "18,-2.036232,-0.031126\n19,-3.028723,-0.037837\n20,-4.024964,-0.045822\n21,-5.019955,-0.061312\n"
    "22,-6.016196,-0.065570\n23,-7.013687,-0.068599\n24,-8.013678,-0.076658\n25,-9.011169,-0.088476\n"
    "26,-10.011159,-0.091580\n27,-11.006150,-0.098438\n28,-12.003641,-0.092837\n29,-12.996131,-0.102247\n"
    "30,-13.997372,-0.104231\n31,-15.004862,-0.118783\n32,-16.023602,-0.129679\n";

}  // namespace

TEST_CASE("packets of a VLP-16 give the cloud that another program made of them") {
  SourceNotes notes;
  SensorConfig sensor;
  sensor.model.scan_lines = 16;
  const auto sweeps = decode_all(kVlp16, "velodyne_msgs/msg/VelodyneScan", sensor, notes);
  REQUIRE(sweeps.size() == 4);
  CHECK(contains(notes.verdicts, "VLP-16, dual return: the strongest one is kept"));
  const auto reference = read_pcd(recorded("formats/db3/vlp16_packets/reference_1673400472138016708.pcd"), 32, 14);
  REQUIRE(reference.size() == 14831);
  const Neighbours neighbours(reference);
  std::map<int, double> heights;
  for (const packets::VelodyneLaser& laser : packets::velodyne_lasers(packets::VelodyneModel::vlp16)) {
    heights[laser.line] = laser.height;  // which that program leaves out
  }
  const auto format = packets::make_velodyne(packets::VelodyneModel::vlp16, true);
  const auto message = db3_messages(recorded("formats/db3/" + std::string(kVlp16))).back();
  packets::SweepMessage scan;
  REQUIRE(packets::parse_sweep({message, Encoding::cdr}, true, scan).empty());
  std::size_t alike = 0, all = 0;
  for (const packets::Packet& packet : scan.packets) {
    LidarPacket out;
    REQUIRE(format->decode(packet.bytes, 0, 16, out).empty());
    for (const TimedPoint& p : out.points) {
      const double range = std::hypot(double{p.x}, double{p.y}, double{p.z});
      // That program takes no near returns, one of two that are less than 0.1 m apart, whichever it is, and does not
      // interpolate azimuths in the last pair of blocks.
      if (range < 0.5 || p.t >= 5 * 110'592) continue;
      ++all;
      // It rounds azimuths to 0.01 deg.
      const double apart = neighbours.nearest(double{p.x}, double{p.y}, double{p.z} - heights[p.line]);
      if (apart < 1e-3 + 1.75e-4 * range) ++alike;
    }
  }
  UNSCOPED_INFO(fmt::format("{} of {} alike", alike, all));
  CHECK(static_cast<double>(alike) > 0.98 * static_cast<double>(all));
  CHECK(all > 11'500);
}

TEST_CASE("packets of an XT32 give the cloud that another program made of them") {
  TemporaryFolder folder;
  const std::string text = kXt32Angles;
  write_bytes(folder / "angles.csv", {text.begin(), text.end()});
  SourceNotes notes;
  SensorConfig sensor;
  sensor.model.scan_lines = 32;
  sensor.lidar_calibration = (folder / "angles.csv").string();
  const auto sweeps = decode_all("xt32_packets/1673400677802009732/1673400677802009732_0.db3",
                                 "pandar_msgs/msg/PandarScan", sensor, notes);
  REQUIRE(sweeps.size() == 4);
  CHECK(contains(notes.verdicts, "XT32, dual return: the last one is kept, angles of the sensor's own table"));
  const auto reference = read_pcd(recorded("formats/db3/xt32_packets/reference_1673400678101968885.pcd"), 12, 0);
  REQUIRE(reference.size() == 63021);
  const Neighbours neighbours(reference);
  std::size_t alike = 0, all = 0;
  for (const TimedPoint& p : sweeps[3].points) {
    ++all;
    if (neighbours.nearest(double{p.x}, double{p.y}, double{p.z}) < 1e-3) ++alike;
  }
  UNSCOPED_INFO(fmt::format("{} of {} alike", alike, all));
  CHECK(static_cast<double>(alike) > 0.98 * static_cast<double>(all));
  CHECK(all > 60000);
  // 100 ms at 10 Hz, though the host received the packets in bursts.
  for (const LidarPacket& sweep : sweeps) {
    CHECK(std::abs(to_seconds(sweep.points.back().t - sweep.points.front().t) - 0.1) < 0.001);
  }
}

}  // namespace aslio::io::test
