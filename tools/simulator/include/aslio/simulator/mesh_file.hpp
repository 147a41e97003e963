#pragma once
/// Worlds of the user's own, and worlds as files.

#include <filesystem>

#include "aslio/simulator/world.hpp"

namespace aslio::config {
class Binder;
}

namespace aslio::simulator {

/// `world:` of a scene file with a mesh.
struct MeshFileParams {
  std::string file;  ///< .ply or .obj; relative to the scene file
  double unit = 1;   ///< one unit of the file in metres
  double reflectivity =
      0.4;  ///< of surfaces whose colour is not known, in (0, 1]; vertex colours give their brightness
  static void describe(config::Binder& b, MeshFileParams& params);
};

/// Reads the triangles of a file by assimp (polygons are cut into triangles). Throws DataError that names the file and
/// the reason: missing, unreadable, another format, no faces (a point cloud), coordinates that are not finite or beyond
/// 100 km.
World load_mesh_world(const std::filesystem::path& path, const MeshFileParams& params);

/// Binary PLY of the triangles [m]; what load_mesh_world() reads. Throws DataError when it cannot be written.
void write_mesh(const Mesh& mesh, const std::filesystem::path& path);

}  // namespace aslio::simulator
