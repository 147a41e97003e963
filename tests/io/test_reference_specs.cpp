// The keys of a reference, and the frame that they put it in.
#include <catch2/catch.hpp>
#include <fstream>

#include "aslio/core/errors.hpp"
#include "aslio/io/reference.hpp"
#include "io/bag_fixture.hpp"

namespace aslio::io::test {
namespace {

std::string config_error(const std::function<void()>& action) {
  try {
    action();
  } catch (const ConfigError& error) {
    return error.what();
  }
  return {};
}

}  // namespace

TEST_CASE("a plain path and a file of keys name a reference") {
  const TemporaryFolder folder;
  const ReferenceSpec plain = load_reference_spec("some/truth.csv", {"time_unit=ns", "lever_arm=[1, 2, 3]"});
  CHECK(plain.file == "some/truth.csv");
  CHECK(plain.time_unit == TimeUnit::ns);
  CHECK(pose_in_imu(plain).p == Vec3(1, 2, 3));
  std::ofstream(folder / "truth.yaml") << "schema: aslio/reference/1\nfile: gt/poses.txt\ntimes: times.txt\n"
                                          "association: at_reference\nmax_gap: 0.5\n";
  CHECK_THAT(config_error([&] { (void)load_reference_spec(folder / "truth.yaml"); }),
             Catch::Contains("truth.yaml: names what does not exist") && Catch::Contains("gt/poses.txt"));
  std::filesystem::create_directory(folder / "gt");
  std::ofstream(folder / "gt/poses.txt") << "0\n";
  std::ofstream(folder / "times.txt") << "0\n";
  const ReferenceSpec spec = load_reference_spec(folder / "truth.yaml", {"time_offset=0.25"});
  CHECK(spec.file == (folder / "gt/poses.txt").string());
  CHECK(spec.times == (folder / "times.txt").string());
  CHECK(spec.association == Association::at_reference);
  CHECK(*spec.max_gap == 0.5);
  CHECK(spec.time_offset == 0.25);
  const std::string text = resolved_text(spec);
  CHECK(resolved_text(parse_reference_spec(text, "again")) == text);
}

TEST_CASE("keys that do not go together are told with their place") {
  const auto refusal = [](const std::vector<std::string>& sets) {
    return config_error([&] { (void)load_reference_spec("truth.tum", sets); });
  };
  CHECK_THAT(refusal({"tiem_unit=ns"}), Catch::Contains("unknown key 'tiem_unit' (did you mean 'time_unit'?)"));
  CHECK_THAT(refusal({"time_unit=h"}), Catch::Contains("'time_unit' must be one of auto, s, ms, us, ns, is 'h'"));
  CHECK_THAT(refusal({"lever_arm=[1, 2]"}), Catch::Contains("must be 3 numbers"));
  CHECK_THAT(refusal({"lever_arm=[1, 2, 3]", "frame=base"}), Catch::Contains("give one of lever_arm"));
  CHECK_THAT(refusal({"T_imu_reference.quaternion=[0, 0, 0, 0.5]"}), Catch::Contains("x y z w of norm 1"));
  CHECK_THAT(refusal({"T_imu_reference.rotation=[1, 0, 0, 0, 1, 0, 0, 0, -1]"}), Catch::Contains("determinant 1"));
  CHECK_THAT(refusal({"file=other.tum"}), Catch::Contains("'file' names another one"));
}

TEST_CASE("the frame of a reference is a chain of named transforms") {
  // T_imu_base = T_imu_lidar T_base_lidar^-1, as for a reference in the base of a robot.
  SensorConfig sensor;
  sensor.model.T_imu_lidar = {exp_so3(Vec3(0, 0, 0.3)), Vec3(0.1, 0.2, 0.3)};
  sensor.transforms.push_back({"base", "lidar", {{0, 0, 0.124}, {}, {0, 0, 1, 0}}});
  ReferenceSpec spec;
  spec.frame = "base";
  const Pose T_base_lidar{exp_so3(Vec3(0, 0, 3.14159265358979323846)), Vec3(0, 0, 0.124)};
  const Pose expected = sensor.model.T_imu_lidar * T_base_lidar.inverse();
  const Pose found = pose_in_imu(spec, sensor.all_transforms());
  CHECK((found.R - expected.R).norm() < 1e-12);
  CHECK((found.p - expected.p).norm() < 1e-12);
  spec.frame = "prism";
  CHECK_THAT(config_error([&] { (void)pose_in_imu(spec, sensor.all_transforms()); }),
             Catch::Contains("no transform leads from frame 'imu' to 'prism'; there are: base, imu, lidar; add one to "
                             "`transforms`"));
  spec.transforms.push_back({"base", "prism", {{1, 0, 0}, {}, {}}});
  CHECK((pose_in_imu(spec, sensor.all_transforms()).p - expected * Vec3(1, 0, 0)).norm() < 1e-12);
  spec.frame.clear();
  CHECK(pose_in_imu(spec, sensor.all_transforms()).p.norm() == 0);
  sensor.transforms.push_back({"imu", "reference", {{4, 5, 6}, {}, {}}});
  CHECK(pose_in_imu(spec, sensor.all_transforms()).p == Vec3(4, 5, 6));
}

TEST_CASE("a protocol sets what the keys leave open") {
  ReferenceSpec spec = load_reference_spec("truth.tum", {"protocol=ntu_viral"});
  CHECK(spec.lever_arm.empty());
  spec = with_protocol(spec);
  CHECK(spec.lever_arm == std::vector<double>{-0.293656, -0.012288, -0.273095});
  CHECK(spec.positions_only == PositionsOnly::yes);
  CHECK(*spec.max_neighbour == 0.1);
  spec = with_protocol(load_reference_spec("truth.tum", {"protocol=hilti_2022", "lever_arm=[0, 0, 0]"}));
  CHECK(spec.lever_arm == std::vector<double>{0, 0, 0});
  CHECK(spec.association == Association::nearest);
  CHECK(spec.max_difference == 2);
}

}  // namespace aslio::io::test
