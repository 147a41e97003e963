#pragma once
/// A random life of a map: batches inserted on a random walk, trimmed, now and then cleared, checked as it goes.

#include <cmath>
#include <functional>
#include <utility>

#include "plugins/maps/grid_oracle.hpp"

namespace aslio::test {

/// Deletes a box from the map, if it can, and returns the number of points deleted.
using EraseBox = std::function<std::size_t(Map&, const Vec3& low, const Vec3& high)>;

struct Life {
  std::size_t total = 0;    ///< points inserted
  Vec3 centre = {0, 0, 0};  ///< where the walk begins, on the grid
  std::uint64_t seed = 0;
  double beyond = 3.0;    ///< [m] farther than the radius a point may stay: a voxel across it, and the last metre of
                          ///< motion, which may not count
  int most_quarters = 4;  ///< of a metre, for which neighbours are asked
};

/// What happens in one step, in this order, whatever the map does.
struct LifeStep {
  std::uint32_t stamp = 0;
  std::vector<WorldPoint> batch;
  Vec3 centre;  ///< of the walk, from here on
  bool trim = false, erase = false, clear = false, check = false;
  Vec3 low, high;  ///< of the box to be deleted, by maps that can
};

class LifeSteps {
 public:
  /// Radius [m] beyond which a life may be over before the walk has left it.
  static constexpr double kMaxLeapt = 2000.0;

  LifeSteps(const Life& life, double radius)
      : draw_(life.seed),
        home_(life.centre),
        centre_(life.centre),
        turn_(2.0 * std::min(radius, kMaxLeapt) + 12.0),
        leap_(radius > 25.0 ? std::floor(std::min(radius, kMaxLeapt) / 2.0) : 0.0),
        clear_one_in_(static_cast<int>(life.total / 2000)) {}

  LifeStep next() {
    LifeStep step;
    step.stamp = ++stamp_;
    step.batch = draw_(0, 4) == 0 ? draw_mirrored_batch(draw_, centre_) : draw_batch(draw_, centre_, 2000);
    // By place: which of two points of one place has been trimmed could not be told.
    for (WorldPoint& point : step.batch) {
      point.feature = static_cast<std::uint8_t>(std::llround(1024 * point.p_W.sum()) & 1 ? feature_class::line
                                                                                         : feature_class::none);
    }
    walk();
    step.centre = centre_;
    step.trim = draw_(0, 3) == 0;
    step.erase = draw_(0, 5) == 0;
    step.low = draw_.near(centre_, 8);
    step.high = step.low + draw_.near(Vec3::Constant(2.0), 2);
    step.clear = draw_(0, clear_one_in_) == 0;
    step.check = draw_(0, 9) == 0;
    return step;
  }

 private:
  /// Away until all about home is forgotten, then back to it, and again: what has been trimmed is filled anew.
  void walk() {
    const Vec3 away = centre_ - home_;
    if (away.x() > turn_) forward_ = -1.0;
    if (away.x() < 0.0) forward_ = 1.0;
    const auto to_home = [](double offset) { return offset > 0.0 ? -1.0 : 1.0; };
    centre_ += draw_.near(Vec3(forward_, to_home(away.y()), to_home(away.z())), 2);
    // Steps alone would not leave a large radius before the life is over.
    if (draw_(0, 15) == 0) centre_.x() += forward_ * leap_;
  }

  Draw draw_;
  Vec3 home_, centre_;
  double forward_ = 1.0, turn_, leap_;  ///< sign along x; [m]
  int clear_one_in_;                    ///< steps: a few times in a life
  std::uint32_t stamp_ = 0;
};

/// Where neighbours are looked for: around the walk, and at points just inserted, the first of them among these.
inline std::vector<Vec3> life_queries(Draw& draw, const LifeStep& step) {
  std::vector<Vec3> queries;
  for (int i = 0; i < 20; ++i) queries.push_back(draw.near(step.centre, 7));
  constexpr std::size_t kOfBatch = 10;
  for (std::size_t i = 0; i < kOfBatch; ++i) queries.push_back(step.batch[i * step.batch.size() / kOfBatch].p_W);
  return queries;
}

/// Trims, and forgets in the oracle what a map may forget and has forgotten: all within the radius stays.
inline void trim_both(Map& map, GridOracle& oracle, const Vec3& centre, double beyond) {
  map.trim(centre);
  const std::vector<Vec3> left = sorted_contents(map);
  for (const Vec3& p : left) REQUIRE((p - centre).norm() <= map.radius() + beyond);
  oracle.erase([&](const Vec3& p) {
    return (p - centre).norm() > map.radius() && !std::binary_search(left.begin(), left.end(), p, before_by_place);
  });
}

/// Pre: `map` is new, thins nothing and holds points in just their places. Returns the queries of which it did not look
/// at all points within reach.
inline std::size_t check_random_life(Map& map, const Life& life, const Sight& sight = {},
                                     const EraseBox& erase_box = {}) {
  LifeSteps steps(life, map.radius());
  Draw draw(life.seed + 1);
  GridOracle oracle;
  std::size_t inserted = 0, trimmed = 0, cleared = 0, checked = 0, cut_off = 0;
  while (inserted < life.total) {
    const LifeStep step = steps.next();
    const InsertCount count = map.insert(step.batch, step.stamp);
    REQUIRE(count.offered == step.batch.size());
    REQUIRE(count.inserted == step.batch.size());
    oracle.insert(step.batch, step.stamp);
    inserted += step.batch.size();
    if (step.trim) {
      const std::size_t before = oracle.size();
      trim_both(map, oracle, step.centre, life.beyond);
      trimmed += before - oracle.size();
    }
    if (erase_box && step.erase) {
      const auto inside = [&](const Vec3& p) {
        return (p.array() >= step.low.array() && p.array() <= step.high.array()).all();
      };
      REQUIRE(erase_box(map, step.low, step.high) == oracle.erase(inside));
    }
    if (step.clear) {
      map.clear();
      oracle.clear();
      ++cleared;
    }
    REQUIRE(map.size() == oracle.size());
    if (!step.check) continue;
    ++checked;
    oracle.check_contents(map);
    const std::vector<Vec3> queries = life_queries(draw, step);
    MapQuery ask;
    ask.k = draw(1, Neighbours::kMax);
    ask.max_distance = draw(1, life.most_quarters) * 0.25;
    if (draw(0, 1) == 0) ask.max_stamp = step.stamp - static_cast<std::uint32_t>(draw(0, 20));
    ask.feature = draw.feature();
    cut_off += oracle.check_neighbours(map, queries, ask, sight);
  }
  REQUIRE(checked * 20000 > life.total);
  REQUIRE((trimmed * 20 > life.total || map.radius() > LifeSteps::kMaxLeapt));
  REQUIRE(cleared > 0);
  return cut_off;
}

}  // namespace aslio::test
