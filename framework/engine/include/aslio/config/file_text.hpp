#pragma once
/// From values back to the file that states them.

#include <string>

#include "aslio/config/load.hpp"

namespace aslio::config {

/// YAML text of a file of this kind with every key at its value in `value`; reading it gives the same values. T has
/// `static void describe(Binder&, T&)`. Throws ConfigError where the values do not satisfy their own ranges.
template <class T>
std::string file_text(const T& value, FileKind kind, const StageLookup& stages) {
  const std::string name(config::name(kind));
  return bind_text("schema: aslio/" + name + "/1\n", name, kind, stages, {},
                   [&](Binder& b) {
                     T defaults = value;  // an empty file leaves them as they are
                     T::describe(b, defaults);
                   })
      .resolved;
}

}  // namespace aslio::config
