#pragma once
/// What a pane of glass does to a pulse.

#include <cstdint>

#include "aslio/simulator/caster.hpp"

namespace aslio::simulator {

enum class PaneEffect : std::uint8_t {
  returned,  ///< dirt sends it back
  mirrored,  ///< it goes on in the mirrored direction
  passed,    ///< it goes on behind the pane
};

/// Share of the light that a pane of two surfaces of refractive index 1.52 mirrors, unpolarised (Fresnel). 1 at
/// grazing incidence.
double mirrored_share(double cos_incidence);

/// `draw` is uniform in [0, 1); `clear` is the share of pulses that no dirt sends back.
PaneEffect pane_effect(double draw, double clear, double cos_incidence);

/// Two faces of one pane are no farther apart along a ray [m].
inline constexpr double kPaneThickness = 0.1;
/// A pulse goes on this far behind the surface that it has passed [m]: rounding must not have it meet it again.
inline constexpr double kBehindPane = 1e-3;

inline bool is_glass(const SurfaceHit& hit) { return !hit.moving && hit.material == material::kGlass; }

}  // namespace aslio::simulator
