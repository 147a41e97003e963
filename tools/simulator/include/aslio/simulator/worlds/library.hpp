#pragma once

#include <cstdint>

#include "aslio/simulator/route.hpp"
#include "aslio/simulator/world.hpp"

namespace aslio::config {
class Binder;
}

namespace aslio::simulator {

/// Library hall: aisles of 1.2-1.5 m between full-height shelves of books along the route.
struct LibraryParams {
  std::int64_t seed = 1;      ///< of the layout and the clutter
  double aisle_min = 1.25;    ///< width between shelves, drawn for each aisle [m]
  double aisle_max = 1.5;     ///< [m]
  double height = 2.9;        ///< of the ceiling [m]
  double shelf_height = 2.4;  ///< [m]
  std::int64_t rows = 3;      ///< of double shelves on each side of the route
  double books = 0.85;        ///< share of the shelves that is taken
  static void describe(config::Binder& b, LibraryParams& params);
};

/// Throws ConfigError when an edge of the route is not parallel to an axis.
World build_library(const LibraryParams& params, const Route& route, double scale);

}  // namespace aslio::simulator
