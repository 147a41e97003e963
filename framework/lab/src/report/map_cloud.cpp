// A map that fits into a page.
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <unordered_set>

#include "aslio/report/encode.hpp"
#include "placement.hpp"

namespace aslio::report {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr double kUnit = 0.01;        // [m]
constexpr double kFirstVoxel = 0.03;  // [m] a room shows its furniture
constexpr double kFar = 1e5;          // [m] beyond this no point is meant

/// One point per voxel; the voxels grow when there are too many.
class Thinned {
 public:
  explicit Thinned(std::size_t limit) : limit_(limit) {}

  void add(const Vec3& p) {
    // By component: the largest of some that are no numbers may be a number.
    if (!((p.array().abs() < kFar).all()) || !taken_.insert(key(p)).second) return;
    points_.push_back(p);
    if (points_.size() <= limit_) return;
    voxel_ *= 1.4;
    taken_.clear();
    std::vector<Vec3> kept;
    for (const Vec3& q : points_) {
      if (taken_.insert(key(q)).second) kept.push_back(q);
    }
    points_ = std::move(kept);
  }
  const std::vector<Vec3>& points() const { return points_; }
  double voxel() const { return voxel_; }

 private:
  std::uint64_t key(const Vec3& p) const {
    std::uint64_t key = 0;
    for (int k = 0; k < 3; ++k) {
      key = key << 21 | (static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(p[k] / voxel_))) & 0x1FFFFF);
    }
    return key;
  }
  std::size_t limit_;
  double voxel_ = kFirstVoxel;
  std::unordered_set<std::uint64_t> taken_;
  std::vector<Vec3> points_;
};

/// Reads past the header of a map as `aslio run` writes it: x, y, z, intensity as floats. False for any other file.
bool skip_header(std::istream& stream, const fs::path& file) {
  const bool ply = file.extension() == ".ply";
  bool binary = false, fields = false;
  int properties = 0;
  std::string line;
  for (int lines = 0; lines < 20 && std::getline(stream, line); ++lines) {
    if (line == "format binary_little_endian 1.0") binary = true;
    if (line.starts_with("property float ")) ++properties;
    if (line == "FIELDS x y z intensity") fields = true;
    if (ply && line == "end_header") return binary && properties == 4;
    if (!ply && line.starts_with("DATA ")) return fields && line == "DATA binary";
  }
  return false;
}

void read_points(const fs::path& file, const Pose& T, Thinned& thinned) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream || !skip_header(stream, file)) return;
  std::vector<char> block(16 * 65536);
  while (stream.read(block.data(), static_cast<std::streamsize>(block.size())), stream.gcount() > 0) {
    const auto whole = static_cast<std::size_t>(stream.gcount()) / 16;
    for (std::size_t i = 0; i < whole; ++i) {
      std::array<float, 3> p{};
      std::memcpy(p.data(), block.data() + 16 * i, sizeof(p));
      thinned.add(T * Vec3(p[0], p[1], p[2]));
    }
  }
}

}  // namespace

Json map_json(const FolderRun& run, const DataTruth& truth, std::size_t max_points) {
  std::error_code ignored;
  for (const char* name : {"map.ply", "map.pcd"}) {
    const fs::path file = run.folder / name;
    if (!fs::is_regular_file(file, ignored)) continue;
    const auto placed = place(run, truth);
    Thinned thinned(max_points);
    read_points(file, placed ? placed->T_truth_run : Pose{}, thinned);
    if (thinned.points().empty()) continue;
    std::array<std::vector<double>, 3> coordinates;
    for (const Vec3& p : thinned.points()) {
      for (std::size_t k = 0; k < 3; ++k) coordinates[k].push_back(p[static_cast<Eigen::Index>(k)]);
    }
    return {{"method", run.method},
            {"voxel", thinned.voxel()},
            {"x", packed_numbers(coordinates[0], kUnit)},
            {"y", packed_numbers(coordinates[1], kUnit)},
            {"z", packed_numbers(coordinates[2], kUnit)}};
  }
  return nullptr;
}

}  // namespace aslio::report
