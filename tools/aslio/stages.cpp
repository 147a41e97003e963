#include "stages.hpp"

#include <fmt/format.h>

#include <iterator>

#include "aslio/plugin/shared_object.hpp"
#include "console.hpp"
#include "register_all.hpp"

namespace aslio::cli {

void add_plugin_option(CLI::App& app, std::vector<std::string>& files) {
  app.add_option("--plugin", files, "shared object with further stages; may be repeated (see also ASLIO_PLUGIN_PATH)")
      ->type_name("FILE.so")
      ->allow_extra_args(false);
}

Stages load_stages(const std::vector<std::string>& plugin_files) {
  Stages stages;
  plugins::register_all(stages.catalog);
  for (auto& object : plugin::load_shared_objects(stages.catalog, plugin_files, plugin::plugin_search_path(),
                                                  plugin::writable_plugins())) {
    if (!object.warning.empty()) tell("warning: " + object.warning);
    stages.files.push_back({std::move(object.path), std::move(object.sha256)});
  }
  return stages;
}

std::string family_text(const plugin::Catalog& catalog, const std::string& family) {
  std::string text = family + "\n";
  for (const std::string& type : catalog.types(family)) {
    const auto* entry = catalog.find(family, type);
    fmt::format_to(std::back_inserter(text), "  {:<18} {}", type, entry->doc);
    if (entry->origin != "built-in") fmt::format_to(std::back_inserter(text), " [{}]", entry->origin);
    text += '\n';
  }
  return text;
}

}  // namespace aslio::cli
