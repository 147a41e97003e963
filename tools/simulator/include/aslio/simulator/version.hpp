#pragma once

#include <string_view>

namespace aslio::simulator {

/// SHA-256 of the sources of the simulator: what it makes of a scene may change with them.
std::string_view sources_digest();

}  // namespace aslio::simulator
