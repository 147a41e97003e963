#pragma once
/// --dataset and --data: a dataset file, or a sequence of a published data set in a folder of the user.

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>

#include "aslio/experiment/dataset.hpp"

namespace aslio::cli {

void add_dataset_options(CLI::App& app, std::string& dataset, std::string& data);

/// What the two options name. Throws ConfigError, which names the nearest family or sequence and lists all.
experiment::Dataset find_dataset(const std::string& dataset, const std::string& data);

/// The folder of the families that come with the program.
std::filesystem::path shipped_families();

}  // namespace aslio::cli
