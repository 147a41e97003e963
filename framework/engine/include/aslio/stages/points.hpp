#pragma once
/// Points on their way through an update, and the consumers they are sampled for.

#include <cstdint>

#include "aslio/core/packed_direction.hpp"
#include "aslio/core/types.hpp"

namespace aslio {

/// Consumers of points; a sampler names those it thins. Bit mask.
enum class PointUse : std::uint8_t { overlap = 1, map = 2, match = 4 };
using PointUses = std::uint8_t;
inline constexpr PointUses kAllUses = 7;
constexpr PointUses mask(PointUse use) { return static_cast<PointUses>(use); }

/// Classes of points: TimedPoint, WorldPoint and MapQuery::feature.
namespace feature_class {
inline constexpr std::uint8_t none = 0, line = 1, plane = 2;
/// What is kept and found together: lines are a kind of their own, and whatever else counts as planes.
constexpr std::uint8_t kind(std::uint8_t feature) { return feature == line ? line : plane; }
/// Added to the class in SampleBatch::features alone: one of the clearest of its class.
inline constexpr std::uint8_t clearest = 0x80;
}  // namespace feature_class

/// A fresh point at the posterior pose.
struct WorldPoint {
  Vec3 p_W = Vec3::Zero();
  TimeNs t = 0;
  float range = 0;  ///< |p_L| [m]
  float intensity = 0;
  std::uint32_t index = 0;  ///< position in Window::fresh
  std::uint8_t line = 0;
  std::uint8_t feature = 0;   ///< feature_class
  PackedDirection view = {};  ///< from the sensor to the point, W, when it was first placed
};

}  // namespace aslio
