#pragma once
/// `stride`: thins the raw stream before anything costly happens to it.

#include <cstdint>

#include "aslio/stages/build_context.hpp"
#include "aslio/stages/sampler.hpp"
#include "samplers/taps.hpp"

namespace aslio::plugins {

class StrideSampler final : public Sampler {
 public:
  /// What is counted.
  enum class By : std::uint8_t {
    point,  ///< points, over the whole stream
    firing  ///< firings (points of equal time), kept or dropped whole by a hash of that time
  };

  struct Params {
    std::int64_t keep_every = 5;
    By by = By::point;
    TapNames taps{"overlap", "map", "match"};
  };
  static void describe(config::Binder& b, Params& p);

  /// The phase is context.order_seed. Warns when a stride over points leaves out scan lines for good.
  StrideSampler(const Params& params, const BuildContext& context);

  ActsOn acts_on() const override { return ActsOn::raw; }
  void sample(SampleBatch& batch) override;

 private:
  bool keeps(const TimedPoint& p) const;

  std::uint32_t keep_every_;
  std::uint32_t phase_;  ///< index (mod keep_every) of the points kept
  std::uint64_t seed_;
  By by_;
  TapMask taps_;
};

}  // namespace aslio::plugins
