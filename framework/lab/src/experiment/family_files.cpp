// Files of a family: those in the folder of the user, and the family files themselves.
#include <fmt/format.h>

#include <algorithm>
#include <system_error>

#include "aslio/config/names.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/experiment/family.hpp"
#include "matching_paths.hpp"

namespace aslio::experiment {

namespace {

namespace fs = std::filesystem;

constexpr const char* kRecording = "recording";
constexpr const char* kReference = "reference";

/// What the first alternative that is there stands for; empty: none is there.
std::vector<fs::path> found_in(const fs::path& data, const std::string& pattern) {
  for (const std::string& path : alternatives(pattern)) {
    std::error_code ignored;
    if (fs::exists(data / path, ignored)) return {(data / path).lexically_normal()};
    if (!is_pattern(path)) continue;
    if (auto found = matching_paths(data, path); !found.empty()) return found;
  }
  return {};
}

/// Several files that one pattern matches stay a pattern, so that their reader orders them and names missing parts.
void append_input(const fs::path& data, const std::string& pattern, std::vector<fs::path>& inputs) {
  for (const std::string& path : alternatives(pattern)) {
    const std::vector<fs::path> found = found_in(data, path);
    if (found.empty()) continue;
    if (found.size() == 1 || is_pattern(data.string())) {
      inputs.insert(inputs.end(), found.begin(), found.end());
    } else {
      inputs.push_back(pattern_in(data, path));
    }
    return;
  }
}

void require_files(const Family& family, const FamilySequence& sequence, const fs::path& data) {
  const std::string name = family.name + "/" + sequence.name;
  std::error_code ignored;
  if (!fs::is_directory(data, ignored)) {
    throw ConfigError(
        fmt::format("--data {}: is no folder; name the one that holds the files of {}", data.string(), family.name));
  }
  std::string missing;
  for (const ExpectedFile& file : expected_files(sequence)) {
    if (found_in(data, file.pattern).empty()) missing += fmt::format("\n  {} ({})", file.pattern, file.purpose);
  }
  if (missing.empty()) return;
  throw ConfigError(
      fmt::format("{}: the data folder {} lacks{}\nget the data from {}; the names are relative to the data folder",
                  name, data.string(), missing, family.config.url));
}

/// The only file that a path of the reference means.
std::string reference_path(const std::string& pattern, const fs::path& data) {
  if (pattern.empty()) return {};
  const std::vector<fs::path> found = found_in(data, pattern);
  if (found.size() == 1) return found.front().string();
  throw ConfigError(fmt::format("{}: {} of the reference, and one is due{}", (data / pattern).string(),
                                found.empty() ? "no file" : fmt::format("{} files", found.size()),
                                found.empty() ? "" : ": keep one of them there, or name it by --reference"));
}

/// What makes the sequence what it is; of its files there is more in recording_identity().
std::string identity_text(const Family& family, const FamilySequence& sequence) {
  return fmt::format("family: {}\nsequence: {}\ninput: [{}]\nstart: {}\nduration: {}\nclosed_loop: {}\n", family.name,
                     sequence.name, fmt::join(sequence.input, ", "), sequence.section.start,
                     sequence.section.duration.value_or(0), sequence.closed_loop);
}

}  // namespace

std::vector<ExpectedFile> expected_files(const FamilySequence& sequence) {
  std::vector<ExpectedFile> files;
  for (const std::string& pattern : sequence.input) files.push_back({pattern, kRecording});
  if (!sequence.reference) return files;
  for (const std::string& pattern : {sequence.reference->file, sequence.reference->times}) {
    const bool listed =
        std::any_of(files.begin(), files.end(), [&](const ExpectedFile& file) { return file.pattern == pattern; });
    if (!pattern.empty() && !listed) files.push_back({pattern, kReference});
  }
  return files;
}

Dataset dataset_of(const Family& family, const FamilySequence& sequence, const fs::path& data) {
  require_files(family, sequence, data);
  Dataset dataset;
  dataset.file = family.file;
  dataset.name = sequence.name;
  dataset.description = family.config.title;
  for (const std::string& pattern : sequence.input) append_input(data, pattern, dataset.inputs);
  dataset.sensor = sequence.sensor;
  dataset.reference = sequence.reference;
  if (dataset.reference) {
    dataset.reference->file = reference_path(dataset.reference->file, data);
    dataset.reference->times = reference_path(dataset.reference->times, data);
  }
  dataset.section = sequence.section;
  dataset.closed_loop = sequence.closed_loop;
  dataset.published = {.family = family.name,
                       .sequence = sequence.name,
                       .data = data,
                       .extrinsic_source = sequence.extrinsics.front().source,
                       .extrinsics = sequence.extrinsics,
                       .sweeps = sequence.sweeps,
                       .imu_samples = sequence.imu_samples};
  dataset.resolved = identity_text(family, sequence);
  return dataset;
}

std::vector<std::string> count_warnings(const PublishedSequence& published, std::int64_t sweeps,
                                        std::int64_t imu_samples) {
  std::vector<std::string> warnings;
  const auto compare = [&](std::int64_t due, std::int64_t read, const char* what) {
    if (due == 0 || due == read) return;
    warnings.push_back(fmt::format("{}/{} has {} {} as published, and {} were read: {}", published.family,
                                   published.sequence, due, what, read,
                                   read < due ? "is a part missing, or a file cut short?" : "is it another version?"));
  };
  compare(published.sweeps, sweeps, "sweeps");
  compare(published.imu_samples, imu_samples, "IMU samples");
  return warnings;
}

std::optional<FamilyName> parse_family_name(std::string_view text) {
  const std::size_t slash = text.rfind('/');
  if (slash == std::string_view::npos || slash == 0 || slash + 1 == text.size()) return std::nullopt;
  return FamilyName{std::string(text.substr(0, slash)), std::string(text.substr(slash + 1))};
}

std::vector<fs::path> family_files(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    if (it->path().extension() == ".yaml") files.push_back(it->path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

fs::path find_family(const std::string& family, const fs::path& shipped) {
  std::error_code ignored;
  if (fs::is_regular_file(family, ignored)) return family;
  std::vector<std::string> names;
  for (const fs::path& file : family_files(shipped)) {
    if (file.stem() == family) return file;
    names.push_back(file.stem().string());
  }
  const std::string near = config::nearest(family, names);
  throw ConfigError(fmt::format("there is no family '{}'{}; give the path of a family file, or one of: {}", family,
                                near.empty() ? "" : fmt::format(" (did you mean '{}'?)", near), config::join(names)));
}

}  // namespace aslio::experiment
