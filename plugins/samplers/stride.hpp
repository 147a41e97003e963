#pragma once
/// `stride`: thins the raw stream before anything costly happens to it; eq. SMP-1: only while the view is known.

#include <cstdint>

#include "aslio/stages/build_context.hpp"
#include "aslio/stages/sampler.hpp"
#include "aslio/toolkit/point_uses.hpp"

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
    double known = 0.0;   ///< O from which on it thins; 0: always
    double warmup = 1.0;  ///< with `known`: after the first insertion all points are taken for so long [s]
    UseNames uses{"overlap", "map", "match"};
  };
  static void describe(config::Binder& b, Params& p);

  /// The phase is context.order_seed. Warns when a stride over points leaves out scan lines for good.
  StrideSampler(const Params& params, const BuildContext& context);

  ActsOn acts_on() const override { return ActsOn::raw; }
  void observe(const Feedback& feedback) override;
  void sample(SampleBatch& batch) override;

 private:
  bool keeps(const TimedPoint& p) const;

  std::uint32_t keep_every_;
  std::uint32_t phase_;  ///< index (mod keep_every) of the points kept
  std::uint64_t seed_;
  By by_;
  double known_;
  TimeNs warmup_;
  bool thins_;  ///< for the update at hand
  PointUses uses_;
};

}  // namespace aslio::plugins
