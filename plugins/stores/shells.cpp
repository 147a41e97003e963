#include "stores/shells.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace aslio::plugins {

int layer_of(int dx, int dy, int dz, LayerMetric metric) {
  const int ax = std::abs(dx), ay = std::abs(dy), az = std::abs(dz);
  switch (metric) {
    case LayerMetric::chebyshev:
      return std::max({ax, ay, az});
    case LayerMetric::manhattan:
      return ax + ay + az;
    case LayerMetric::euclid_rounded:
      break;
  }
  return static_cast<int>(std::lround(std::sqrt(static_cast<double>(dx * dx + dy * dy + dz * dz))));
}

Shells::Shells(LayerMetric metric) {
  constexpr int reach = static_cast<int>(kMaxLayers) - 1;
  for (int layer = 0; layer <= reach; ++layer) {
    begins_[static_cast<std::size_t>(layer)] = offsets_.size();
    for (int x = -layer; x <= layer; ++x) {
      for (int y = -layer; y <= layer; ++y) {
        for (int z = -layer; z <= layer; ++z) {
          if (layer_of(x, y, z, metric) != layer) continue;
          offsets_.push_back({static_cast<std::int8_t>(x), static_cast<std::int8_t>(y), static_cast<std::int8_t>(z),
                              pack_cell(x, y, z) - pack_cell(0, 0, 0)});
        }
      }
    }
  }
  begins_[kMaxLayers] = offsets_.size();
}

const Shells& Shells::of(LayerMetric metric) {
  static const std::array<Shells, 3> tables{Shells(LayerMetric::chebyshev), Shells(LayerMetric::manhattan),
                                            Shells(LayerMetric::euclid_rounded)};
  return tables[static_cast<std::size_t>(metric)];
}

}  // namespace aslio::plugins
