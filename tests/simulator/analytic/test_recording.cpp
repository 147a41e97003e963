#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>

#include "aslio/core/errors.hpp"
#include "aslio/io/writers.hpp"
#include "aslio/simulator/analytic_world.hpp"

using namespace aslio;
using namespace aslio::simulator;
namespace fs = std::filesystem;

namespace {

/// A folder of this test's own, gone afterwards.
struct Folder {
  explicit Folder(const char* name) : path(fs::path(ASLIO_BINARY_DIR) / name) { fs::remove_all(path); }
  ~Folder() { fs::remove_all(path); }
  fs::path path;
};

Options short_world() {
  Options options;
  options.duration_scale = 0.5;
  options.seed = 3;
  return options;
}

void check_equal(const LidarPacket& read, const LidarPacket& made) {
  REQUIRE(read.stamp == made.stamp);
  REQUIRE(read.points.size() == made.points.size());
  for (std::size_t i = 0; i < made.points.size(); ++i) {
    const TimedPoint &a = read.points[i], &b = made.points[i];
    REQUIRE((a.x == b.x && a.y == b.y && a.z == b.z && a.t == b.t && a.line == b.line && a.intensity == b.intensity));
  }
}

void check_equal(const ImuSample& read, const ImuSample& made) {
  REQUIRE(read.t == made.t);
  REQUIRE(read.gyro == made.gyro);
  REQUIRE((read.acc - made.acc).norm() < 1e-12);
}

}  // namespace

TEST_CASE("the bag and the truth read back as they were made") {
  const Folder folder("simulated_recording");
  const AnalyticWorld world(short_world());
  double last = 0;
  write_recording(world, folder.path, [&](double share) {
    CHECK(share >= last);
    last = share;
  });
  CHECK(last == Approx(1).margin(1e-3));

  io::SensorConfig sensor;
  sensor.lidar_topic = "/livox/lidar";
  sensor.imu_topic = "/livox/imu";
  sensor.model = world.sensor();
  const auto bag = io::open_source(folder.path / "world.bag", sensor);
  const auto source = world.source();
  std::size_t count = 0;
  while (const auto made = source->next()) {
    const auto read = bag->next();
    REQUIRE(read);
    REQUIRE(read->index() == made->index());
    if (const auto* packet = std::get_if<LidarPacket>(&*made))
      check_equal(std::get<LidarPacket>(*read), *packet);
    else
      check_equal(std::get<ImuSample>(*read), std::get<ImuSample>(*made));
    ++count;
  }
  CHECK_FALSE(bag->next());
  CHECK(bag->status() == io::InputStatus::complete);
  CHECK(count == 100 + 2001);

  const std::vector<StampedPose> truth = io::read_tum(folder.path / "truth.tum");
  REQUIRE(truth.size() == world.truth().size());
  for (std::size_t i = 0; i < truth.size(); i += 50) {
    const Pose expected = world.pose(truth[i].t);
    CHECK(truth[i].t == world.truth().samples()[i].t);
    CHECK((truth[i].T.p - expected.p).norm() < 1e-8);
    CHECK((truth[i].T.R - expected.R).norm() < 1e-8);
  }
}

TEST_CASE("a folder that cannot be made is named") {
  const Folder folder("simulated_recording_blocked");
  fs::create_directories(folder.path);
  io::AtomicFile file(folder.path / "file");
  file.close();
  const AnalyticWorld world(short_world());
  CHECK_THROWS_AS(write_recording(world, folder.path / "file" / "sub"), DataError);
  CHECK_THROWS_WITH(write_recording(world, folder.path / "file" / "sub"), Catch::Contains("file/sub"));
}
