// Compiled without this project's code generation flags and alignment. Uses the untyped cloud: no Eigen memory is
// allocated here, so that no inline allocation function of another alignment reaches the linker.
#include "pcl_cloud.hpp"

#include <pcl/PCLPointCloud2.h>
#include <pcl/io/pcd_io.h>
#include <pcl/io/ply_io.h>

#include <cstdint>
#include <cstring>
#include <exception>

namespace aslio::io {
namespace {

/// Offset of a float32 field, or -1.
long offset_of(const pcl::PCLPointCloud2& cloud, const char* name) {
  for (const auto& field : cloud.fields) {
    const bool fits = field.datatype == pcl::PCLPointField::FLOAT32 && field.offset + 4 <= cloud.point_step;
    if (field.name == name && fits) return static_cast<long>(field.offset);
  }
  return -1;
}

float load(const std::uint8_t* from) {
  float value = 0;
  std::memcpy(&value, from, sizeof(value));
  return value;
}

}  // namespace

std::string read_cloud_with_pcl(const char* path, bool ply, PointSink sink, void* context) {
  pcl::PCLPointCloud2 cloud;
  try {
    Eigen::Vector4f origin;
    Eigen::Quaternionf orientation;
    int version = 0;
    const int result = ply ? pcl::PLYReader().read(path, cloud, origin, orientation, version)
                           : pcl::PCDReader().read(path, cloud, origin, orientation, version);
    if (result < 0) return "PCL cannot read it";
  } catch (const std::exception& error) {
    return error.what();
  }
  const long x = offset_of(cloud, "x"), y = offset_of(cloud, "y"), z = offset_of(cloud, "z");
  const long intensity = offset_of(cloud, "intensity");
  if (x < 0 || y < 0 || z < 0) return "it has no float32 fields x, y, z";
  const std::uint64_t count = std::uint64_t{cloud.width} * cloud.height;
  if (count * cloud.point_step > cloud.data.size()) return "it holds fewer points than it declares";
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::uint8_t* point = cloud.data.data() + i * cloud.point_step;
    sink(context, load(point + x), load(point + y), load(point + z), intensity < 0 ? 0.0F : load(point + intensity));
  }
  return {};
}

}  // namespace aslio::io
