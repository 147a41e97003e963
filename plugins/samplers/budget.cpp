#include "samplers/budget.hpp"

#include <algorithm>

namespace aslio::plugins {

void BudgetSampler::describe(config::Binder& b, Params& p) {
  b.integer("points", p.points, "", {.min = 1, .max = 1e7}, "points of a window that may stay");
  describe_uses(b, p.uses);
}

BudgetSampler::BudgetSampler(const Params& params, const BuildContext&)
    : points_(static_cast<std::uint64_t>(params.points)), uses_(use_mask(params.uses)) {}

void BudgetSampler::sample(SampleBatch& batch) {
  for (const PointUse use : {PointUse::overlap, PointUse::map, PointUse::match}) {
    const PointUses bit = mask(use);
    if ((uses_ & bit) == 0) continue;
    const auto total = static_cast<std::uint64_t>(
        std::count_if(batch.uses.begin(), batch.uses.end(), [bit](PointUses uses) { return (uses & bit) != 0; }));
    if (total <= points_) continue;
    std::uint64_t seen = 0;  // times points_ so far, modulo total: the points whose step passes it stay
    for (PointUses& uses : batch.uses) {
      if ((uses & bit) == 0) continue;
      seen += points_;
      if (seen >= total) {
        seen -= total;
      } else {
        uses = static_cast<PointUses>(uses & ~bit);
      }
    }
  }
}

}  // namespace aslio::plugins
