#pragma once

#include "aslio/core/types.hpp"

namespace aslio::plugins {

/// A motion that goes on as it did over the last update: T(t) = T_k Exp((t - t_k) xi). eq. TRJ-2
class ConstantTwist {
 public:
  Pose predict(const Pose& from, double seconds) const { return from * exp_se3(seconds * xi_); }
  /// The motion from `from` to `to` took so long.
  void learn(const Pose& from, const Pose& to, double seconds) { xi_ = log_se3(from.inverse() * to) / seconds; }
  Vec3 rate() const { return xi_.head<3>(); }              ///< [rad/s], in I
  Vec3 velocity_in_body() const { return xi_.tail<3>(); }  ///< [m/s], in I
  bool finite() const { return xi_.allFinite(); }

 private:
  Vec6 xi_ = Vec6::Zero();
};

}  // namespace aslio::plugins
