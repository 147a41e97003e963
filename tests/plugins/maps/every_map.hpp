#pragma once
/// The library's maps of points with thinning off, where it can be, and a radius that a random walk leaves behind.

#include <map>
#include <string>

#include "maps/ikd_tree.hpp"
#include "plugins/maps/map_fixture.hpp"
#include "plugins/maps/map_probe.hpp"

namespace aslio::test {

/// How each map of points is made for it. A new type without an entry fails the test.
struct Unthinned {
  std::string configuration;
  bool tells_kinds = false;
  bool fuses = false;  ///< means in place of points: compared with what visit() tells
};

inline Unthinned unthinned(const std::string& type) {
  static const std::map<std::string, Unthinned> known{
      {"{type: voxel_hash}", {"{type: voxel_hash, min_spacing: 0, max_points: 4096, radius: 20}", false}},
      {"{type: ikd_tree}", {"{type: ikd_tree, leaf: 0, radius: 20}", true}},
      {"{type: ivox}", {"{type: ivox, radius: 20}", false}},
      {"{type: oct_voxel}", {"{type: oct_voxel, radius: 20}", false, true}},
      {"{type: feature_maps}",
       {"{type: feature_maps, lines: {type: ikd_tree, leaf: 0, radius: 20}, planes: {type: voxel_hash, min_spacing: 0, "
        "max_points: 4096, radius: 20}}",
        true}}};
  const auto found = known.find(type);
  if (found == known.end()) FAIL("no configuration without thinning is known of the map " << type);
  return found->second;
}

/// A random life of each of them; boxes are deleted from those that can.
inline void check_every_point_map(const Life& life) {
  EveryMap registered;
  const auto types = registered.types(MapContent::points);
  REQUIRE(types.size() >= 5);
  for (const std::string& type : types) {
    const Unthinned made = unthinned(type);
    INFO(made.configuration);
    const auto map = registered.make(made.configuration);
    if (made.fuses) {
      REQUIRE(!holds_all_as_given(*registered.make(made.configuration), life));
      check_life_by_visit(*map, life);
      continue;
    }
    EraseBox erase_box;
    if (auto* tree = dynamic_cast<plugins::IkdTree*>(map.get())) {
      erase_box = [tree](Map&, const Vec3& low, const Vec3& high) { return tree->erase_box(low, high); };
    }
    CHECK(tells_kinds(*registered.make(made.configuration)) == made.tells_kinds);
    check_random_life(*map, life, {.tells_kinds = made.tells_kinds}, erase_box);
  }
}

}  // namespace aslio::test
