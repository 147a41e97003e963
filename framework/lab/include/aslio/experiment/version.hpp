#pragma once

#include <string_view>

namespace aslio::experiment {

/// "0.2.0"
std::string_view version();
/// Revision of the sources this was built from, with "-dirty" when they differed from it; empty when not known.
std::string_view source_revision();

}  // namespace aslio::experiment
