/// References as data sets publish them, against the truth of the simulation.
#include <Eigen/Geometry>
#include <catch2/catch.hpp>

#include "aslio/io/reference.hpp"
#include "layouts/written.hpp"

using namespace aslio;
using namespace aslio::test;
using Catch::Matchers::StartsWith;
using io::ReferenceFile;

namespace {

io::Layout layout_of(ReferenceFile format) {
  io::Layout layout;
  layout.lidar.form = io::LidarForm::ouster;
  layout.reference.format = format;
  layout.reference.T_imu_reference.translation = {0.1, -0.2, 0.3};
  layout.reference.T_imu_reference.quaternion = {0, 0, 0.70710678118654752, 0.70710678118654752};
  return layout;
}

/// Poses of the frame of the reference by hand: the IMU's, a quarter turn about z and an offset.
void check_against_truth(const Walk& walk, const std::vector<StampedPose>& poses, bool positions_only,
                         const Vec3& origin, double tolerance) {
  REQUIRE(poses.size() == 11);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    CHECK(poses[i].t == walk.simulation.begin_time() + static_cast<TimeNs>(i) * 100'000'000);
    const auto motion = walk.simulation.motion().at(0.1 * static_cast<double>(i));
    CHECK((poses[i].T.p - (motion.p + motion.R * Vec3(0.1, -0.2, 0.3) + origin)).norm() < tolerance);
    Mat3 quarter;
    quarter << 0, -1, 0, 1, 0, 0, 0, 0, 1;
    const Mat3 R = positions_only ? Mat3(Mat3::Identity()) : Mat3(motion.R * quarter);
    CHECK((poses[i].T.R - R).norm() < 1e-9);
  }
}

}  // namespace

TEST_CASE("layouts: a reference is in its frame, at its rate, in the columns of its table") {
  const Walk& walk = spinning_walk();
  SECTION("TUM") {
    const Written written(walk, layout_of(ReferenceFile::tum));
    CHECK_THAT(lines(written / "walk.tum").front(), StartsWith("1700000000.000000000 "));
    io::ReferenceSpec spec(written / "walk.tum");
    spec.positions_only = io::PositionsOnly::no;
    check_against_truth(walk, io::read_reference(spec).poses, false, Vec3::Zero(), 1e-9);
  }
  SECTION("a table of seconds and nanoseconds, as the Newer College Dataset has it") {
    io::Layout layout = layout_of(ReferenceFile::csv);
    layout.reference.file = "{sequence}/gt-nc-{sequence}.csv";
    layout.reference.columns = {"sec", "nsec", "x", "y", "z", "qx", "qy", "qz", "qw"};
    const Written written(walk, layout);
    const auto rows = lines(written / "walk/gt-nc-walk.csv");
    CHECK_THAT(rows[0], StartsWith("1700000000,0,"));
    CHECK_THAT(rows[1], StartsWith("1700000000,100000000,"));
    io::ReferenceSpec spec(written / "walk/gt-nc-walk.csv");
    spec.columns = layout.reference.columns;
    spec.positions_only = io::PositionsOnly::no;
    check_against_truth(walk, io::read_reference(spec).poses, false, Vec3::Zero(), 1e-9);
  }
  SECTION("positions in UTM, without orientation, in nanoseconds, with a header and spaces") {
    io::Layout layout = layout_of(ReferenceFile::csv);
    layout.reference.columns = {"t", "x", "y", "z", "qx", "qy", "qz", "qw"};
    layout.reference.time_unit = io::TimeUnit::ns;
    layout.reference.separator = " ";
    layout.reference.positions_only = true;
    layout.reference.origin = {483'000, 4'427'000, 1600};
    layout.reference.header = true;
    const Written written(walk, layout);
    const auto rows = lines(written / "walk.tum");
    CHECK(rows[0] == "t x y z qx qy qz qw");
    CHECK_THAT(rows[2], StartsWith("1700000000100000000 "));
    io::ReferenceSpec spec(written / "walk.tum");
    spec.columns = layout.reference.columns;
    spec.positions_only = io::PositionsOnly::no;
    check_against_truth(walk, io::read_reference(spec).poses, true, Vec3(483'000, 4'427'000, 1600), 1e-8);
  }
  SECTION("poses and points on a topic, in a bag and in MCAP") {
    for (const ReferenceFile format : {ReferenceFile::pose, ReferenceFile::point}) {
      for (const bool mcap : {false, true}) {
        io::Layout layout = layout_of(format);
        layout.reference.topic = "/leica/pose/relative";
        if (mcap) {
          layout.container = io::Container::mcap;
          layout.files = {"walk.mcap"};
        }
        const Written written(walk, layout);
        io::ReferenceSpec spec(written / (mcap ? "walk.mcap" : "walk.bag"));
        spec.topic = "/leica/pose/relative";
        if (format == ReferenceFile::pose) spec.positions_only = io::PositionsOnly::no;
        check_against_truth(walk, io::read_reference(spec).poses, format == ReferenceFile::point, Vec3::Zero(), 1e-12);
      }
    }
  }
}
