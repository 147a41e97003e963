#pragma once

#include "aslio/core/angles.hpp"
#include "aslio/stages/motion.hpp"

namespace aslio {

/// How long points may enter the map although they match nothing: while the uncertainty has hardly grown since the last
/// update that was accepted. eq. IESKF-8.
class DeadReckoning {
 public:
  void forget() { since_ = kTimeMin; }
  /// `P`: any covariance whose first six entries are those of the pose error (theta, p).
  template <class Covariance>
  void begin(TimeNs t, const Covariance& P) {
    since_ = t;
    position_ = P.diagonal().template segment<3>(block::p).maxCoeff();
    tilt_ = P.diagonal().template segment<3>(block::theta).maxCoeff();
  }
  bool begun() const { return since_ != kTimeMin; }
  template <class Covariance>
  bool good(TimeNs t, const Covariance& P) const {
    constexpr double max_position = 0.1, max_turn = kRadPerDeg;  // [m], [rad]
    if (!begun() || t - since_ > kSecond) return false;
    const double position = P.diagonal().template segment<3>(block::p).maxCoeff() - position_;
    const double turn = P.diagonal().template segment<3>(block::theta).maxCoeff() - tilt_;
    return position < max_position * max_position && turn < max_turn * max_turn;
  }

 private:
  TimeNs since_ = kTimeMin;
  double position_ = 0, tilt_ = 0;  ///< largest variances then
};

}  // namespace aslio
