/// The families of configs/datasets.

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>

#include "aslio/config/load.hpp"
#include "aslio/experiment/family.hpp"
#include "aslio/experiment/truth.hpp"
#include "aslio/io/source.hpp"
#include "aslio/plugin/registry.hpp"
#include "temporary_folder.hpp"

using namespace aslio;
using namespace aslio::experiment;

namespace fs = std::filesystem;

namespace {

const fs::path kConfigs = fs::path(ASLIO_SOURCE_DIR) / "configs";

std::vector<Family> shipped() {
  std::vector<Family> families;
  for (const fs::path& file : family_files(kConfigs / "datasets")) families.push_back(load_family(file));
  return families;
}

io::SensorConfig sensor_of(const FamilySequence& sequence) {
  return config::load<io::SensorConfig>(sequence.sensor, config::FileKind::sensor, plugin::Catalog()).value;
}

/// A walk of the IMU that turns about all axes.
std::vector<StampedPose> walk() {
  std::vector<StampedPose> poses;
  for (int k = 0; k < 200; ++k) {
    const double s = 0.1 * k;
    const Vec3 turn(0.3 * std::sin(0.9 * s), 0.2 * std::sin(0.4 * s), 0.7 * std::sin(0.5 * s));
    poses.push_back({1'700'000'000 * kSecond + k * (kSecond / 10),
                     {exp_so3(turn), Vec3(3 * std::sin(0.3 * s), 0.8 * s, 0.2 * std::sin(s))}});
  }
  return poses;
}

/// The walk as the data set would publish it: its columns and unit, poses of the frame at `T_imu_reference`.
void write_reference(const io::ReferenceSpec& spec, const Pose& T_imu_reference) {
  const std::vector<std::string> tum{"t", "x", "y", "z", "qx", "qy", "qz", "qw"};
  std::ofstream file(spec.file);
  for (const StampedPose& pose : walk()) {
    const Pose T = pose.T * T_imu_reference;
    const Eigen::Quaterniond q(T.R);
    const std::map<std::string, std::string> cells{
        {"t", spec.time_unit == io::TimeUnit::ns ? fmt::to_string(pose.t) : fmt::format("{:.9f}", to_seconds(pose.t))},
        {"sec", fmt::to_string(pose.t / kSecond)},
        {"nsec", fmt::to_string(pose.t % kSecond)},
        {"x", fmt::format("{:.9f}", T.p.x())},
        {"y", fmt::format("{:.9f}", T.p.y())},
        {"z", fmt::format("{:.9f}", T.p.z())},
        {"qx", fmt::format("{:.9f}", q.x())},
        {"qy", fmt::format("{:.9f}", q.y())},
        {"qz", fmt::format("{:.9f}", q.z())},
        {"qw", fmt::format("{:.9f}", q.w())},
        {"-", "0"}};
    for (const std::string& column : spec.columns.empty() ? tum : spec.columns) file << cells.at(column) << ' ';
    file << '\n';
  }
}

}  // namespace

TEST_CASE("every shipped family says what it is and where its values are from") {
  const std::vector<Family> families = shipped();
  REQUIRE(families.size() >= 18);
  for (const Family& family : families) {
    INFO(family.file);
    CHECK_FALSE(family.config.description.empty());
    CHECK_FALSE(family.config.sensors.empty());
    CHECK_FALSE(family.config.licence.empty());
    CHECK_FALSE(family.config.citation.empty());
    CHECK(family.config.url.starts_with("https://"));
    CHECK_FALSE(family.sequences.empty());
    for (const FamilyVariantConfig& variant : family.config.variants) {
      CHECK(std::any_of(family.sequences.begin(), family.sequences.end(),
                        [&](const FamilySequence& sequence) { return sequence.variant == variant.name; }));
    }
  }
}

TEST_CASE("the first extrinsic of a shipped family is that of its sensor file") {
  for (const Family& family : shipped()) {
    for (const FamilySequence& sequence : family.sequences) {
      INFO(family.name << "/" << sequence.name);
      const Pose T = sensor_of(sequence).model.T_imu_lidar;
      const PublishedExtrinsic& first = sequence.extrinsics.front();
      CHECK((T.p - first.T_imu_lidar.p).norm() < 1e-9);
      CHECK((T.R - first.T_imu_lidar.R).norm() < 1e-6);
      std::set<std::string> sources;
      for (const PublishedExtrinsic& extrinsic : sequence.extrinsics) {
        const Mat3& R = extrinsic.T_imu_lidar.R;
        CHECK((R.transpose() * R - Mat3::Identity()).norm() < 1e-9);
        CHECK(R.determinant() == Approx(1));
        CHECK(sources.insert(extrinsic.source).second);
      }
    }
  }
}

TEST_CASE("the reference of a shipped family can be placed in the frame of the IMU") {
  for (const Family& family : shipped()) {
    for (const FamilySequence& sequence : family.sequences) {
      if (!sequence.reference) continue;
      INFO(family.name << "/" << sequence.name);
      const io::ReferenceSpec spec = io::with_protocol(*sequence.reference);
      const Pose T = io::pose_in_imu(spec, sensor_of(sequence).all_transforms());
      CHECK(T.p.norm() < 1.0);
      CHECK_NOTHROW(io::parse_reference_spec(io::resolved_text(*sequence.reference), "resolved"));
    }
  }
}

TEST_CASE("a reference in the columns of a shipped family gives back the poses of the IMU") {
  const test::TemporaryFolder folder;
  std::set<std::string> read;
  for (const Family& family : shipped()) {
    for (const FamilySequence& sequence : family.sequences) {
      if (!sequence.reference || sequence.reference->format == io::ReferenceFormat::recording) continue;
      if (!read.insert(family.name + "/" + sequence.variant).second) continue;
      INFO(family.name << "/" << sequence.name);
      const io::SensorConfig sensor = sensor_of(sequence);
      io::ReferenceSpec spec = *sequence.reference;
      spec.file = folder / "reference.txt";
      write_reference(spec, io::pose_in_imu(spec, sensor.all_transforms()));
      const Truth truth = load_truth(spec, &sensor);
      const auto result = evaluate_against(truth, walk(), truth.options());
      CHECK(result.ate.translation.n > 190);
      CHECK(result.ate.translation.rmse < 1e-4);
      if (!truth.positions_only) CHECK(result.ate.rotation.rmse < 0.01);
    }
  }
  CHECK(read.size() >= 15);
}

TEST_CASE("every shipped family finds its files where its patterns say") {
  for (const Family& family : shipped()) {
    const FamilySequence& sequence = family.sequences.back();
    INFO(family.name << "/" << sequence.name);
    for (const ExpectedFile& file : expected_files(sequence)) {
      CHECK(file.pattern.find_first_of("{}") == std::string::npos);
      CHECK(file.pattern.find(sequence.name.substr(0, 4)) != std::string::npos);
    }
  }
}

TEST_CASE("the table of families in the documentation is the one of the files") {
  std::ifstream page(fs::path(ASLIO_SOURCE_DIR) / "docs/datasets.md");
  std::string text(std::istreambuf_iterator<char>(page), {});
  text.resize(std::min(text.find("\n## "), text.size()));  // the first table
  std::size_t rows = 0;
  for (const Family& family : shipped()) {
    const std::string row = "| `" + family.name + "` | " + family.config.title + " | " + family.config.sensors + " | " +
                            std::to_string(family.sequences.size()) + " | ";
    INFO(row);
    CHECK(text.find(row) != std::string::npos);
    ++rows;
  }
  std::size_t written = 0;
  for (std::size_t at = text.find("\n| `"); at != std::string::npos; at = text.find("\n| `", at + 1)) {
    const std::string name = text.substr(at + 4, text.find('`', at + 4) - at - 4);
    written += fs::exists(kConfigs / "datasets" / (name + ".yaml")) ? 1 : 0;
  }
  CHECK(written == rows);
}
