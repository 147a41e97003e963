#pragma once
/// Every map against brute force, bit by bit. All coordinates are multiples of 2^-10 m and distances stay below 4 m, so
/// that offsets and squared distances are exact in float and ties are ties.

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <functional>
#include <limits>
#include <random>
#include <tuple>
#include <vector>

#include "aslio/stages/map.hpp"

namespace aslio::test {

/// Random numbers that are the same everywhere.
class Draw {
 public:
  explicit Draw(std::uint64_t seed) : engine_(seed) {}
  /// In [low, high].
  int operator()(int low, int high) {
    return low + static_cast<int>(engine_() % static_cast<std::uint64_t>(high - low + 1));
  }
  std::uint8_t feature() { return static_cast<std::uint8_t>((*this)(feature_class::none, feature_class::plane)); }
  /// A point of the grid within `half` m of `centre` along each axis.
  Vec3 near(const Vec3& centre, int half) {
    const int x = grid(half), y = grid(half), z = grid(half);
    return centre + Vec3(x, y, z) / 1024.0;
  }

 private:
  int grid(int half) { return (*this)(-1024 * half, 1024 * half); }
  std::mt19937_64 engine_;
};

/// Which of the points within reach a map looks at.
struct Sight {
  bool tells_kinds = false;                                             ///< lines alone, or all else
  std::function<bool(const Vec3& query, const Vec3& point)> sees = {};  ///< unset: all of them
};

/// Before another by coordinates: an order in which equal points stand together.
inline bool before_by_place(const Vec3& a, const Vec3& b) {
  return std::tuple(a.x(), a.y(), a.z()) < std::tuple(b.x(), b.y(), b.z());
}

/// What the map holds, in that order.
inline std::vector<Vec3> sorted_contents(const Map& map) {
  std::vector<Vec3> points;
  map.visit([&](const Vec3& p) { points.push_back(p); });
  std::sort(points.begin(), points.end(), before_by_place);
  return points;
}

/// The points a map should hold, in order of insertion.
class GridOracle {
 public:
  void insert(const std::vector<WorldPoint>& points, std::uint32_t stamp) {
    for (const auto& point : points) held_.push_back({point.p_W, stamp, feature_class::kind(point.feature)});
  }
  /// Forgets the points for which `gone` holds and returns their number.
  template <class Gone>
  std::size_t erase(Gone&& gone) {
    return std::erase_if(held_, [&](const Held& held) { return gone(held.p); });
  }
  void clear() { held_.clear(); }
  std::size_t size() const { return held_.size(); }

  /// Same points in the map, all of them visited.
  void check_contents(const Map& map) const {
    std::vector<Vec3> expected;
    for (const Held& held : held_) expected.push_back(held.p);
    std::sort(expected.begin(), expected.end(), before_by_place);
    REQUIRE(map.size() == held_.size());
    REQUIRE(sorted_contents(map) == expected);
  }

  /// Same neighbours in the same order with the same bits. Returns of how many queries a point that the map does
  /// not look at would have been among them. Pre: ask.max_distance <= 4 m.
  std::size_t check_neighbours(const Map& map, const std::vector<Vec3>& queries, const MapQuery& ask,
                               const Sight& sight = {}) const {
    Neighbours found;
    map.correspond(queries, ask, found);
    REQUIRE(found.size() == queries.size());
    std::vector<std::pair<double, std::size_t>> near;  // squared distance, place in order of insertion
    std::size_t cut_off = 0;
    for (std::size_t i = 0; i < queries.size(); ++i) {
      const double nearest_hidden = look(queries[i], ask, sight, near);
      const auto k = static_cast<std::size_t>(ask.k);
      const double last = near.size() < k ? std::numeric_limits<double>::infinity() : near[k - 1].first;
      cut_off += nearest_hidden < last ? 1U : 0U;
      bool same = found.count[i] == std::min(near.size(), k);
      for (std::size_t j = 0; same && j < found.count[i]; ++j) {
        const Vec3 offset = held_[near[j].second].p - queries[i];
        same = found.offset(i, j).cast<double>() == offset &&
               static_cast<double>(found.squared[i * found.k() + j]) == near[j].first;
      }
      REQUIRE(same);
    }
    return cut_off;
  }

 private:
  struct Held {
    Vec3 p;
    std::uint32_t stamp;
    std::uint8_t kind;
  };

  /// Squared distances and places of what is near and seen, ascending; the squared distance of the nearest unseen.
  double look(const Vec3& query, const MapQuery& ask, const Sight& sight,
              std::vector<std::pair<double, std::size_t>>& near) const {
    near.clear();
    double nearest_hidden = std::numeric_limits<double>::infinity();
    for (std::size_t n = 0; n < held_.size(); ++n) {
      if (sight.tells_kinds && held_[n].kind != feature_class::kind(ask.feature)) continue;
      const double squared = (held_[n].p - query).squaredNorm();
      if (squared > ask.max_distance * ask.max_distance || held_[n].stamp > ask.max_stamp) continue;
      if (!sight.sees || sight.sees(query, held_[n].p)) {
        near.emplace_back(squared, n);
      } else {
        nearest_hidden = std::min(nearest_hidden, squared);
      }
    }
    std::sort(near.begin(), near.end());
    return nearest_hidden;
  }

  std::vector<Held> held_;
};

/// A batch as a sensor or an adversary would give it: a cloud, a wall, a sorted line, copies of few points.
inline std::vector<WorldPoint> draw_batch(Draw& draw, const Vec3& centre, int most) {
  const int kind = draw(0, 3);
  std::vector<WorldPoint> batch(static_cast<std::size_t>(draw(1, kind == 3 ? 50 : most)));
  const Vec3 start = draw.near(centre, 6), few[2] = {draw.near(centre, 6), draw.near(centre, 6)};
  for (std::size_t i = 0; i < batch.size(); ++i) {
    Vec3& p = batch[i].p_W;
    if (kind == 0) p = draw.near(centre, 6);
    if (kind == 1) {
      p = draw.near(centre, 6);
      p.z() = start.z();
    }
    if (kind == 2) p = start + Vec3(static_cast<double>(i) / 256.0, 0, 0);
    if (kind == 3) p = few[i % 2];
  }
  return batch;
}

/// Pairs that are equally far from the first point, on either side of it.
inline std::vector<WorldPoint> draw_mirrored_batch(Draw& draw, const Vec3& centre) {
  std::vector<WorldPoint> batch(static_cast<std::size_t>(draw(3, 200)));
  batch[0].p_W = draw.near(centre, 6);
  for (std::size_t i = 1; i < batch.size(); ++i) {
    batch[i].p_W = i % 2 == 1 ? draw.near(batch[0].p_W, 1) : 2.0 * batch[0].p_W - batch[i - 1].p_W;
  }
  return batch;
}

}  // namespace aslio::test
