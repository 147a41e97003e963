#pragma once
/// The transform between the world of an estimate and that of its reference.

#include <span>

#include "aslio/evaluation/association.hpp"

namespace aslio::evaluation {

/// none: worlds are the same. yaw: rotation about z and translation, right for estimates whose z is vertical, and shows
/// their tilt. se3: any rotation and translation, hides a constant tilt.
enum class Alignment { none, yaw, se3 };

/// The alignment A that minimises the weighted sum of |A p_estimate - p_reference|^2 (Umeyama, without scale).
/// `weights` has one value >= 0 per pair. Throws DataError when the positions do not determine it: all on a line (se3),
/// or on a vertical line (yaw), within rounding. eq. EVAL-4, EVAL-5
Pose align(Alignment alignment, std::span<const PosePair> pairs, std::span<const double> weights);

/// How far the reference positions spread in the direction that determines the rotation worst [m], as a weighted
/// standard deviation: across their main direction for se3, horizontally for yaw; infinite for none. Errors of the
/// positions turn the alignment by about their size divided by this.
double determining_spread(Alignment alignment, std::span<const PosePair> pairs, std::span<const double> weights);

/// The rotation nearest to M in the Frobenius norm. eq. EVAL-6
Mat3 nearest_rotation(const Mat3& M);

}  // namespace aslio::evaluation
