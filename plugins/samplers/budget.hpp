#pragma once
/// `budget`: at most so many points, evenly over those that are left: the cost of an update is bounded whatever the
/// sensor.

#include "aslio/stages/build_context.hpp"
#include "aslio/stages/sampler.hpp"
#include "aslio/toolkit/point_uses.hpp"

namespace aslio::plugins {

class BudgetSampler final : public Sampler {
 public:
  struct Params {
    std::int64_t points = 10000;
    UseNames uses{"match"};
  };
  static void describe(config::Binder& b, Params& p);
  BudgetSampler(const Params& params, const BuildContext& context);

  ActsOn acts_on() const override { return ActsOn::body; }
  void sample(SampleBatch& batch) override;

 private:
  std::uint64_t points_;
  PointUses uses_;
};

}  // namespace aslio::plugins
