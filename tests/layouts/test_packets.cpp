/// A VLP-16 as its raw packets.
#include <catch2/catch.hpp>
#include <cmath>
#include <map>

#include "aslio/io/layout_writer.hpp"
#include "layouts/written.hpp"

using namespace aslio;
using namespace aslio::test;
using Catch::Matchers::Contains;

namespace {

io::Layout packets() {
  io::Layout layout;
  layout.lidar.form = io::LidarForm::velodyne_packets;
  layout.lidar.topic = "/velodyne_packets";
  layout.reference.format = io::ReferenceFile::none;
  return layout;
}

const Walk& vlp16_walk() {
  static const Walk walk(simulator::SensorKind::vlp16, 0.5);
  return walk;
}

}  // namespace

TEST_CASE("layouts: packets of a VLP-16 are those of its manual") {
  const Walk& walk = vlp16_walk();
  const Written written(walk, packets());
  const FirstMessage message = first_on(written / "walk.bag", "/velodyne_packets");
  CHECK(message.connection.type == "velodyne_msgs/VelodyneScan");
  CHECK(message.connection.md5 == "50804fc9533a0e579e6322c04ae70566");
  // Header with the frame "velodyne": 24 bytes, and the number of packets. A turn has 1808.45 cycles, 24 to a packet.
  const std::span<const std::uint8_t> bytes = message.bytes;
  REQUIRE(at<std::uint32_t>(bytes, 24) == 76);
  REQUIRE(bytes.size() == 28 + 76 * (8 + 1206));
  for (std::size_t i = 0; i < 76; ++i) {
    const auto packet = bytes.subspan(28 + i * 1214 + 8, 1206);
    CHECK(at<std::uint32_t>(packet, 1200) == std::lround(24 * 55.296 * static_cast<double>(i)) + 800'000'000);
    CHECK(packet[1204] == 0x37);
    CHECK(packet[1205] == 0x22);
    for (std::size_t block = 0; block < 12; ++block) {
      CHECK(at<std::uint16_t>(packet, 100 * block) == 0xEEFF);
      const double turn = 55.296e-6 * static_cast<double>(24 * i + 2 * block) / 0.1;
      CHECK(at<std::uint16_t>(packet, 100 * block + 2) == Approx(36000 * (turn - std::floor(turn))).margin(1.01));
    }
  }
}

TEST_CASE("layouts: points come back from packets within the resolution of the sensor") {
  const Walk& walk = vlp16_walk();
  for (const io::Container container : {io::Container::rosbag, io::Container::mcap}) {
    io::Layout layout = packets();
    layout.container = container;
    if (container == io::Container::mcap) layout.files = {"walk.mcap"};
    const Written written(walk, layout);
    const std::string file = layout.files.front() == "walk.mcap" ? "walk.mcap" : "walk.bag";
    const Split back = split(read({written / file}, sensor_of(walk, layout)));
    REQUIRE(back.packets.size() == walk.packets.size());
    double worst_place = 0;
    TimeNs worst_time = 0;
    for (std::size_t i = 0; i < back.packets.size(); ++i) {
      // All lasers of a cycle share its time where they are simulated; packets tell each its own, up to 34.6 us later.
      std::map<std::pair<TimeNs, int>, const TimedPoint*> by_cycle;
      for (const TimedPoint& made : walk.packets[i].points) by_cycle[{made.t / 55'296, made.line}] = &made;
      const auto& got = back.packets[i].points;
      REQUIRE(got.size() == walk.packets[i].points.size());
      for (const TimedPoint& point : got) {
        const TimeNs laser = point.line < 8 ? 2 * point.line : 2 * point.line - 15;
        const TimeNs cycle_time = point.t - 2304 * laser;
        const auto made = by_cycle.find({(cycle_time + 20'000) / 55'296, point.line});
        REQUIRE(made != by_cycle.end());
        worst_time = std::max(worst_time, std::abs(made->second->t - cycle_time));
        const Eigen::Vector3f apart(made->second->x - point.x, made->second->y - point.y, made->second->z - point.z);
        worst_place = std::max(worst_place, static_cast<double>(apart.norm()));
      }
    }
    CHECK(worst_time <= 2000);
    // Half of 2 mm in range, half of 0.01 deg in azimuth at up to 20 m, and as much for the second cycle of a block.
    CHECK(worst_place < 0.001 + 2 * 20 * 0.005 * 0.0174533);
  }
}

TEST_CASE("layouts: points of another sensor are refused for packets") {
  const TemporaryFolder folder;
  const auto writer = io::open_layout_writer(packets(), {folder.path(), "walk", 0, kSecond, {0.1, 16, 0}, {}});
  CHECK_THROWS_WITH(writer->add_sweep(spinning_walk().packets.front(), 0), Contains("none of a VLP-16"));
}
