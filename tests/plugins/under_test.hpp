#pragma once
/// Whose contract is checked: every stage of the library, or the one of a shared object that the environment names.
///
///   ASLIO_CONTRACT_PLUGIN   the shared object
///   ASLIO_CONTRACT_FAMILY   family of its stage
///   ASLIO_CONTRACT_STAGE    the stage as a configuration names it: "{type: my_window, period: 0.05}"
///
/// Cases whose names begin with `every` are the contract of a family; they are installed, and a project outside runs
/// them over its own stage (cmake/aslio_contract.cmake).

#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

#include "aslio/plugin/registry.hpp"
#include "aslio/plugin/shared_object.hpp"
#include "register_all.hpp"

namespace aslio::test {

/// Value of a variable of the environment; empty when unset.
inline std::string from_environment(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? std::string() : value;
}

/// The stages of the library and those of ASLIO_CONTRACT_PLUGIN.
inline plugin::Catalog stages_under_test() {
  plugin::Catalog catalog;
  plugins::register_all(catalog);
  const std::string file = from_environment("ASLIO_CONTRACT_PLUGIN");
  if (!file.empty()) plugin::load_shared_object(catalog, file);
  return catalog;
}

/// Whether the suite runs over one stage of `family` alone.
inline bool one_under_test(std::string_view family) { return from_environment("ASLIO_CONTRACT_FAMILY") == family; }

/// Stages of a family whose contract is checked, as a configuration names them: all with their defaults, or the one.
inline std::vector<std::string> under_test(const plugin::Catalog& catalog, std::string_view family) {
  if (one_under_test(family)) return {from_environment("ASLIO_CONTRACT_STAGE")};
  std::vector<std::string> stages;
  for (const std::string& type : catalog.types(family)) stages.push_back("{type: " + type + "}");
  return stages;
}

}  // namespace aslio::test
