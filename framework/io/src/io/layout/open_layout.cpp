#include <fmt/format.h>

#include "aslio/core/errors.hpp"
#include "writers_of.hpp"

namespace aslio::io {

std::unique_ptr<LayoutWriter> open_layout_writer(const Layout& layout, const LayoutPlace& place) {
  constexpr int kMostLines = 256;
  const SweepGrid& grid = place.grid;
  if (!(grid.period > 0) || grid.lines < 1 || grid.lines > kMostLines) {
    throw ConfigError(fmt::format("sweeps of {} lines and {} s: a layout takes 1 to {} lines and a period above 0",
                                  grid.lines, grid.period, kMostLines));
  }
  if (layout.lidar.organised && grid.columns < 1) {
    throw ConfigError("lidar.organised: the sensor has no fixed columns; write its points without it");
  }
  if (layout.of_messages()) return open_message_layout(layout, place);
  return layout.container == Container::kitti ? open_kitti_layout(layout, place) : open_folder_layout(layout, place);
}

}  // namespace aslio::io
