#include "recording_files.hpp"

#include <fmt/format.h>
#include <glob.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <string_view>

#include "aslio/core/errors.hpp"
#include "input_file.hpp"

namespace aslio::io {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 6> kSuffixes{".bag", ".mcap", ".db3", ".bag.zstd", ".mcap.zstd", ".db3.zstd"};

/// Empty for a file that is no recording by its name.
std::string_view suffix_of(const std::string& name) {
  std::string_view longest;
  for (const std::string_view suffix : kSuffixes) {
    if (name.ends_with(suffix) && suffix.size() > longest.size()) longest = suffix;
  }
  return longest;
}

struct PartName {
  std::string stem;
  std::optional<std::uint64_t> number;
};

PartName split(const fs::path& file) {
  std::string name = file.filename().string();
  name.resize(name.size() - suffix_of(name).size());
  const auto digits = name.find_last_not_of("0123456789");
  constexpr std::size_t kMaxDigits = 6;  // longer ones are times
  if (digits == std::string::npos || digits + 1 == name.size() || name[digits] != '_') return {name, {}};
  if (name.size() - digits - 1 > kMaxDigits) return {name, {}};
  return {name.substr(0, digits), std::stoull(name.substr(digits + 1))};
}

void sort_parts(std::vector<fs::path>& files) {
  std::sort(files.begin(), files.end(), [](const fs::path& a, const fs::path& b) {
    const PartName one = split(a), two = split(b);
    if (one.stem != two.stem) return one.stem < two.stem;
    return one.number != two.number ? one.number < two.number : a < b;
  });
}

/// `run_0` and `run_2`: a part was not copied.
void warn_of_missing_numbers(RecordingFiles& found) {
  for (std::size_t i = 1; i < found.files.size(); ++i) {
    const PartName before = split(found.files[i - 1]), here = split(found.files[i]);
    if (before.stem != here.stem || !before.number || !here.number || *here.number <= *before.number + 1) continue;
    found.warnings.push_back(fmt::format("between {} and {} there is no part {}: was it not copied?",
                                         found.files[i - 1].filename().string(), found.files[i].filename().string(),
                                         *before.number + 1));
  }
}

/// Of a file that is there both packed and decompressed, the latter.
void drop_packed_twins(RecordingFiles& found) {
  const std::vector<fs::path> all = found.files;
  std::erase_if(found.files, [&](const fs::path& file) {
    return file.extension() == ".zstd" &&
           std::find(all.begin(), all.end(), file.parent_path() / file.stem()) != all.end();
  });
}

/// `relative_file_paths` of rosbag2. Old versions wrote them from the folder above.
void read_metadata(const fs::path& folder, RecordingFiles& found) {
  const fs::path path = folder / "metadata.yaml";
  constexpr std::uint64_t kMaxBytes = 16U << 20U;
  if (InputFile(path).size() > kMaxBytes) throw DataError(fmt::format("{}: longer than 16 MiB", path.string()));
  try {
    const YAML::Node list = YAML::LoadFile(path.string())["rosbag2_bagfile_information"]["relative_file_paths"];
    if (!list.IsSequence()) throw DataError(fmt::format("{}: it lacks the list relative_file_paths", path.string()));
    std::vector<std::string> missing;
    for (const YAML::Node& item : list) {
      const fs::path relative = item.as<std::string>();
      const fs::path direct = folder / relative, beside = folder / relative.filename();
      std::error_code error;
      if (fs::is_regular_file(direct, error)) {
        found.files.push_back(direct);
      } else if (fs::is_regular_file(beside, error)) {
        found.files.push_back(beside);
      } else {
        missing.push_back(relative.string());
      }
    }
    found.listed = true;
    for (const std::string& name : missing) {
      found.warnings.push_back(
          fmt::format("metadata.yaml lists {}, which is not there: its messages are missing", name));
    }
  } catch (const YAML::Exception& error) {
    throw DataError(fmt::format("{}:{}: {}; remove it to read the files of this folder by their names", path.string(),
                                error.mark.line + 1, error.msg));
  }
}

RecordingFiles in_folder(const fs::path& folder) {
  RecordingFiles found;
  std::error_code error;
  if (fs::is_regular_file(folder / "metadata.yaml", error)) read_metadata(folder, found);
  if (!found.files.empty()) return found;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (entry.is_regular_file(error) && !suffix_of(entry.path().filename().string()).empty()) {
      found.files.push_back(entry.path());
    }
  }
  drop_packed_twins(found);
  sort_parts(found.files);
  warn_of_missing_numbers(found);
  return found;
}

RecordingFiles by_pattern(const fs::path& pattern) {
  glob_t matches{};
  RecordingFiles found;
  if (::glob(pattern.c_str(), 0, nullptr, &matches) == 0) {
    for (std::size_t i = 0; i < matches.gl_pathc; ++i) found.files.emplace_back(matches.gl_pathv[i]);
  }
  ::globfree(&matches);
  if (found.files.empty()) throw DataError(fmt::format("{}: no file matches this pattern", pattern.string()));
  drop_packed_twins(found);
  sort_parts(found.files);
  warn_of_missing_numbers(found);
  return found;
}

}  // namespace

std::string recording_stem(const fs::path& file) { return split(file).stem; }

RecordingFiles find_recording_files(const fs::path& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) return in_folder(path);
  const bool pattern = path.string().find_first_of("*?[") != std::string::npos;
  if (pattern && !fs::exists(path, error)) return by_pattern(path);
  return {{path}, {}, true};
}

bool is_folder_of_scans(const fs::path& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored) && find_recording_files(path).files.empty();
}

}  // namespace aslio::io
