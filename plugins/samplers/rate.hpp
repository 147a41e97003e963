#pragma once
/// `rate`: at most so many points per second of the stream, chosen at random over all of it; eq. SMP-3. A sensor that
/// measures more points does not cost more.

#include <array>
#include <cstdint>

#include "aslio/stages/build_context.hpp"
#include "aslio/stages/sampler.hpp"
#include "aslio/toolkit/point_uses.hpp"

namespace aslio::plugins {

class RateSampler final : public Sampler {
 public:
  struct Params {
    double points_per_s = 100'000.0;
    UseNames uses{"map"};
  };
  static void describe(config::Binder& b, Params& p);
  RateSampler(const Params& params, const BuildContext& context);

  ActsOn acts_on() const override { return ActsOn::raw; }
  /// Whether a point stays depends on its index, the seed, and how many points the second before had. All stay until
  /// one second of the stream has been counted.
  void sample(SampleBatch& batch) override;

 private:
  /// From its first point that was seen until that of the next one.
  struct Second {
    TimeNs begin = kTimeMin;
    std::uint32_t index = 0;              ///< of that point in the stream
    std::uint64_t keep_below = kKeepAll;  ///< hashes that stay
  };
  static constexpr std::uint64_t kKeepAll = ~std::uint64_t{0};

  void begin_second(const TimedPoint& first);
  std::uint64_t keep_below(TimeNs t) const;

  double points_per_s_;
  std::uint64_t seed_;
  PointUses uses_;
  std::array<Second, 4> seconds_;  ///< newest first: the points of a window may be of seconds before
};

}  // namespace aslio::plugins
