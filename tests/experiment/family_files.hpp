#pragma once
/// A family file with its sensor file, and a folder of data that it fits.

#include <string>

#include "aslio/experiment/family.hpp"
#include "cli/child.hpp"

namespace aslio::test {

/// The keys that every family needs besides its sensor, input and sequences.
inline std::string family_head() {
  return "schema: aslio/family/1\ntitle: Walks\nurl: https://example.org/walks\nverified: on made-up files\n";
}

inline std::string family_sensor() {
  return "sensor: sensor.yaml\nextrinsics:\n  - {source: maker, translation: [0.1, 0, 0]}\n"
         "  - {source: somebody else, translation: [0.2, 0, 0], quaternion: [0, 0, 1, 0]}\n";
}

struct FamilyFiles {
  TemporaryFolder folder;

  FamilyFiles() {
    write_text(
        folder / "sensor.yaml",
        "schema: aslio/sensor/1\nT_imu_lidar: {translation: [0.1, 0, 0], rotation: [1, 0, 0, 0, 1, 0, 0, 0, 1]}\n");
  }
  /// Writes walks.yaml of `text` and reads it.
  experiment::Family load(const std::string& text) const {
    write_text(folder / "walks.yaml", text);
    return experiment::load_family(folder / "walks.yaml");
  }
  /// The usual one: a bag and a table of poses for each sequence, in a folder of its name.
  experiment::Family usual(const std::string& sequences) const {
    return load(family_head() + family_sensor() +
                "input: ['{sequence}/{sequence}_*.bag | {sequence}.bag']\n"
                "reference: {file: '{sequence}/gt.txt', format: tum, lever_arm: [0, 0, 1]}\nsequences: [" +
                sequences + "]\n");
  }
  /// An empty file of the data, with the folders above it.
  void add(const std::string& name) const {
    const std::filesystem::path file = folder / ("data/" + name);
    std::filesystem::create_directories(file.parent_path());
    write_text(file, "");
  }
  std::filesystem::path data() const { return folder / "data"; }
};

}  // namespace aslio::test
