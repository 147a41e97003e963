#pragma once
/// The files of one recording: a file, a folder of its parts, or a pattern with `*` and `?`.

#include <filesystem>
#include <string>
#include <vector>

namespace aslio::io {

struct RecordingFiles {
  std::vector<std::filesystem::path> files;  ///< in the order of their part numbers; empty: a folder without any
  std::vector<std::string> warnings;         ///< listed but missing, numbers left out
  bool listed = false;                       ///< by a metadata.yaml, which says that they belong together
};

/// A folder is read by its metadata.yaml (rosbag2) where there is one, else by the names in it (.bag, .mcap, .db3, each
/// also with .zstd). Throws DataError for a pattern that matches nothing and for a metadata.yaml that cannot be used.
RecordingFiles find_recording_files(const std::filesystem::path& path);

/// A name without extension and without the number of a part: `run_2.db3.zstd` -> `run`.
std::string recording_stem(const std::filesystem::path& file);

/// A folder without recordings of messages: its scans are files.
bool is_folder_of_scans(const std::filesystem::path& path);

}  // namespace aslio::io
