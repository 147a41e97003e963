#pragma once

#include <memory>
#include <string>
#include <vector>

#include "aslio/stages/insertion.hpp"
#include "plugins/maps/map_fixture.hpp"

namespace aslio::test {

/// Every registered insertion with its defaults, or the one under test, and every map.
struct EveryInsertion : EveryMap {
  std::unique_ptr<Insertion> insertion(const std::string& text) {
    return make_stage<Insertion>(catalog, text, BuildContext{exec, sensor, nullptr});
  }
  std::vector<std::string> insertions() const { return under_test(catalog, Insertion::family); }
  std::unique_ptr<Map> map(const std::string& text) {
    return make_stage<Map>(catalog, text, BuildContext{exec, sensor, nullptr});
  }
};

}  // namespace aslio::test
