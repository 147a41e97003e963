#pragma once
/// A constant delay between the clocks of an estimate and its reference.

#include <optional>

#include "aslio/core/trajectory.hpp"

namespace aslio::evaluation {

struct TimeOffset {
  double seconds = 0;      ///< to be added to the stamps of the reference
  double rmse_before = 0;  ///< [m] of the positions, aligned
  double rmse_after = 0;   ///< [m] with the offset
};

/// The offset at which the positions fit best, where it lowers their error by more than two fifths; nothing where none
/// does, or where too little is in common to tell. Looks within 0.5 s, and within a minute where the speeds of the two
/// then agree far better. eq. EVAL-13
std::optional<TimeOffset> find_time_offset(const Trajectory& estimate, const Trajectory& reference, TimeNs max_gap);

}  // namespace aslio::evaluation
