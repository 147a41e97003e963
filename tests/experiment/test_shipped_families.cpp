/// The families of configs/datasets.

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <set>

#include "aslio/config/load.hpp"
#include "aslio/experiment/family.hpp"
#include "aslio/io/source.hpp"
#include "aslio/plugin/registry.hpp"

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
  const std::string text(std::istreambuf_iterator<char>(page), {});
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
