#include "aslio/plugin/registry.hpp"
#include "maps/bundle_planes.hpp"
#include "maps/feature_maps.hpp"
#include "maps/ikd_tree.hpp"
#include "maps/ivox.hpp"
#include "maps/oct_voxel.hpp"
#include "maps/recursive_planes.hpp"
#include "maps/staggered_planes.hpp"
#include "maps/surfel.hpp"
#include "maps/voxel_hash.hpp"
#include "maps/voxel_plane.hpp"

namespace aslio::plugins {

void register_maps(plugin::Registry<Map>& registry);

void register_maps(plugin::Registry<Map>& registry) {
  registry.add<StaggeredPlanes>("staggered_planes",
                                "Planes of all points in several pyramids of voxels, staggered against each other.");
  registry.add<VoxelPlane>("voxel_plane", "Planes of all points in a pyramid of voxels (VoxelMap).");
  registry.add<BundlePlanes>("bundle_planes",
                             "Planes of all points, revised by bundle adjustment over the last seconds (BALM2).");
  registry.add<RecursivePlanes>("recursive_planes",
                                "Planes found among the points of a voxel, the rest handed on (R-VoxelMap).");
  registry.add<VoxelHash>("voxel_hash", "Exact neighbours from a flat hash of voxels with points as arrays.");
  registry.add<IkdTree>("ikd_tree", "Exact neighbours from an incremental k-d tree, thinned to one point per cell.");
  registry.add<FeatureMaps>("feature_maps", "Two maps of points, one of lines and one of planes (LOAM).");
  registry.add<Ivox>("ivox",
                     "Neighbours from a hash of voxels and those around, the least recent forgotten (Faster-LIO).");
  registry.add<OctVoxel>("oct_voxel",
                         "Neighbours from a hash of voxels, each with the means of its eight octants (Super-LIO).");
  registry.add<Surfel>("surfel", "Surfels of voxels and of the cells in them, fitted as points come in (Surfel-LIO).");
}

}  // namespace aslio::plugins
