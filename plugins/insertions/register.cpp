#include "aslio/plugin/registry.hpp"
#include "insertions/at_reference.hpp"
#include "insertions/cell_nearest.hpp"
#include "insertions/keyframe.hpp"
#include "insertions/min_distance.hpp"
#include "insertions/on_exit.hpp"
#include "insertions/on_new.hpp"
#include "insertions/whole_window.hpp"

namespace aslio::plugins {

void register_insertions(plugin::Registry<Insertion>& registry);

void register_insertions(plugin::Registry<Insertion>& registry) {
  registry.add<InsertOnNew>("on_new", "fresh points enter the map once, at their own update");
  registry.add<InsertOnExit>("on_exit", "fresh points enter the map once, when they leave the window");
  registry.add<InsertAtReference>("at_reference", "as on_exit, where a known trajectory places them: for experiments");
  registry.add<InsertKeyframe>("keyframe", "fresh points enter where the last that did are far enough, as in LIO-SAM");
  registry.add<InsertWholeWindow>("whole_window", "every update inserts all points of its window again, as in SR-LIO");
  registry.add<InsertMinDistance>("min_distance", "fresh points enter unless one of the map is too near, as in CT-ICP");
  registry.add<InsertCellNearest>("cell_nearest",
                                  "fresh points enter unless a neighbour is nearer to the centre of their cell, as in "
                                  "FAST-LIO2");
}

}  // namespace aslio::plugins
