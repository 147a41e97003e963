#pragma once
/// The `taps` key that every sampler has: for which consumers it thins.

#include <string>
#include <vector>

#include "aslio/config/binder.hpp"
#include "aslio/stages/points.hpp"

namespace aslio {

using TapNames = std::vector<std::string>;

/// Declares `taps: [overlap, map, match]`.
void describe_taps(config::Binder& b, TapNames& taps);

/// The bits of names that describe_taps() has admitted.
TapMask tap_mask(const TapNames& taps);

}  // namespace aslio
