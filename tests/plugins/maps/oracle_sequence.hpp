#pragma once
/// A random life of a map: batches inserted on a random walk, trimmed, now and then cleared, checked as it goes.

#include <cmath>
#include <functional>

#include "plugins/maps/grid_oracle.hpp"

namespace aslio::test {

/// Deletes a box from the map, if it can, and returns the number of points deleted.
using EraseBox = std::function<std::size_t(Map&, const Vec3& low, const Vec3& high)>;

/// Pre: the map thins nothing. `total` points are inserted around a walk that begins at `centre` (on the grid).
inline void check_random_life(Map& map, std::size_t total, Vec3 centre, std::uint64_t seed,
                              const EraseBox& erase_box = {}, bool tells_kinds = false) {
  Draw draw(seed);
  GridOracle oracle;
  std::uint32_t stamp = 0;
  std::size_t checked = 0;
  for (std::size_t inserted = 0; inserted < total;) {
    auto batch = draw_batch(draw, centre, 2000);
    // By place: which of two points of one place has been trimmed could not be told.
    for (WorldPoint& point : batch) {
      point.feature = static_cast<std::uint8_t>(std::llround(1024 * point.p_W.sum()) & 1 ? feature_class::line
                                                                                         : feature_class::none);
    }
    const InsertCount count = map.insert(batch, ++stamp);
    REQUIRE(count.offered == batch.size());
    REQUIRE(count.inserted == batch.size());
    oracle.insert(batch, stamp);
    inserted += batch.size();
    centre += draw.near(Vec3(1, 0, 0), 2);
    if (draw(0, 3) == 0) {
      map.trim(centre);
      // All within the radius stays. A voxel across the radius may stay, and the last metre of motion may not count.
      std::vector<Vec3> left;
      map.visit([&](const Vec3& p) { left.push_back(p); });
      const auto before = [](const Vec3& a, const Vec3& b) {
        return std::tuple(a.x(), a.y(), a.z()) < std::tuple(b.x(), b.y(), b.z());
      };
      std::sort(left.begin(), left.end(), before);
      for (const Vec3& p : left) REQUIRE((p - centre).norm() <= map.radius() + 3.0);
      oracle.erase([&](const Vec3& p) {
        return (p - centre).norm() > map.radius() && !std::binary_search(left.begin(), left.end(), p, before);
      });
    }
    if (erase_box && draw(0, 5) == 0) {
      const Vec3 low = draw.near(centre, 8), high = low + draw.near(Vec3::Constant(2.0), 2);
      const auto inside = [&](const Vec3& p) { return (p.array() >= low.array() && p.array() <= high.array()).all(); };
      REQUIRE(erase_box(map, low, high) == oracle.erase(inside));
    }
    if (draw(0, 400) == 0) {
      map.clear();
      oracle.clear();
    }
    REQUIRE(map.size() == oracle.size());
    if (draw(0, 9) != 0) continue;
    ++checked;
    oracle.check_contents(map);
    std::vector<Vec3> queries;
    for (int i = 0; i < 20; ++i) queries.push_back(draw.near(centre, 7));
    for (std::size_t i = 0; i < std::min<std::size_t>(10, batch.size()); ++i) queries.push_back(batch[i].p_W);
    MapQuery ask;
    ask.k = draw(1, Neighbours::kMax);
    ask.max_distance = draw(1, 4) * 0.25;
    if (draw(0, 1) == 0) ask.max_stamp = stamp - static_cast<std::uint32_t>(draw(0, 20));
    ask.feature = draw.feature();
    oracle.check_neighbours(map, queries, ask, tells_kinds);
  }
  REQUIRE(checked * 20000 > total);
}

}  // namespace aslio::test
