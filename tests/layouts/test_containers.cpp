/// Every container holds the same measurements, and a run on it ends at the same pose to the bit.
#include <catch2/catch.hpp>

#include "aslio/core/errors.hpp"
#include "aslio/io/layout_writer.hpp"
#include "layouts/written.hpp"

using namespace aslio;
using namespace aslio::test;
using Catch::Matchers::Contains;
using io::Container;
using io::FileSplit;
using io::Packing;

namespace {

namespace fs = std::filesystem;

struct Kind {
  const char* name;
  Container container;
  Packing packing;
  std::int64_t parts;
  std::vector<std::string> files;
  std::vector<std::string> inputs;    ///< what a user names
  std::vector<std::string> expected;  ///< files below the folder
};

const std::vector<Kind>& kinds() {
  static const std::vector<Kind> all = {
      {"bag", Container::rosbag, Packing::none, 1, {"{sequence}.bag"}, {"walk.bag"}, {"walk.bag"}},
      {"bag, lz4", Container::rosbag, Packing::lz4, 1, {"{sequence}.bag"}, {"walk.bag"}, {"walk.bag"}},
      {"three bags",
       Container::rosbag,
       Packing::none,
       3,
       {"{sequence}/{sequence}_{part}.bag"},
       {"walk"},
       {"walk/walk_0.bag", "walk/walk_1.bag", "walk/walk_2.bag"}},
      {"a bag for each topic",
       Container::rosbag,
       Packing::lz4,
       2,
       {"lidar_{part}.bag", "imu_{part}.bag"},
       {"lidar_*.bag", "imu_*.bag"},
       {"imu_0.bag", "imu_1.bag", "lidar_0.bag", "lidar_1.bag"}},
      {"database", Container::rosbag2, Packing::none, 1, {"{sequence}.db3"}, {"walk.db3"}, {"walk.db3"}},
      {"folder of rosbag2",
       Container::rosbag2,
       Packing::zstd,
       1,
       {"{sequence}"},
       {"walk"},
       {"walk/metadata.yaml", "walk/walk_0.db3"}},
      {"folder of rosbag2 in two parts",
       Container::rosbag2,
       Packing::none,
       2,
       {"{sequence}"},
       {"walk"},
       {"walk/metadata.yaml", "walk/walk_0.db3", "walk/walk_1.db3"}},
      {"two folders of rosbag2",
       Container::rosbag2,
       Packing::none,
       2,
       {"{sequence}-{part}"},
       {"walk-0", "walk-1"},
       {"walk-0/metadata.yaml", "walk-0/walk-0_0.db3", "walk-1/metadata.yaml", "walk-1/walk-1_0.db3"}},
      {"a folder of rosbag2 for each topic",
       Container::rosbag2,
       Packing::none,
       1,
       {"lidar", "imu"},
       {"lidar", "imu"},
       {"imu/imu_0.db3", "imu/metadata.yaml", "lidar/lidar_0.db3", "lidar/metadata.yaml"}},
      {"MCAP", Container::mcap, Packing::none, 1, {"{sequence}.mcap"}, {"walk.mcap"}, {"walk.mcap"}},
      {"MCAP, lz4", Container::mcap, Packing::lz4, 1, {"{sequence}.mcap"}, {"walk.mcap"}, {"walk.mcap"}},
      {"MCAP, zstd", Container::mcap, Packing::zstd, 1, {"{sequence}.mcap"}, {"walk.mcap"}, {"walk.mcap"}},
      {"folder of MCAP in two parts",
       Container::mcap,
       Packing::zstd,
       2,
       {"{sequence}"},
       {"walk"},
       {"walk/metadata.yaml", "walk/walk_0.mcap", "walk/walk_1.mcap"}}};
  return all;
}

io::Layout layout_of(const Kind& kind, io::LidarForm form) {
  io::Layout layout;
  layout.container = kind.container;
  layout.compression = kind.packing;
  layout.parts = kind.parts;
  layout.files = kind.files;
  layout.split = kind.files.size() > 1 ? FileSplit::by_topic : FileSplit::together;
  layout.lidar.form = form;
  layout.reference.format = io::ReferenceFile::none;
  return layout;
}

Recording read_back(const Kind& kind, const Walk& walk, io::LidarForm form) {
  const io::Layout layout = layout_of(kind, form);
  const Written written(walk, layout);
  CHECK(names_below(written.folder / "data") == kind.expected);
  std::vector<fs::path> inputs;
  for (const std::string& input : kind.inputs) inputs.push_back(written / input);
  return read(inputs, sensor_of(walk, layout));
}

}  // namespace

TEST_CASE("layouts: every container gives back what was simulated, to the bit") {
  const std::string spinning = digest(simulated(spinning_walk())), livox = digest(simulated(livox_walk()));
  for (const Kind& kind : kinds()) {
    CAPTURE(kind.name);
    CHECK(digest(read_back(kind, spinning_walk(), io::LidarForm::ouster)) == spinning);
    CHECK(digest(read_back(kind, livox_walk(), io::LidarForm::livox2)) == livox);
  }
  CHECK(digest(read_back(kinds().front(), livox_walk(), io::LidarForm::livox)) == livox);
}

TEST_CASE("layouts: a run ends in the same trajectory to the bit, whatever the container") {
  const Walk walk(simulator::SensorKind::avia, 2.5);
  std::vector<std::uint64_t> first;
  for (const std::size_t i : {0U, 2U, 3U, 6U, 11U}) {
    CAPTURE(kinds()[i].name);
    Run run(shipped("as_lio"), walk.simulation.claimed_sensor());
    run.play(read_back(kinds()[i], walk, io::LidarForm::livox2));
    REQUIRE(run.updates.size() > 10);
    if (first.empty()) first = run.digests();
    CHECK(run.digests() == first);
  }
}

TEST_CASE("layouts: topics, types and frames are those that the layout names") {
  const Kind& bag = kinds()[0];
  io::Layout layout = layout_of(bag, io::LidarForm::ouster);
  layout.lidar.topic = "/os_cloud_node/points";
  layout.lidar.frame_id = "os_sensor";
  layout.imu.topic = "/os_cloud_node/imu";
  layout.imu.frame_id = "os_imu";
  layout.imu.acc_unit = io::AccUnit::g;
  layout.imu.gyro_unit = io::GyroUnit::deg_s;
  const Written written(spinning_walk(), layout);
  const FirstMessage cloud = first_on(written / "walk.bag", "/os_cloud_node/points");
  CHECK(cloud.connection.type == "sensor_msgs/PointCloud2");
  CHECK(cloud.connection.md5 == "1158d486dd51d683ce2f1be655c3c181");
  CHECK(take_apart(cloud.bytes).frame == "os_sensor");
  CHECK(take_apart(cloud.bytes).stamp == spinning_walk().simulation.begin_time());
  CHECK(cloud.time == spinning_walk().simulation.begin_time() + 100'000'000);
  const FirstMessage imu = first_on(written / "walk.bag", "/os_cloud_node/imu");
  CHECK(imu.connection.md5 == "6a62c6daae103f4ff57a132d6f95cec2");
  // seq, stamp, length of the frame and "os_imu" are 22 bytes; orientation and its covariance 104.
  const ImuSample& sample = spinning_walk().imu().front();
  CHECK(std::string(imu.bytes.begin() + 16, imu.bytes.begin() + 22) == "os_imu");
  CHECK(at<double>(imu.bytes, 22 + 104) == Approx(sample.gyro.x() * 57.29577951308232));
  CHECK(at<double>(imu.bytes, 22 + 104 + 96 + 16) == Approx(sample.acc.z() / 9.80665));
}

TEST_CASE("layouts: MCAP and databases hold the definitions that ROS2 has of the messages") {
  const std::string header =
      "================================================================================\nMSG: std_msgs/Header\n"
      "builtin_interfaces/Time stamp\nstring frame_id\n";
  const std::string time =
      "================================================================================\nMSG: builtin_interfaces/Time\n"
      "int32 sec\nuint32 nanosec\n";
  const Written written(livox_walk(), layout_of(kinds()[9], io::LidarForm::livox2));
  const FirstMessage livox = first_on(written / "walk.mcap", "/velodyne_points");
  CHECK(livox.connection.type == "livox_ros_driver2/msg/CustomMsg");
  CHECK_THAT(livox.connection.definition, Contains(header) && Catch::Matchers::EndsWith(time));
  CHECK_THAT(livox.connection.definition, Catch::Matchers::StartsWith("std_msgs/Header header\nuint64 timebase\n"));
  CHECK(livox.connection.encoding == io::Encoding::cdr);
  const Written database(livox_walk(), layout_of(kinds()[4], io::LidarForm::livox2));
  CHECK_THAT(text_of(database / "walk.db3"), Contains(header) && Contains("ros2msg"));
}

TEST_CASE("layouts: what is not finished leaves no file under its name") {
  const TemporaryFolder folder;
  for (const Kind& kind : kinds()) {
    CAPTURE(kind.name);
    const io::Layout layout = layout_of(kind, io::LidarForm::ouster);
    io::LayoutPlace place{folder / kind.name, "walk", 0, kSecond, {0.1, 16, 400}, {}};
    {
      const auto writer = io::open_layout_writer(layout, place);
      writer->add_imu(spinning_walk().imu().front(), 0);
      writer->add_sweep(spinning_walk().packets.front(), 0);
    }
    CHECK(names_below(folder / kind.name).empty());
  }
}

TEST_CASE("layouts: what cannot be written is refused with its place") {
  const TemporaryFolder folder;
  const io::LayoutPlace place{folder.path(), "walk", 0, kSecond, {0.1, 16, 400}, {}};
  io::Layout layout = layout_of(kinds()[0], io::LidarForm::ouster);
  layout.files = {"walk.db3"};
  CHECK_THROWS_WITH(io::open_layout_writer(layout, place), Contains("walk.db3") && Contains(".bag"));
  layout.files = {"blocked/walk.bag"};
  folder.write("blocked", "a file where a folder should be");
  CHECK_THROWS_WITH(io::open_layout_writer(layout, place), Contains("blocked") && Contains("cannot create the folder"));
  layout.files = {"walk.bag"};
  layout.lidar.organised = true;
  CHECK_THROWS_WITH(io::open_layout_writer(layout, {folder.path(), "walk", 0, kSecond, {0.1, 16, 0}, {}}),
                    Contains("lidar.organised"));
  const auto writer = io::open_layout_writer(layout, {folder.path(), "walk", 0, kSecond, {0.1, 8, 400}, {}});
  CHECK_THROWS_WITH(writer->add_sweep(spinning_walk().packets.front(), 0), Contains("8 lines of 400 columns"));
}
