#pragma once
/// Surfaces that are not flat: a displacement along the normal, fixed in the world.

#include <cstdint>

#include "aslio/simulator/caster.hpp"
#include "aslio/simulator/realism.hpp"

namespace aslio::simulator {

/// Standard deviations of a material [m].
struct MaterialRoughness {
  double unevenness = 0;  ///< over metres
  double relief = 0;      ///< over centimetres
};
/// A material is known by its reflectivity (material:: in mesh.hpp); others have those of painted board.
MaterialRoughness roughness_of(std::uint8_t reflectivity);

/// Smooth random displacement of the surfaces of a world: the same whenever and from wherever a place is seen.
class Roughness {
 public:
  Roughness(const SurfaceRealism& surface, std::uint64_t world_seed);

  bool flat() const { return surface_.unevenness == 0 && surface_.relief == 0; }
  /// Displacement of the surface at `p_W` along its normal [m].
  double displacement(const Vec3& p_W, std::uint8_t reflectivity) const;
  /// Where a ray from `origin` along the unit vector `direction` meets the surface that it would hit at `hit` if it
  /// were flat. Steeper than kSteepest the range changes no further; a range stays positive.
  void apply(const Vec3& origin, const Vec3& direction, SurfaceHit& hit) const;

  static constexpr double kSteepest = 0.15;  ///< cosine of the incidence

 private:
  SurfaceRealism surface_;
  std::uint64_t seed_;
};

}  // namespace aslio::simulator
