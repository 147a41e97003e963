#pragma once
/// What the contract tests of maps share.

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "aslio/stages/map.hpp"
#include "plugins/overlaps/one_stage.hpp"
#include "plugins/under_test.hpp"

namespace aslio::test {

/// Makes every registered map with its default parameters, or the one under test.
struct EveryMap {
  std::unique_ptr<Map> make(const std::string& type, exec::Executor& executor) {
    return make_stage<Map>(catalog, type, BuildContext{executor, sensor, nullptr});
  }
  std::unique_ptr<Map> make(const std::string& type) { return make(type, exec); }
  std::vector<std::string> types() const { return under_test(catalog, Map::family); }
  /// Those that hold points, or surfaces.
  std::vector<std::string> types(MapContent content) {
    std::vector<std::string> out;
    for (const auto& type : types()) {
      if (make(type)->content() == content) out.push_back(type);
    }
    return out;
  }
  const plugin::Catalog catalog = stages_under_test();
  SensorModel sensor;
  exec::Executor exec{1};
};

class Uniform {
 public:
  explicit Uniform(std::uint64_t seed) : engine_(seed) {}
  double operator()(double lo, double hi) { return lo + (hi - lo) * static_cast<double>(engine_() >> 11) * 0x1p-53; }
  Vec3 in_box(const Vec3& centre, double half) {
    const double x = (*this)(-half, half), y = (*this)(-half, half), z = (*this)(-half, half);
    return centre + Vec3(x, y, z);
  }

 private:
  std::mt19937_64 engine_;
};

inline WorldPoint at(const Vec3& p) {
  WorldPoint point;
  point.p_W = p;
  return point;
}

inline std::vector<Vec3> contents(const Map& map) {
  std::vector<Vec3> points;
  map.visit([&](const Vec3& p) { points.push_back(p); });
  return points;
}

/// Neighbours are, but for the rounding of floats, those of brute force over what visit() says the map holds.
inline void check_against_visit(const Map& map, const std::vector<Vec3>& queries, const MapQuery& ask) {
  constexpr double kSquaredRounding = 2e-6;  // [m^2] 1e-6 m and less of an offset, for reaches of about a metre
  const auto points = contents(map);
  REQUIRE(points.size() == map.size());
  Neighbours found;
  map.correspond(queries, ask, found);
  REQUIRE(found.size() == queries.size());
  const double reach = ask.max_distance * ask.max_distance;
  for (std::size_t i = 0; i < queries.size(); ++i) {
    std::vector<double> expected;  // squared, with those that are at the limit but for rounding
    for (const Vec3& p : points) {
      const double squared = (p - queries[i]).squaredNorm();
      if (squared <= reach + kSquaredRounding) expected.push_back(squared);
    }
    std::sort(expected.begin(), expected.end());
    const auto certain = std::upper_bound(expected.begin(), expected.end(), reach - kSquaredRounding);
    const auto k = static_cast<std::size_t>(ask.k);
    REQUIRE(found.count[i] >= std::min(static_cast<std::size_t>(certain - expected.begin()), k));
    REQUIRE(found.count[i] <= std::min(expected.size(), k));
    for (std::size_t j = 0; j < found.count[i]; ++j) {
      REQUIRE(std::abs(found.squared[i * found.k() + j] - expected[j]) < kSquaredRounding);
      const Vec3 offset = found.offset(i, j).cast<double>();
      REQUIRE(std::abs(offset.squaredNorm() - expected[j]) < kSquaredRounding);
      const Vec3 p = queries[i] + offset;
      REQUIRE(std::any_of(points.begin(), points.end(), [&](const Vec3& q) { return (q - p).norm() < 1e-5; }));
    }
  }
}

}  // namespace aslio::test
