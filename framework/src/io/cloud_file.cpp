#include "aslio/io/cloud_file.hpp"

#include <fmt/format.h>

#include "aslio/core/errors.hpp"
#include "pcl_cloud.hpp"

namespace aslio::io {

std::vector<CloudPoint> read_cloud(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  if (extension != ".pcd" && extension != ".ply") {
    throw ConfigError(fmt::format("{}: '{}' is no point file; use .pcd or .ply", path.string(), extension));
  }
  std::vector<CloudPoint> points;
#ifdef ASLIO_HAVE_PCL
  const PointSink sink = [](void* context, float x, float y, float z, float intensity) {
    const CloudPoint point{{x, y, z}, intensity};
    if (point.p.allFinite()) static_cast<std::vector<CloudPoint>*>(context)->push_back(point);
  };
  const std::string why = read_cloud_with_pcl(path.c_str(), extension == ".ply", sink, &points);
  if (!why.empty()) throw DataError(fmt::format("{}: {}", path.string(), why));
  return points;
#else
  throw ConfigError(fmt::format("{}: this build cannot read point files; build with ASLIO_WITH_PCL=ON", path.string()));
#endif
}

}  // namespace aslio::io
