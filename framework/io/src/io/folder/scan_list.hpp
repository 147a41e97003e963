#pragma once
/// The scans of a folder with their stamps.

#include <filesystem>
#include <string>
#include <vector>

#include "folder_recording.hpp"

namespace aslio::io {

/// Whether the name of a file ends as that of a scan does: .bin, .pcd, .ply.
bool is_scan_file(const std::filesystem::path& path);

/// The scans of one extension in `folder`, by their stamps. These are in the names (`sec_nsec`, `sec.nsec`, whole
/// seconds, ms, us or ns) or, where the names count, in a file of times in the folder or beside it. The unit is that
/// in which the median step fits the sweep period [s]. `verdict` tells what was found. Throws DataError.
std::vector<ScanFile> list_scans(const std::filesystem::path& folder, double sweep_period, std::string& verdict);

}  // namespace aslio::io
