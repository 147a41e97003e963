#include "aslio/plugin/registry.hpp"
#include "insertions/on_new.hpp"

namespace aslio::plugins {

void register_insertions(plugin::Registry<Insertion>& registry);

void register_insertions(plugin::Registry<Insertion>& registry) {
  registry.add<InsertOnNew>("on_new", "fresh points enter the map once, at their own update");
}

}  // namespace aslio::plugins
