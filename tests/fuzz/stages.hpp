#pragma once

#include "aslio/plugin/registry.hpp"
#include "register_all.hpp"

namespace aslio::fuzz {

/// The stages that come with the program.
inline const plugin::Catalog& all_stages() {
  static const plugin::Catalog all = [] {
    plugin::Catalog catalog;
    plugins::register_all(catalog);
    return catalog;
  }();
  return all;
}

}  // namespace aslio::fuzz
