#pragma once

#include "aslio/core/types.hpp"

namespace aslio {

/// A motion that goes on as it did over the last update: T(t) = T_k Exp((t - t_k) xi). eq. TRJ-2
class ConstantTwist {
 public:
  /// A pose that was found: the motion since the one before it goes on. The first is the begin of the world; before it,
  /// nothing is known of the motion.
  void follow(const Pose& found, TimeNs t) {
    if (t_ != kTimeMin) xi_ = log_se3(pose_.inverse() * found) / to_seconds(t - t_);
    hold(found, t);
  }
  /// A pose that shows nothing of the motion.
  void hold(const Pose& found, TimeNs t) {
    pose_ = found;
    t_ = t;
  }
  /// The motion at the start: rate [rad/s] and velocity [m/s], in I.
  void begin(const Vec3& rate, const Vec3& velocity) { xi_ << rate, velocity; }
  /// Whether the motion is believed to go on since the last pose: until then points may enter the map unmatched, since
  /// unseen space can only become known by inserting it.
  bool believed(TimeNs t) const { return t_ != kTimeMin && t - t_ <= kSecond; }
  /// `from` at t, biases and gravity as they are.
  NavState predict(const NavState& from, TimeNs t) const {
    const Pose pose = from.pose() * exp_se3(to_seconds(t - from.t) * xi_);
    NavState out = from;
    out.t = t;
    out.R = orthonormalised(pose.R);
    out.p = pose.p;
    out.v = out.R * velocity_in_body();
    return out;
  }
  Vec3 rate() const { return xi_.head<3>(); }              ///< [rad/s], in I
  Vec3 velocity_in_body() const { return xi_.tail<3>(); }  ///< [m/s], in I

 private:
  Vec6 xi_ = Vec6::Zero();
  Pose pose_;            ///< the last that was found
  TimeNs t_ = kTimeMin;  ///< its time
};

}  // namespace aslio
