#pragma once
/// Reads point files back: maps of earlier runs, and the check of what a MapWriter wrote.

#include <filesystem>
#include <vector>

#include "aslio/core/lie.hpp"

namespace aslio::io {

struct CloudPoint {
  Eigen::Vector3f p = Eigen::Vector3f::Zero();  ///< [m]
  float intensity = 0;                          ///< sensor units; 0 when the file has none
};

/// All points of a .pcd or .ply file of any encoding, read by PCL; points that are not finite are left out. Throws
/// DataError that names the file, ConfigError for another extension or in a build without PCL.
std::vector<CloudPoint> read_cloud(const std::filesystem::path& path);

}  // namespace aslio::io
