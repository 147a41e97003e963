#pragma once

#include "aslio/plugin/registry.hpp"

namespace aslio::plugins {

/// Registers every stage of this directory.
void register_all(plugin::Catalog& catalog);

}  // namespace aslio::plugins
