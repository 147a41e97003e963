#include "../../framework/engine/src/plugin/plugin_file.hpp"
#include "fuzz/target.hpp"

// All that is looked at before the code of a plugin is loaded.
ASLIO_FUZZ_TARGET(plugin) {
  const auto path = written("input.so", bytes);
  accepts([&] { (void)plugin::check_plugin_file(path, plugin::WritablePlugins::refused); });
}
