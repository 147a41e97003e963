#pragma once
/// Families of published data sets: what `aslio run --dataset FAMILY/SEQUENCE --data DIR` reads (docs/datasets.md).

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "aslio/experiment/dataset.hpp"
#include "aslio/experiment/published_extrinsic.hpp"
#include "aslio/experiment/stand_in_config.hpp"
#include "aslio/io/reference.hpp"
#include "aslio/io/source.hpp"
#include "aslio/io/transforms.hpp"

namespace aslio::config {
class Binder;
}

namespace aslio::experiment {

/// One entry of `extrinsics`.
struct FamilyExtrinsicConfig {
  std::string source;
  io::TransformBlock T_imu_lidar;
  static void describe(config::Binder& b, FamilyExtrinsicConfig& extrinsic);
};

/// What a family says of all its sequences, and a variant of its own.
struct FamilyPartsConfig {
  std::string sensor;  ///< sensor file, relative to the family file
  std::vector<FamilyExtrinsicConfig> extrinsics;
  std::vector<std::string> input;  ///< patterns relative to the data folder
  io::ReferenceSpec reference;     ///< its paths are patterns, too; without a file: none
  StandInConfig stand_in;          ///< how a simulator writes it
  static void describe(config::Binder& b, FamilyPartsConfig& parts);
};

/// One entry of `variants`: sequences of another sensor or layout. What it gives replaces what the family gives.
struct FamilyVariantConfig {
  std::string name;
  FamilyPartsConfig parts;
  static void describe(config::Binder& b, FamilyVariantConfig& variant);
};

/// One entry of `sequences`.
struct FamilySequenceConfig {
  std::string name;
  std::string variant;                       ///< empty: none
  std::int64_t sweeps = 0, imu_samples = 0;  ///< published; 0: not known
  std::vector<std::string> input;            ///< replaces that of the family or variant
  std::string reference_file;                ///< the same of the file of the reference
  bool closed_loop = false;
  double start = 0;                ///< [s]
  std::optional<double> duration;  ///< [s]
  static void describe(config::Binder& b, FamilySequenceConfig& sequence);
};

/// Family file (`schema: aslio/family/1`) as written.
struct FamilyConfig {
  std::string title, description, sensors, licence, citation, url, verified;
  FamilyPartsConfig parts;
  std::vector<FamilyVariantConfig> variants;
  std::vector<FamilySequenceConfig> sequences;
  static void describe(config::Binder& b, FamilyConfig& family);
};

/// A sequence with everything that its family and its variant say of it; placeholders are filled in.
struct FamilySequence {
  std::string name, variant;
  std::filesystem::path sensor;                ///< exists
  std::vector<PublishedExtrinsic> extrinsics;  ///< the first one is that of the sensor file
  std::vector<std::string> input;              ///< patterns relative to the data folder
  std::optional<io::ReferenceSpec> reference;  ///< its paths are relative to the data folder
  StandInConfig stand_in;
  io::Section section;
  bool closed_loop = false;
  std::int64_t sweeps = 0, imu_samples = 0;  ///< 0: not known
};

/// A family file that has been checked.
struct Family {
  std::filesystem::path file;
  std::string name;  ///< stem of the file
  FamilyConfig config;
  std::vector<FamilySequence> sequences;  ///< in the order written
  std::string resolved;                   ///< YAML with every key at its effective value
};

/// Reads a family file. Throws ConfigError with everything that is wrong: file, line, column, remedy.
Family load_family(const std::filesystem::path& file);

/// The sequence of that name. Throws ConfigError that names the nearest one and all others.
const FamilySequence& find_sequence(const Family& family, const std::string& name);

/// The sequences that match any of the patterns (`*`, `?`, `[..]`), in the order of the family. Throws ConfigError
/// where one of them matches nothing.
std::vector<const FamilySequence*> select_sequences(const Family& family, const std::vector<std::string>& patterns);

/// One file, folder or pattern that a sequence reads, relative to the data folder.
struct ExpectedFile {
  std::string pattern;  ///< alternatives are separated by " | "
  std::string purpose;  ///< "recording", "reference"
};
std::vector<ExpectedFile> expected_files(const FamilySequence& sequence);

/// The sequence in a folder of the user. Throws ConfigError that lists what is missing there, and where to get it.
Dataset dataset_of(const Family& family, const FamilySequence& sequence, const std::filesystem::path& data);

/// A sentence for each count that differs from the published one. Pre: the whole recording was read.
std::vector<std::string> count_warnings(const PublishedSequence& published, std::int64_t sweeps,
                                        std::int64_t imu_samples);

/// "FAMILY/SEQUENCE", where FAMILY is the name of a shipped family or the path of a family file.
struct FamilyName {
  std::string family, sequence;
};
/// Nothing where `text` has no '/', or one at an end.
std::optional<FamilyName> parse_family_name(std::string_view text);

/// The families of a folder, by name. A folder that is not there has none.
std::vector<std::filesystem::path> family_files(const std::filesystem::path& folder);

/// The file that `family` means: itself where it is a file, else FAMILY.yaml in `shipped`. Throws ConfigError that
/// names the nearest one and all others.
std::filesystem::path find_family(const std::string& family, const std::filesystem::path& shipped);

}  // namespace aslio::experiment
