#pragma once
/// `--set a.b=c`: values that replace those of a file. They are recorded as their own origin in messages.

#include <span>
#include <string>

#include "aslio/config/node.hpp"

namespace aslio::config {

/// `window.seg_step=0.04`, `samplers.2.leaf=0.2`, `window={type: fixed, period: 0.05}`. The value is YAML.
struct Override {
  std::string assignment;
};

/// `root` with the overrides applied in order. Setting `x.type` drops the other keys of x (they belong to the old
/// type), a list grows by setting the index just behind its end. Whether a path exists is for the binder to say: it
/// knows the keys. Throws ConfigError: no '=', empty path or value, an index beyond the end of a list, an earlier
/// override that a later one would drop.
Node apply_overrides(const Node& root, std::span<const Override> overrides);

}  // namespace aslio::config
