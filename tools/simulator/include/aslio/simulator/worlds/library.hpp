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
  std::int64_t seed = 1;  ///< of the layout and the clutter
  static void describe(config::Binder& b, LibraryParams& params);
};

World build_library(const LibraryParams& params, const Route& route, double scale);

}  // namespace aslio::simulator
