#pragma once
/// What the contract tests of maps share.

#include <algorithm>
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

}  // namespace aslio::test
