#pragma once
/// The `uses` key that every sampler has: for which consumers it thins.

#include <string>
#include <vector>

#include "aslio/config/binder.hpp"
#include "aslio/stages/points.hpp"

namespace aslio {

using UseNames = std::vector<std::string>;

/// Declares `uses: [overlap, map, match]`.
void describe_uses(config::Binder& b, UseNames& uses);

/// The bits of names that describe_uses() has admitted.
PointUses use_mask(const UseNames& uses);

}  // namespace aslio
