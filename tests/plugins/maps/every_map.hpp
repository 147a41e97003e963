#pragma once
/// The maps of points with thinning off and a radius that a random walk leaves behind.

#include <functional>
#include <map>
#include <string>

#include "aslio/stages/build_context.hpp"
#include "maps/ikd_tree.hpp"
#include "plugins/build_environment.hpp"
#include "plugins/maps/map_fixture.hpp"
#include "plugins/maps/oracle_sequence.hpp"
#include "plugins/overlaps/one_stage.hpp"
#include "register_all.hpp"

namespace aslio::test {

/// How each map of points is made for it. A new type without an entry fails the test.
inline std::string unthinned(const std::string& type) {
  static const std::map<std::string, std::string> configurations{
      {"{type: voxel_hash}", "{type: voxel_hash, min_spacing: 0, max_points: 4096, radius: 20}"},
      {"{type: ikd_tree}", "{type: ikd_tree, leaf: 0, radius: 20}"},
      {"{type: ivox}", "{type: ivox, radius: 20}"},
      {"{type: feature_maps}",
       "{type: feature_maps, lines: {type: ikd_tree, leaf: 0, radius: 20}, planes: {type: voxel_hash, min_spacing: 0, "
       "max_points: 4096, radius: 20}}"}};
  const auto found = configurations.find(type);
  if (found == configurations.end()) FAIL("no configuration without thinning is known of the map " << type);
  return found->second;
}

/// `check` gets a map, how a box is deleted from it (if it can), and whether it tells lines from all else.
inline void for_every_point_map(const std::function<void(Map&, const EraseBox&, bool)>& check) {
  plugin::Catalog catalog;
  plugins::register_all(catalog);
  EveryMap registered;
  const auto types = registered.types(MapContent::points);
  REQUIRE(types.size() >= 4);
  for (const std::string& type : types) {
    const std::string text = unthinned(type);
    INFO(text);
    BuildEnvironment environment;
    const auto map = make_stage<Map>(catalog, text, environment.context());
    EraseBox erase_box;
    if (auto* tree = dynamic_cast<plugins::IkdTree*>(map.get())) {
      erase_box = [tree](Map&, const Vec3& low, const Vec3& high) { return tree->erase_box(low, high); };
    }
    check(*map, erase_box, type == "{type: ikd_tree}" || type == "{type: feature_maps}");
  }
}

}  // namespace aslio::test
