#pragma once
/// The maps of points with thinning off and a radius that a random walk leaves behind.

#include <functional>
#include <string>

#include "aslio/stages/build_context.hpp"
#include "maps/ikd_tree.hpp"
#include "plugins/build_environment.hpp"
#include "plugins/maps/oracle_sequence.hpp"
#include "plugins/overlaps/one_stage.hpp"
#include "register_all.hpp"

namespace aslio::test {

inline void for_every_point_map(const std::function<void(Map&, const EraseBox&)>& check) {
  plugin::Catalog catalog;
  plugins::register_all(catalog);
  for (const std::string text :
       {"{type: voxel_hash, min_spacing: 0, max_points: 4096, radius: 20}", "{type: ikd_tree, leaf: 0, radius: 20}",
        "{type: ivox, radius: 20}",
        "{type: feature_maps, lines: {type: ikd_tree, leaf: 0, radius: 20}, planes: {type: voxel_hash, min_spacing: 0, "
        "max_points: 4096, radius: 20}}"}) {
    INFO(text);
    BuildEnvironment environment;
    const auto map = make_stage<Map>(catalog, text, environment.context());
    EraseBox erase_box;
    if (auto* tree = dynamic_cast<plugins::IkdTree*>(map.get())) {
      erase_box = [tree](Map&, const Vec3& low, const Vec3& high) { return tree->erase_box(low, high); };
    }
    check(*map, erase_box);
  }
}

}  // namespace aslio::test
