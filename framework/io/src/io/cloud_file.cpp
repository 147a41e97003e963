#include "aslio/io/cloud_file.hpp"

#include <fmt/format.h>

#include <fstream>
#include <sstream>
#include <string>

#include "aslio/core/errors.hpp"
#include "aslio/core/input_file.hpp"
#include "pcl_cloud.hpp"

namespace aslio::io {
namespace {

#ifdef ASLIO_HAVE_PCL
/// Numbers of a header line after its keyword; 0 where there is none.
std::uint64_t number_after(const std::string& header, const std::string& keyword) {
  const std::size_t at = header.find(keyword);
  if (at == std::string::npos) return 0;
  std::uint64_t value = 0;
  std::istringstream(header.substr(at + keyword.size(), 24)) >> value;
  return value;
}

constexpr std::uint64_t kLargestCloud = std::uint64_t{1} << 36U;

/// PCL 1.13 crashes on headers without a DATA line, and allocates what a header claims: both are checked before.
void check_header(const std::filesystem::path& path, bool ply) {
  require_input(path, kLargestCloud);
  std::ifstream file(path, std::ios::binary);
  if (!file) throw DataError(fmt::format("{}: cannot open", path.string()));
  std::string header(64 * 1024, '\0');
  file.read(header.data(), static_cast<std::streamsize>(header.size()));
  header.resize(static_cast<std::size_t>(file.gcount()));
  const std::vector<std::string> keywords =
      ply ? std::vector<std::string>{"ply", "format ", "element vertex ", "end_header\n"}
          : std::vector<std::string>{"FIELDS ", "SIZE ", "TYPE ", "WIDTH ", "HEIGHT ", "DATA "};
  std::size_t end = 0;
  for (const std::string& keyword : keywords) {
    end = header.find(keyword);
    if (end == std::string::npos) {
      throw DataError(fmt::format("{}: not a {} file: its header lacks '{}'", path.string(), ply ? "PLY" : "PCD",
                                  keyword.substr(0, keyword.find_last_not_of(" \n") + 1)));
    }
  }
  header.resize(end);
  const std::uint64_t points = ply ? number_after(header, "element vertex ") : number_after(header, "WIDTH ");
  const std::uint64_t rows = ply ? 1 : number_after(header, "HEIGHT ");
  // A point takes one byte at least; PCL's own compression gains less than 200.
  const std::uint64_t most = 200 * static_cast<std::uint64_t>(std::filesystem::file_size(path));
  if (rows > most || points > most || (rows > 0 && points > most / rows)) {
    throw DataError(fmt::format("{}: its header claims {} x {} points, which the file is too short for", path.string(),
                                points, rows));
  }
}
#endif

}  // namespace

std::vector<CloudPoint> read_cloud(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  if (extension != ".pcd" && extension != ".ply") {
    throw ConfigError(fmt::format("{}: '{}' is no point file; use .pcd or .ply", path.string(), extension));
  }
  std::vector<CloudPoint> points;
#ifdef ASLIO_HAVE_PCL
  check_header(path, extension == ".ply");
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
