#pragma once

#include <array>
#include <cstdint>
#include <map>

#include "aslio/config/binder.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/stages/overlap.hpp"

namespace my_plugin {

/// How much of the frame does the map already know? Here: the share of points whose voxel held a point `delay` ago. The
/// contract stands in aslio/stages/overlap.hpp.
class MyStage final : public aslio::OverlapMetric {
 public:
  /// Defaults stand here and nowhere else.
  struct Params {
    double voxel = 0.2;
    double delay = 0.1;
    std::int64_t min_points = 50;
  };
  /// Names, units, ranges and meanings: for `aslio describe` and for the check of a configuration.
  static void describe(aslio::config::Binder& b, Params& p);

  MyStage(const Params& params, const aslio::BuildContext& context);

  aslio::OverlapScore evaluate(std::span<const aslio::WorldPoint> points, aslio::TimeNs t) override;
  void extend(std::span<const aslio::WorldPoint> points, aslio::TimeNs t) override;
  void trim(const aslio::Vec3& centre_W, double radius) override;
  void clear() override;
  std::size_t memory_bytes() const override;

 private:
  using Voxel = std::array<std::int32_t, 3>;
  /// Whether `p` lies in a voxel; points that are not finite or too far do not.
  bool voxel_of(const aslio::Vec3& p, Voxel& voxel) const;

  double voxel_;  ///< edge [m]
  aslio::TimeNs delay_;
  std::uint32_t min_points_;
  std::map<Voxel, aslio::TimeNs> known_since_;
  aslio::TimeNs last_extend_ = aslio::kTimeMin;
};

}  // namespace my_plugin
