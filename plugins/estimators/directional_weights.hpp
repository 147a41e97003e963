#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "aslio/config/binder.hpp"
#include "aslio/core/angles.hpp"
#include "estimators/window_matches.hpp"

namespace aslio::plugins {

/// Weights of the points' information by direction of the pose. A normal with an error shows motions along its surface
/// that it does not see. Where hardly any point binds a direction, the sum of such errors passes for information on it.
/// What stands out from these errors counts, the rest does not (docs/equations.md IESKF-12 .. IESKF-14).
class DirectionalWeights {
 public:
  enum class Rule : std::uint8_t {
    none,
    damped,   ///< a direction as a whole: the more of its information may be error, the less it counts
    selected  ///< single rows, along weak directions: those whose normal shows it beyond its error
  };
  struct Params {
    Rule rule = Rule::none;
    double normal_error = 3.0;  ///< of a normal, standard deviation of each of its two angles [deg]
  };
  static void describe(config::Binder& b, Params& p);

  explicit DirectionalWeights(const Params& params);
  bool active() const { return rule_ != Rule::none; }
  bool damps() const { return rule_ == Rule::damped && count_ > 0; }
  bool selects() const { return rule_ == Rule::selected && count_ > 0; }

  /// Finds the weak directions from the rows `fresh` has at the attitude `R`; `A`: the sum of their information. None
  /// where A is not finite. eq. IESKF-12.
  void find(const WindowMatches& fresh, std::size_t rows_per_match, const Mat6& A, const Mat3& R);
  /// Directions that do not count in full, and the share of the k-th that counts [0, 1].
  int weak() const { return count_; }
  double share(int k) const { return directions_[static_cast<std::size_t>(k)].share; }
  /// (theta, p) of the k-th, of no particular length.
  const Vec6& direction(int k) const { return directions_[static_cast<std::size_t>(k)].v; }

  /// L, so that the damped normal equations are L A and L b. eq. IESKF-13.
  SeenMatrix damping(const SeenMatrix& A) const;
  /// `sum`, the sums of all rows of `set` within `gate` [m] at the attitude `R`, with the rows reduced. Residuals and
  /// numbers stay. eq. IESKF-14.
  void select(const WindowMatches& set, std::size_t rows_per_match, double gate, const Mat3& R,
              WindowInformation& sum) const;

 private:
  struct Direction {
    Vec6 v;     ///< (theta, p)
    Vec6 dual;  ///< 1 with v, 0 with the other directions
    double information = 0;
    double share = 0;
  };
  Vec6 reduced(const Vec3& p_I, const Vec3& u, const Mat3& R) const;

  Rule rule_;
  double variance_;  ///< of an angle of a normal [rad^2]
  int count_ = 0;
  std::array<Direction, 6> directions_;
};

}  // namespace aslio::plugins
