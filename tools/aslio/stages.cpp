#include "stages.hpp"

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
  (void)plugin_files;
  return stages;
}

}  // namespace aslio::cli
