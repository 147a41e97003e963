#include "aslio/simulator/mesh_file.hpp"

#include <assimp/mesh.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <assimp/Importer.hpp>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <exception>
#include <span>
#include <string>
#include <string_view>
#include <system_error>

#include "aslio/config/binder.hpp"
#include "aslio/core/errors.hpp"
#include "mesh/ply_header.hpp"

namespace aslio::simulator {
namespace {

constexpr std::uint64_t kMaxFileBytes = 2'000'000'000, kMaxTriangles = 50'000'000;
/// Single precision is good to 8 mm at this distance [m].
constexpr double kMaxCoordinate = 100e3;

[[noreturn]] void refuse(const std::filesystem::path& path, std::string_view why) {
  throw DataError(fmt::format("{}: {}", path.string(), why));
}

std::string lower_extension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

std::uint64_t checked_size(const std::filesystem::path& path) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (status.type() == std::filesystem::file_type::not_found) refuse(path, "mesh file does not exist");
  if (std::filesystem::is_directory(status)) refuse(path, "is a directory, not a mesh file: name the .ply or .obj");
  if (!std::filesystem::is_regular_file(status)) refuse(path, "mesh file cannot be read: not a regular file");
  const std::uint64_t bytes = std::filesystem::file_size(path, error);
  if (error) refuse(path, "mesh file cannot be read: " + error.message());
  if (bytes == 0) refuse(path, "mesh file is empty");
  if (bytes > kMaxFileBytes)
    refuse(path, fmt::format("mesh file of {:.1f} GB; the limit is 2 GB: decimate it or cut out the part that is used",
                             static_cast<double>(bytes) / 1e9));
  return bytes;
}

[[noreturn]] void refuse_without_faces(const std::filesystem::path& path, std::uint64_t points) {
  refuse(path, fmt::format("has {} points but no faces (a point cloud): rays pass between points. Reconstruct a "
                           "surface first (Poisson reconstruction in MeshLab or CloudCompare) and save it with faces",
                           points));
}

void check_triangles(const std::filesystem::path& path, std::uint64_t triangles) {
  if (triangles > kMaxTriangles)
    refuse(path, fmt::format("has {} faces; the limit is {}: decimate it", triangles, kMaxTriangles));
}

struct Totals {
  std::uint64_t vertices = 0, faces = 0, triangles = 0;
};

/// What assimp would take for granted: indices within their mesh; and what float coordinates cannot carry.
Totals checked(const std::filesystem::path& path, std::span<aiMesh* const> meshes, double unit) {
  Totals totals;
  for (const aiMesh* mesh : meshes) {
    for (const aiVector3D& v : std::span(mesh->mVertices, mesh->mNumVertices)) {
      const double x = v.x * unit, y = v.y * unit, z = v.z * unit;
      if (!std::isfinite(x) || !std::isfinite(y) || !std::isfinite(z))
        refuse(path, fmt::format("vertex ({}, {}, {}) is not finite: repair the mesh", v.x, v.y, v.z));
      if (std::max({std::abs(x), std::abs(y), std::abs(z)}) > kMaxCoordinate)
        refuse(path, fmt::format("vertex ({}, {}, {}) times unit {} is more than 100 km from the origin: move the mesh "
                                 "to the origin, or correct unit",
                                 v.x, v.y, v.z, unit));
    }
    totals.vertices += mesh->mNumVertices;
    totals.faces += mesh->mNumFaces;
    for (const aiFace& face : std::span(mesh->mFaces, mesh->mNumFaces)) {
      for (const unsigned index : std::span(face.mIndices, face.mNumIndices))
        if (index >= mesh->mNumVertices)
          refuse(path, fmt::format("damaged: a face names vertex {} of {}", index, mesh->mNumVertices));
      if (face.mNumIndices >= 3) totals.triangles += face.mNumIndices - 2;
    }
  }
  return totals;
}

/// Relative luminance (ITU-R BT.709) of a vertex colour, in [0, 1].
double brightness(const aiColor4D& colour) {
  const double y = 0.2126 * static_cast<double>(colour.r) + 0.7152 * static_cast<double>(colour.g) +
                   0.0722 * static_cast<double>(colour.b);
  return y > 0 ? std::min(y, 1.0) : 0;
}

std::uint8_t byte_of(double share) { return static_cast<std::uint8_t>(std::lround(255 * share)); }

void append(Mesh& out, const aiMesh& mesh, const MeshFileParams& params) {
  const auto first = static_cast<std::uint32_t>(out.vertices.size());
  for (const aiVector3D& v : std::span(mesh.mVertices, mesh.mNumVertices))
    out.vertices.push_back((Vec3(v.x, v.y, v.z) * params.unit).cast<float>());
  for (const aiFace& face : std::span(mesh.mFaces, mesh.mNumFaces)) {
    if (face.mNumIndices != 3) continue;  // a point or a line
    const std::span<const unsigned, 3> i(face.mIndices, 3);
    double reflectivity = params.reflectivity;
    if (mesh.HasVertexColors(0)) {
      const std::span colours(mesh.mColors[0], mesh.mNumVertices);
      reflectivity = (brightness(colours[i[0]]) + brightness(colours[i[1]]) + brightness(colours[i[2]])) / 3;
    }
    out.triangles.push_back({first + i[0], first + i[1], first + i[2]});
    out.reflectivity.push_back(byte_of(reflectivity));
  }
}

/// Reads the file, then cuts polygons once its indices are known to be good.
const aiScene& import(Assimp::Importer& importer, const std::filesystem::path& path, const PlyCounts* promised,
                      double unit) {
  const aiScene* scene = importer.ReadFile(path.string(), 0);
  if (scene == nullptr) refuse(path, fmt::format("damaged, or not a mesh: {}", importer.GetErrorString()));
  const Totals totals = checked(path, std::span(scene->mMeshes, scene->mNumMeshes), unit);
  if (totals.triangles == 0) refuse_without_faces(path, totals.vertices);
  check_triangles(path, totals.triangles);
  if (promised != nullptr && (totals.vertices < promised->vertices || totals.faces < promised->faces))
    refuse(path, fmt::format("damaged, or cut off: {} vertices and {} faces are announced, {} and {} are there",
                             promised->vertices, promised->faces, totals.vertices, totals.faces));
  scene = importer.ApplyPostProcessing(aiProcess_Triangulate);
  if (scene == nullptr)
    refuse(path, fmt::format("its faces cannot be cut into triangles: {}", importer.GetErrorString()));
  return *scene;
}

Mesh read_mesh(const std::filesystem::path& path, const MeshFileParams& params) {
  const std::uint64_t bytes = checked_size(path);
  const std::string extension = lower_extension(path);
  if (extension != ".ply" && extension != ".obj")
    refuse(path, "not a mesh file that can be read: convert it to .ply or .obj, with that extension");
  PlyCounts counts;
  if (extension == ".ply") {
    counts = read_ply_header(path, bytes);
    check_triangles(path, counts.faces);
    if (counts.faces == 0) refuse_without_faces(path, counts.vertices);
  }
  Assimp::Importer importer;
  const aiScene& scene = import(importer, path, extension == ".ply" ? &counts : nullptr, params.unit);
  Mesh mesh;
  // Neither format has transforms: the meshes stand where their vertices say.
  for (const aiMesh* part : std::span(scene.mMeshes, scene.mNumMeshes)) append(mesh, *part, params);
  return mesh;
}

}  // namespace

void MeshFileParams::describe(config::Binder& b, MeshFileParams& params) {
  b.text("file", params.file, ".ply or .obj with faces, z up; relative to the scene file");
  b.real("unit", params.unit, "m", {.above = 0.0, .max = 1e4}, "one unit of the file");
  b.real("reflectivity", params.reflectivity, "1", {.above = 0.0, .max = 1.0},
         "of surfaces without vertex colours; the brightness of vertex colours replaces it");
  b.require(!params.file.empty(), "file", "must name a .ply or .obj file");
}

World load_mesh_world(const std::filesystem::path& path, const MeshFileParams& params) {
  try {
    return {read_mesh(path, params), Ground{}};
  } catch (const DataError&) {
    throw;
  } catch (const std::exception& error) {  // out of memory, and what assimp lets through
    refuse(path, fmt::format("mesh cannot be read: {}", error.what()));
  }
}

}  // namespace aslio::simulator
