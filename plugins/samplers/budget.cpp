#include "samplers/budget.hpp"

#include <algorithm>

namespace aslio::plugins {

void BudgetSampler::describe(config::Binder& b, Params& p) {
  b.integer("points", p.points, "", {.min = 1, .max = 1e7}, "points of a window that may stay");
  describe_taps(b, p.taps);
}

BudgetSampler::BudgetSampler(const Params& params, const BuildContext&)
    : points_(static_cast<std::uint64_t>(params.points)), taps_(tap_mask(params.taps)) {}

void BudgetSampler::sample(SampleBatch& batch) {
  for (const Tap tap : {Tap::overlap, Tap::map, Tap::match}) {
    const TapMask bit = mask(tap);
    if ((taps_ & bit) == 0) continue;
    const auto total = static_cast<std::uint64_t>(
        std::count_if(batch.taps.begin(), batch.taps.end(), [bit](TapMask taps) { return (taps & bit) != 0; }));
    if (total <= points_) continue;
    std::uint64_t seen = 0;  // times points_ so far, modulo total: the points whose step passes it stay
    for (TapMask& taps : batch.taps) {
      if ((taps & bit) == 0) continue;
      seen += points_;
      if (seen >= total) {
        seen -= total;
      } else {
        taps = static_cast<TapMask>(taps & ~bit);
      }
    }
  }
}

}  // namespace aslio::plugins
