#pragma once
/// For authors of shared objects with further stages:
///
///   void register_types(aslio::plugin::Catalog& catalog) {
///     aslio::plugin::Registry<aslio::WindowStrategy>(catalog).add<MyWindow>("my_window", "what it is for");
///   }
///   ASLIO_PLUGIN(register_types)
///
/// Build it as a CMake MODULE that links aslio::engine (examples/out_of_tree_plugin) with the compiler and the
/// installation that built the program, and name it with `--plugin FILE.so` or put it into a directory of
/// ASLIO_PLUGIN_PATH.
///
/// Why the shared object links the static framework, instead of taking its symbols from the program: it then works in
/// any program, exported symbols or not, and a missing symbol shows when the plugin is linked. Two copies of a function
/// cannot disagree: the framework has no mutable statics, and the build stamp holds both copies to one version and
/// layout. Objects are opened RTLD_LOCAL, so two plugins may use the same names. Exceptions and dynamic_cast cross the
/// boundary because libstdc++ compares types by name. A shared object is never closed: stages point into its code.

#include <cstring>
#include <exception>

#include "aslio/plugin/abi.hpp"
#include "aslio/plugin/registry.hpp"

namespace aslio::plugin::detail {

inline void report(const char* text, char* message, std::size_t capacity) {
  if (capacity == 0) return;
  std::strncpy(message, text, capacity - 1);
  message[capacity - 1] = '\0';
}

template <void (*Register)(Catalog&)>
int register_guarded(void* catalog, char* message, std::size_t capacity) {
  try {
    Register(*static_cast<Catalog*>(catalog));
    return 0;
  } catch (const std::exception& error) {
    report(error.what(), message, capacity);
  } catch (...) {
    report("an exception that is no std::exception", message, capacity);
  }
  return 1;
}

}  // namespace aslio::plugin::detail

/// Once per shared object, outside any namespace. `function` is a void(aslio::plugin::Catalog&).
#define ASLIO_PLUGIN(function)                                                                                        \
  extern "C" __attribute__((visibility("default"))) const AslioPlugin aslio_plugin = {                                \
      aslio::plugin::kPluginMagic, aslio::plugin::kPluginAbiVersion, sizeof(AslioPlugin), aslio::plugin::kBuildStamp, \
      &aslio::plugin::detail::register_guarded<&function>};
