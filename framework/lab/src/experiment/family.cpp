// From a family file to its sequences.
#include "aslio/experiment/family.hpp"

#include <fmt/format.h>
#include <fnmatch.h>

#include <algorithm>
#include <set>

#include "aslio/config/document.hpp"
#include "aslio/config/load.hpp"
#include "aslio/config/named_paths.hpp"
#include "aslio/config/names.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/plugin/registry.hpp"
#include "matching_paths.hpp"
#include "study_axes.hpp"

namespace aslio::experiment {

namespace {

namespace fs = std::filesystem;

constexpr double kMaxSeconds = 1e9;  // some 30 years; in nanoseconds it still fits
constexpr double kMaxCount = 1e9;

/// What is wrong with one alternative of a pattern; empty: nothing.
std::string trouble_of_one(const std::string& pattern) {
  std::string rest = pattern;
  for (const std::string_view placeholder : {"{sequence}", "{variant}"}) {
    for (std::size_t at = rest.find(placeholder); at != std::string::npos; at = rest.find(placeholder)) {
      rest.replace(at, placeholder.size(), "x");
    }
  }
  if (rest.empty()) return "must name a file, a folder or a pattern";
  if (rest.find_first_of("{}") != std::string::npos) {
    return fmt::format("'{}': there are the placeholders {{sequence}} and {{variant}}, and no other braces", pattern);
  }
  const fs::path path = rest;
  if (path.is_absolute() || std::find(path.begin(), path.end(), "..") != path.end()) {
    return fmt::format("'{}': must lie in the data folder, to which it is relative", pattern);
  }
  return {};
}

/// What is wrong with a pattern of files; empty: nothing.
std::string trouble(const std::string& pattern) {
  for (const std::string& one : alternatives(pattern)) {
    if (std::string wrong = trouble_of_one(one); !wrong.empty()) return wrong;
  }
  return {};
}

std::string first_trouble(const std::vector<std::string>& patterns) {
  for (const std::string& pattern : patterns) {
    if (std::string wrong = trouble(pattern); !wrong.empty()) return wrong;
  }
  return {};
}

/// With the names for their placeholders.
std::string filled(std::string text, const FamilySequenceConfig& sequence) {
  const auto replace = [&](std::string_view placeholder, const std::string& value) {
    for (std::size_t at = text.find(placeholder); at != std::string::npos;
         at = text.find(placeholder, at + value.size())) {
      text.replace(at, placeholder.size(), value);
    }
  };
  replace("{sequence}", sequence.name);
  replace("{variant}", sequence.variant);
  return text;
}

const FamilyVariantConfig* variant_of(const FamilyConfig& family, const FamilySequenceConfig& sequence) {
  for (const FamilyVariantConfig& variant : family.variants) {
    if (variant.name == sequence.variant) return &variant;
  }
  return nullptr;
}

/// The parts that hold for a sequence. A sensor and its extrinsics belong together, and come from one place.
FamilyPartsConfig parts_of(const FamilyConfig& family, const FamilySequenceConfig& sequence) {
  FamilyPartsConfig parts = family.parts;
  if (const FamilyVariantConfig* variant = variant_of(family, sequence)) {
    if (!variant->parts.sensor.empty()) {
      parts.sensor = variant->parts.sensor;
      parts.extrinsics = variant->parts.extrinsics;
    }
    if (!variant->parts.input.empty()) parts.input = variant->parts.input;
    if (!variant->parts.reference.file.empty()) parts.reference = variant->parts.reference;
    if (variant->parts.stand_in.given()) parts.stand_in = variant->parts.stand_in;
  }
  if (!sequence.input.empty()) parts.input = sequence.input;
  if (!sequence.reference_file.empty()) parts.reference.file = sequence.reference_file;
  return parts;
}

/// What keeps the sequences from being read; empty: nothing.
std::string trouble(const FamilyConfig& family) {
  std::set<std::string> names;
  std::vector<std::string> variants;
  for (const FamilyVariantConfig& variant : family.variants) variants.push_back(variant.name);
  for (const FamilySequenceConfig& sequence : family.sequences) {
    if (!names.insert(sequence.name).second) return fmt::format("name '{}' twice", sequence.name);
    if (!sequence.variant.empty() && variant_of(family, sequence) == nullptr) {
      return fmt::format("name the variant '{}', which is not there{}", sequence.variant,
                         config::suggestion(sequence.variant, variants));
    }
    const FamilyPartsConfig parts = parts_of(family, sequence);
    const char* lacking = parts.sensor.empty()       ? "sensor"
                          : parts.extrinsics.empty() ? "extrinsics"
                          : parts.input.empty()      ? "input"
                                                     : nullptr;
    if (lacking != nullptr) {
      return fmt::format("hold '{}', for which neither the family nor a variant says '{}'", sequence.name, lacking);
    }
  }
  return {};
}

void require_sensor(config::Binder& b, const FamilyConfig& family, const config::NamedPaths& paths) {
  paths.require(b, "sensor", family.parts.sensor, config::NamedPaths::Wanted::file);
  for (const FamilyVariantConfig& variant : family.variants) {
    std::error_code ignored;
    const fs::path file = paths.at(variant.parts.sensor);
    b.require(variant.parts.sensor.empty() || fs::is_regular_file(file, ignored), "variants",
              fmt::format("name a sensor file that does not exist: {} (paths are relative to the folder of this file)",
                          file.string()));
  }
}

FamilySequence sequence_of(const FamilyConfig& family, const FamilySequenceConfig& config,
                           const config::NamedPaths& paths) {
  const FamilyPartsConfig parts = parts_of(family, config);
  FamilySequence sequence;
  sequence.name = config.name;
  sequence.variant = config.variant;
  sequence.sensor = paths.at(parts.sensor);
  for (const FamilyExtrinsicConfig& extrinsic : parts.extrinsics) {
    sequence.extrinsics.push_back({extrinsic.source, extrinsic.T_imu_lidar.pose()});
  }
  for (const std::string& pattern : parts.input) sequence.input.push_back(filled(pattern, config));
  if (!parts.reference.file.empty()) {
    sequence.reference = parts.reference;
    sequence.reference->file = filled(parts.reference.file, config);
    sequence.reference->times = filled(parts.reference.times, config);
  }
  sequence.stand_in = parts.stand_in;
  sequence.section = {config.start, config.duration};
  sequence.closed_loop = config.closed_loop;
  sequence.sweeps = config.sweeps;
  sequence.imu_samples = config.imu_samples;
  return sequence;
}

}  // namespace

void FamilyExtrinsicConfig::describe(config::Binder& b, FamilyExtrinsicConfig& extrinsic) {
  b.text("source", extrinsic.source, "who publishes it, and where; required");
  io::TransformBlock::describe(b, extrinsic.T_imu_lidar);
  b.require(!extrinsic.source.empty(), "source", "is required: say who publishes the extrinsic, and where");
}

void FamilyPartsConfig::describe(config::Binder& b, FamilyPartsConfig& parts) {
  b.text("sensor", parts.sensor, "sensor file, relative to the folder of this file");
  b.groups("extrinsics", parts.extrinsics,
           "every published pose of the LiDAR in the IMU frame (p_I = T_imu_lidar p_L); the first one is that of the "
           "sensor file");
  b.texts("input", parts.input, {},
          "files, folders or patterns (*, ?, [..]) that are one recording, relative to the data folder; {sequence} and "
          "{variant} stand for names; ' | ' separates alternatives");
  b.group("reference", parts.reference,
          "the truth; `file` and `times` are relative to the data folder, with the placeholders of `input`");
  b.group("stand_in", parts.stand_in, "how a simulator writes the sequences, where `input` and the sensor do not say");
  b.require(parts.sensor.empty() == parts.extrinsics.empty(), "extrinsics",
            "belong to a sensor file: give both or neither");
  const std::string wrong = first_trouble(parts.input);
  b.require(wrong.empty(), "input", wrong);
  const std::string wrong_file = parts.reference.file.empty() ? std::string() : trouble(parts.reference.file);
  b.require(wrong_file.empty(), "reference", wrong_file);
}

void FamilyVariantConfig::describe(config::Binder& b, FamilyVariantConfig& variant) {
  b.text("name", variant.name, "name that sequences give as `variant`; required");
  FamilyPartsConfig::describe(b, variant.parts);
  b.require(valid_name(variant.name), "name", kNameRule);
}

void FamilySequenceConfig::describe(config::Binder& b, FamilySequenceConfig& sequence) {
  b.text("name", sequence.name, "name of the sequence; required");
  b.text("variant", sequence.variant, "entry of `variants` that it belongs to; empty: none");
  b.integer("sweeps", sequence.sweeps, "1", {.min = 0.0, .max = kMaxCount}, "LiDAR messages it has; 0: not known");
  b.integer("imu_samples", sequence.imu_samples, "1", {.min = 0.0, .max = kMaxCount},
            "IMU messages it has; 0: not known");
  b.texts("input", sequence.input, {}, "replaces that of the family or variant");
  b.text("reference_file", sequence.reference_file, "replaces the file of the reference");
  b.flag("closed_loop", sequence.closed_loop, "whether the motion ends in the pose in which it begins");
  b.real("start", sequence.start, "s", {.min = 0.0, .max = kMaxSeconds}, "data to skip");
  b.optional_real("duration", sequence.duration, "s", {.above = 0.0, .max = kMaxSeconds}, "to the end", "data to use");
  b.require(valid_name(sequence.name), "name", kNameRule);
  const std::string wrong = first_trouble(sequence.input);
  b.require(wrong.empty(), "input", wrong);
  const std::string wrong_file = sequence.reference_file.empty() ? std::string() : trouble(sequence.reference_file);
  b.require(wrong_file.empty(), "reference_file", wrong_file);
}

void FamilyConfig::describe(config::Binder& b, FamilyConfig& family) {
  b.text("title", family.title, "name of the data set; required");
  b.text("description", family.description, "what it is, for people");
  b.text("sensors", family.sensors, "LiDAR and IMU, for people");
  b.text("licence", family.licence, "terms of use of the data");
  b.text("citation", family.citation, "the publication to cite");
  b.text("url", family.url, "where to get the data; required");
  b.text("verified", family.verified, "what has been checked, and on which data; required");
  FamilyPartsConfig::describe(b, family.parts);
  b.groups("variants", family.variants, "other sensors or layouts; what a variant gives replaces what stands above");
  b.groups("sequences", family.sequences, "the recordings");
  b.require(!family.title.empty(), "title", "is required: name the data set");
  b.require(!family.url.empty(), "url", "is required: say where to get the data");
  b.require(!family.verified.empty(), "verified", "is required: say what has been checked, and on which data");
  b.require(!family.sequences.empty(), "sequences", "is required: list the recordings");
  const std::string wrong = trouble(family);
  b.require(wrong.empty(), "sequences", wrong);
}

Family load_family(const fs::path& file) {
  Family family;
  family.file = file;
  family.name = file.stem().string();
  const config::NamedPaths paths(file.parent_path());
  family.resolved =
      config::bind_text(config::read_text(file), file.string(), config::FileKind::family, plugin::Catalog(), {},
                        [&](config::Binder& b) {
                          FamilyConfig::describe(b, family.config);
                          require_sensor(b, family.config, paths);
                        })
          .resolved;
  for (const FamilySequenceConfig& sequence : family.config.sequences) {
    family.sequences.push_back(sequence_of(family.config, sequence, paths));
  }
  return family;
}

const FamilySequence& find_sequence(const Family& family, const std::string& name) {
  std::vector<std::string> names;
  for (const FamilySequence& sequence : family.sequences) {
    if (sequence.name == name) return sequence;
    names.push_back(sequence.name);
  }
  const std::string near = config::nearest(name, names);
  throw ConfigError(fmt::format("{} has no sequence '{}'{}; there are: {}", family.name, name,
                                near.empty() ? "" : fmt::format(" (did you mean '{}'?)", near), config::join(names)));
}

std::vector<const FamilySequence*> select_sequences(const Family& family, const std::vector<std::string>& patterns) {
  std::vector<bool> selected(family.sequences.size(), false);
  for (const std::string& pattern : patterns) {
    bool found = false;
    for (std::size_t i = 0; i < family.sequences.size(); ++i) {
      if (::fnmatch(pattern.c_str(), family.sequences[i].name.c_str(), 0) != 0) continue;
      selected[i] = found = true;
    }
    if (!found) find_sequence(family, pattern);  // throws
  }
  std::vector<const FamilySequence*> out;
  for (std::size_t i = 0; i < selected.size(); ++i) {
    if (selected[i]) out.push_back(&family.sequences[i]);
  }
  return out;
}

}  // namespace aslio::experiment
