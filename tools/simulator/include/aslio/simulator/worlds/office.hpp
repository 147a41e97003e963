#pragma once

#include <cstdint>

#include "aslio/simulator/route.hpp"
#include "aslio/simulator/world.hpp"

namespace aslio::config {
class Binder;
}

namespace aslio::simulator {

/// Office corridors 2-2.5 m wide along the route, rooms with doors beside them; also single rooms by coordinates
/// (quickstart).
struct OfficeParams {
  std::int64_t seed = 1;  ///< of the layout and the clutter
  static void describe(config::Binder& b, OfficeParams& params);
};

World build_office(const OfficeParams& params, const Route& route, double scale);

}  // namespace aslio::simulator
