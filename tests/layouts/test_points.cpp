/// Points of every form: their bytes by the published field tables, and what a reader makes of them.
#include <catch2/catch.hpp>
#include <cmath>

#include "layouts/written.hpp"

using namespace aslio;
using namespace aslio::test;
using io::LidarForm;
using io::PointOrder;
using io::PointOrigin;
using io::SweepMoment;

namespace {

constexpr int kU8 = 2, kU16 = 4, kU32 = 6, kF32 = 7, kF64 = 8;

io::Layout layout_of(LidarForm form) {
  io::Layout layout;
  layout.lidar.form = form;
  layout.reference.format = io::ReferenceFile::none;
  return layout;
}

/// The published table of a form, and where its points have line and time.
struct Published {
  const char* name;
  LidarForm form;
  std::uint32_t step;
  std::vector<PlainCloud::Field> fields;
  std::uint32_t line_at, time_at;
  double tick;  ///< a unit of its time [s]
  bool absolute;
  TimeNs resolution;  ///< [ns]
};

const std::vector<Published>& published() {
  static const std::vector<Published> all = {{"velodyne_pointcloud",
                                              LidarForm::velodyne,
                                              22,
                                              {{"x", 0, kF32},
                                               {"y", 4, kF32},
                                               {"z", 8, kF32},
                                               {"intensity", 12, kF32},
                                               {"ring", 16, kU16},
                                               {"time", 18, kF32}},
                                              16,
                                              18,
                                              1,
                                              false,
                                              4},
                                             {"ouster-ros",
                                              LidarForm::ouster,
                                              48,
                                              {{"x", 0, kF32},
                                               {"y", 4, kF32},
                                               {"z", 8, kF32},
                                               {"intensity", 16, kF32},
                                               {"t", 20, kU32},
                                               {"reflectivity", 24, kU16},
                                               {"ring", 26, kU16},
                                               {"ambient", 28, kU16},
                                               {"range", 32, kU32}},
                                              26,
                                              20,
                                              1e-9,
                                              false,
                                              0},
                                             {"ouster-ros until 2020",
                                              LidarForm::ouster_old,
                                              48,
                                              {{"x", 0, kF32},
                                               {"y", 4, kF32},
                                               {"z", 8, kF32},
                                               {"intensity", 16, kF32},
                                               {"t", 20, kU32},
                                               {"reflectivity", 24, kU16},
                                               {"ring", 26, kU8},
                                               {"noise", 28, kU16},
                                               {"range", 32, kU32}},
                                              26,
                                              20,
                                              1e-9,
                                              false,
                                              0},
                                             {"HesaiLidar_ROS_2.0",
                                              LidarForm::hesai,
                                              26,
                                              {{"x", 0, kF32},
                                               {"y", 4, kF32},
                                               {"z", 8, kF32},
                                               {"intensity", 12, kF32},
                                               {"ring", 16, kU16},
                                               {"timestamp", 18, kF64}},
                                              16,
                                              18,
                                              1,
                                              true,
                                              250},
                                             {"HesaiLidar_General_ROS",
                                              LidarForm::hesai_general,
                                              48,
                                              {{"x", 0, kF32},
                                               {"y", 4, kF32},
                                               {"z", 8, kF32},
                                               {"intensity", 16, kF32},
                                               {"timestamp", 24, kF64},
                                               {"ring", 32, kU16}},
                                              32,
                                              24,
                                              1,
                                              true,
                                              250},
                                             {"livox_ros_driver2",
                                              LidarForm::livox_cloud,
                                              26,
                                              {{"x", 0, kF32},
                                               {"y", 4, kF32},
                                               {"z", 8, kF32},
                                               {"intensity", 12, kF32},
                                               {"tag", 16, kU8},
                                               {"line", 17, kU8},
                                               {"timestamp", 18, kF64}},
                                              17,
                                              18,
                                              1e-9,
                                              true,
                                              250}};
  return all;
}

/// Of the field `time`, from the start of the sweep [s].
double time_in(const Published& form, std::span<const std::uint8_t> point, TimeNs start) {
  if (form.tick == 1e-9 && !form.absolute) return 1e-9 * at<std::uint32_t>(point, form.time_at);
  if (!form.absolute) return at<float>(point, form.time_at);
  const double value = form.tick * at<double>(point, form.time_at);
  return value - 1e-9 * static_cast<double>(start);
}

void check_read_back(const Walk& walk, const Written& written, const io::SensorConfig& sensor, TimeNs resolution) {
  const Split back = split(read({written / "walk.bag"}, sensor));
  REQUIRE(back.packets.size() == walk.packets.size());
  REQUIRE(back.imu.size() == walk.imu().size());
  for (std::size_t i = 0; i < back.packets.size(); ++i) {
    const auto got = sorted(back.packets[i].points), made = sorted(walk.packets[i].points);
    REQUIRE(got.size() == made.size());
    for (std::size_t k = 0; k < got.size(); ++k) {
      const bool same = got[k].x == made[k].x && got[k].y == made[k].y && got[k].z == made[k].z &&
                        got[k].line == made[k].line && std::abs(got[k].t - made[k].t) <= resolution;
      REQUIRE(same);
    }
  }
}

}  // namespace

TEST_CASE("layouts: clouds have the fields of the drivers, and a reader finds the points again") {
  const Walk& walk = spinning_walk();
  const LidarPacket& sweep = walk.packets.front();
  for (const Published& form : published()) {
    CAPTURE(form.name);
    const io::Layout layout = layout_of(form.form);
    const Written written(walk, layout);
    const PlainCloud cloud = take_apart(first_on(written / "walk.bag", "/velodyne_points").bytes);
    CHECK(cloud.fields == form.fields);
    CHECK(cloud.point_step == form.step);
    REQUIRE(cloud.data.size() == form.step * sweep.points.size());
    CHECK(cloud.width == sweep.points.size());
    CHECK(cloud.height == 1);
    for (const std::size_t i : {std::size_t{0}, std::size_t{1}, sweep.points.size() - 1}) {
      const auto point = std::span<const std::uint8_t>(cloud.data).subspan(form.step * i, form.step);
      const TimedPoint& made = sweep.points[i];
      CHECK(at<float>(point, 0) == made.x);
      CHECK(at<float>(point, 4) == made.y);
      CHECK(at<float>(point, 8) == made.z);
      CHECK(at<std::uint8_t>(point, form.line_at) == made.line);
      CHECK(std::abs(time_in(form, point, sweep.stamp) - 1e-9 * static_cast<double>(made.t - sweep.stamp)) < 5e-7);
    }
    check_read_back(walk, written, sensor_of(walk, layout), form.resolution);
  }
}

TEST_CASE("layouts: an organised cloud has a place for every beam, by row or by column") {
  const Walk& walk = spinning_walk();
  const LidarPacket& sweep = walk.packets.front();
  REQUIRE(sweep.points.size() < 16 * 400);
  for (const PointOrder order : {PointOrder::row, PointOrder::column}) {
    io::Layout layout = layout_of(LidarForm::ouster);
    layout.lidar.organised = true;
    layout.lidar.order = order;
    const Written written(walk, layout);
    const PlainCloud cloud = take_apart(first_on(written / "walk.bag", "/velodyne_points").bytes);
    const bool by_row = order == PointOrder::row;
    CHECK(cloud.height == (by_row ? 16 : 400));
    CHECK(cloud.width == (by_row ? 400 : 16));
    REQUIRE(cloud.data.size() == std::size_t{48} * 16 * 400);
    CHECK(cloud.row_step == 48 * cloud.width);
    // Line 3 of column 7, which fires 7 * 250 us after the start.
    const std::size_t place = by_row ? 3 * 400 + 7 : 7 * 16 + 3;
    const auto point = std::span<const std::uint8_t>(cloud.data).subspan(48 * place, 48);
    CHECK(at<std::uint32_t>(point, 20) == 7 * 250'000);
    CHECK(at<std::uint16_t>(point, 26) == 3);
    check_read_back(walk, written, sensor_of(walk, layout), 0);
  }
  io::Layout layout = layout_of(LidarForm::velodyne);
  layout.lidar.organised = true;
  const Written written(walk, layout);
  CHECK_FALSE(take_apart(first_on(written / "walk.bag", "/velodyne_points").bytes).dense);
  check_read_back(walk, written, sensor_of(walk, layout), 4);
}

TEST_CASE("layouts: stamps are of start, middle or end, and point times count from there") {
  const Walk& walk = spinning_walk();
  const TimeNs begin = walk.simulation.begin_time();
  const std::vector<std::tuple<SweepMoment, PointOrigin, io::LidarStamp, io::PointTime, TimeNs, float>> all = {
      {SweepMoment::end, PointOrigin::start, io::LidarStamp::end, io::PointTime::start, 100'000'000, 0.0F},
      {SweepMoment::end, PointOrigin::end, io::LidarStamp::end, io::PointTime::end, 100'000'000, -0.1F},
      {SweepMoment::end, PointOrigin::end, io::LidarStamp::automatic, io::PointTime::automatic, 100'000'000, -0.1F},
      {SweepMoment::middle, PointOrigin::start, io::LidarStamp::middle, io::PointTime::start, 50'000'000, 0.0F},
      {SweepMoment::middle, PointOrigin::middle, io::LidarStamp::automatic, io::PointTime::start, 50'000'000, -0.05F},
      {SweepMoment::start, PointOrigin::start, io::LidarStamp::automatic, io::PointTime::automatic, 0, 0.0F}};
  for (const auto& [stamp, origin, read_stamp, read_time, after, first_time] : all) {
    CAPTURE(after, first_time, static_cast<int>(read_stamp));
    io::Layout layout = layout_of(LidarForm::velodyne);
    layout.lidar.stamp = stamp;
    layout.lidar.point_time = origin;
    const Written written(walk, layout);
    const FirstMessage message = first_on(written / "walk.bag", "/velodyne_points");
    const PlainCloud cloud = take_apart(message.bytes);
    CHECK(cloud.stamp == begin + after);
    CHECK(message.time == begin + 100'000'000);
    CHECK(at<float>(cloud.data, 18) == Approx(first_time).margin(1e-6));
    io::SensorConfig sensor = sensor_of(walk, layout);
    sensor.times.lidar_stamp = read_stamp;
    sensor.times.point_time = read_time;
    check_read_back(walk, written, sensor, 8);
  }
}

TEST_CASE("layouts: a Livox message has its points where the definition says") {
  const Walk& walk = livox_walk();
  const LidarPacket& sweep = walk.packets.front();
  const Written written(walk, layout_of(LidarForm::livox));
  const FirstMessage message = first_on(written / "walk.bag", "/velodyne_points");
  CHECK(message.connection.type == "livox_ros_driver/CustomMsg");
  CHECK(message.connection.md5 == "e4d6829bdfe657cb6c21a746c86b21a6");
  // Header with the frame "velodyne": 24 bytes; timebase, number of points, id, 3 reserved, length of the list.
  const std::span<const std::uint8_t> bytes = message.bytes;
  CHECK(at<std::uint64_t>(bytes, 24) == static_cast<std::uint64_t>(sweep.stamp));
  CHECK(at<std::uint32_t>(bytes, 32) == sweep.points.size());
  REQUIRE(bytes.size() == 44 + 19 * sweep.points.size());
  const auto point = bytes.subspan(44 + 19 * 10, 19);
  const TimedPoint& made = sweep.points[10];
  CHECK(at<std::uint32_t>(point, 0) == static_cast<std::uint32_t>(made.t - sweep.stamp));
  CHECK(at<float>(point, 4) == made.x);
  CHECK(at<float>(point, 12) == made.z);
  CHECK(at<std::uint8_t>(point, 16) == static_cast<std::uint8_t>(made.intensity));
  CHECK(at<std::uint8_t>(point, 17) == made.tag);
  CHECK(at<std::uint8_t>(point, 18) == made.line);
}

TEST_CASE("layouts: half a turn is a sweep where a sensor turns at 20 Hz") {
  const Walk& walk = spinning_walk();
  io::Layout layout = layout_of(LidarForm::ouster);
  layout.lidar.organised = true;
  const Written written(walk, layout, 0.05);
  io::SensorConfig sensor = sensor_of(walk, layout);
  sensor.model.sweep_period = 0.05;
  const Split back = split(read({written / "walk.bag"}, sensor));
  REQUIRE(back.packets.size() == 2 * walk.packets.size());
  std::size_t points = 0;
  for (std::size_t i = 0; i < back.packets.size(); ++i) {
    CHECK(back.packets[i].stamp == walk.simulation.begin_time() + static_cast<TimeNs>(i) * 50'000'000);
    points += back.packets[i].points.size();
  }
  std::size_t made = 0;
  for (const LidarPacket& packet : walk.packets) made += packet.points.size();
  CHECK(points == made);
}
