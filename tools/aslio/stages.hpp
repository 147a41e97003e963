#pragma once
/// The stages a command may name: those built in, and those of shared objects.

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "aslio/experiment/run.hpp"
#include "aslio/plugin/registry.hpp"

namespace aslio::cli {

struct Stages {
  plugin::Catalog catalog;
  std::vector<experiment::PluginFile> files;
};

/// `--plugin FILE.so`, any number of times.
void add_plugin_option(CLI::App& app, std::vector<std::string>& files);

/// Throws ConfigError for a shared object that cannot be loaded.
Stages load_stages(const std::vector<std::string>& plugin_files);

/// Name of a family, and a line for each of its types.
std::string family_text(const plugin::Catalog& catalog, const std::string& family);

}  // namespace aslio::cli
