#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "aslio/config/binder.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/stages/sampler.hpp"

namespace my_plugin {

/// Which points take part? Here: those of every n-th scan line, or ring. The contract stands in
/// aslio/stages/sampler.hpp.
class MyStage final : public aslio::Sampler {
 public:
  /// Defaults stand here and nowhere else.
  struct Params {
    std::int64_t keep_every = 2;
    std::vector<std::string> uses = {"overlap", "map", "match"};
  };
  /// Names, units, ranges and meanings: for `aslio describe` and for the check of a configuration.
  static void describe(aslio::config::Binder& b, Params& p);

  MyStage(const Params& params, const aslio::BuildContext& context);

  /// Before de-skew: a decision needs nothing but the point itself.
  ActsOn acts_on() const override { return ActsOn::raw; }
  void sample(aslio::SampleBatch& batch) override;

 private:
  unsigned keep_every_;
  aslio::PointUses uses_ = 0;  ///< consumers whose points are thinned
};

}  // namespace my_plugin
