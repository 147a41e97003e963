#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "aslio/config/binder.hpp"
#include "aslio/core/angles.hpp"
#include "estimators/window_matches.hpp"

namespace aslio::plugins {

/// Weights of the points' information by direction of the pose. A normal with an error shows motions along its surface
/// that it does not see. Where hardly any point binds a direction, the sum of such errors passes for information on it.
/// What stands out from these errors counts, the rest does not (docs/equations.md IESKF-12, IESKF-13).
class DirectionalWeights {
 public:
  enum class Rule : std::uint8_t {
    none,
    damped  ///< the more of a direction's information may be error, the less it counts
  };
  struct Params {
    Rule rule = Rule::none;
    double normal_error = 1.0;  ///< of any normal, standard deviation of each of its two angles [deg]
  };
  static void describe(config::Binder& b, Params& p);

  explicit DirectionalWeights(const Params& params);
  bool active() const { return rule_ != Rule::none; }
  bool damps() const { return rule_ == Rule::damped && count_ > 0; }

  /// Fresh rows, of the last sum.
  struct Rows {
    const WindowMatches& set;
    std::size_t per_match = 1;
    double fitted_to = 0;  ///< greatest noise of the neighbours to which planes are fitted [m]; 0: none are
    Mat3 R;                ///< attitude of the pose
  };
  /// Finds the weak directions from the fresh rows; `A`: the sum of their information. None where A is not finite. eq.
  /// IESKF-12.
  void find(const Rows& fresh, const Mat6& A);
  /// Directions that do not count in full, and the share of the k-th that counts [0, 1].
  int weak() const { return count_; }
  double share(int k) const { return directions_[static_cast<std::size_t>(k)].share; }
  /// (theta, p) of the k-th, of no particular length.
  const Vec6& direction(int k) const { return directions_[static_cast<std::size_t>(k)].v; }

  /// L, so that the damped normal equations are L A and L b. eq. IESKF-13.
  SeenMatrix damping(const SeenMatrix& A) const;

 private:
  struct Direction {
    Vec6 v;  ///< (theta, p)
    double information = 0;
    double share = 0;
  };

  Rule rule_;
  double variance_;  ///< of an angle of a normal [rad^2]
  int count_ = 0;
  std::array<Direction, 6> directions_;
};

}  // namespace aslio::plugins
