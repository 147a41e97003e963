#pragma once

#include "aslio/config/binder.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/stages/insertion.hpp"
#include "insertions/spaced_points.hpp"

namespace aslio::plugins {

/// `min_distance`: a fresh point enters at its own update unless a point of its kind (lines; all others) in the map, or
/// one of the same update that has entered before it, is nearer than `distance` (the rule of CT-ICP, which looks no
/// farther than the point's own voxel). The map must find neighbours at that distance.
class InsertMinDistance final : public Insertion {
 public:
  struct Params {
    double distance = 0.1;
  };
  static void describe(config::Binder& b, Params& p);

  InsertMinDistance(const Params& params, const BuildContext&) : distance_(params.distance), spaced_(params.distance) {}

  bool needs_nearest_points() const override { return true; }
  InsertCount apply(const Window& window, const Update& update, Map& map) override;

 private:
  std::size_t insert(std::span<const WorldPoint> points, std::uint8_t kind, std::uint32_t stamp, Map& map);

  double distance_;
  SpacedPoints spaced_;
  std::vector<WorldPoint> own_;
  std::vector<Vec3> queries_;
  Neighbours nearest_;
};

}  // namespace aslio::plugins
