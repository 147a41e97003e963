#pragma once

namespace aslio::simulator {

/// Largest x in [low, high] for which a condition still holds that does at `low`.
template <class Holds>
double highest(double low, double high, Holds holds) {
  if (holds(high)) return high;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (holds(middle) ? low : high) = middle;
  }
  return low;
}

}  // namespace aslio::simulator
