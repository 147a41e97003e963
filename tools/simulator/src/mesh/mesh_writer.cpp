#include <fmt/format.h>

#include <array>
#include <bit>
#include <cstring>

#include "aslio/io/writers.hpp"
#include "aslio/simulator/mesh_file.hpp"

namespace aslio::simulator {

static_assert(std::endian::native == std::endian::little, "mesh files are written in host order");

void write_mesh(const Mesh& mesh, const std::filesystem::path& path) {
  io::AtomicFile file(path, true);
  file.write(
      fmt::format("ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\n"
                  "property float z\nelement face {}\nproperty list uchar uint vertex_indices\nend_header\n",
                  mesh.vertices.size(), mesh.triangles.size()));
  std::array<char, 13> record{};
  for (const Eigen::Vector3f& vertex : mesh.vertices) {
    std::memcpy(record.data(), vertex.data(), 12);
    file.write({record.data(), 12});
  }
  record[0] = 3;
  for (const Mesh::Triangle& triangle : mesh.triangles) {
    const std::array<std::uint32_t, 3> corners{triangle.a, triangle.b, triangle.c};
    std::memcpy(record.data() + 1, corners.data(), 12);
    file.write({record.data(), record.size()});
  }
  file.close();
}

}  // namespace aslio::simulator
