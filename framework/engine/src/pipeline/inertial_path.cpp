#include "inertial_path.hpp"

#include <algorithm>

namespace aslio::pipeline {

InertialPath::InertialPath(std::span<const ImuSample> imu, TimeNs begin) {
  knots_.push_back({begin, Mat3::Identity(), Vec3::Zero(), Vec3::Zero()});
  for (std::size_t i = 1; i < imu.size(); ++i) {
    const double dt = to_seconds(imu[i].t - imu[i - 1].t);
    if (!(dt > 0)) continue;
    const Knot& from = knots_.back();
    const Mat3 half = from.R * exp_so3(0.25 * dt * (imu[i - 1].gyro + imu[i].gyro));
    const Vec3 acc = half * (0.5 * (imu[i - 1].acc + imu[i].acc));
    knots_.push_back({imu[i].t, from.R * exp_so3(0.5 * dt * (imu[i - 1].gyro + imu[i].gyro)), from.v + dt * acc,
                      from.s + dt * from.v + 0.5 * dt * dt * acc});
  }
}

SweepPoint InertialPath::point(const Vec3& p_I, TimeNs t) {
  while (at_ + 2 < knots_.size() && knots_[at_ + 1].t < t) ++at_;
  SweepPoint out;
  out.t = to_seconds(t - knots_.front().t);
  const Knot& a = knots_[at_];
  if (knots_.size() == 1) {
    out.q = out.y = p_I;
    return out;
  }
  const Knot& b = knots_[at_ + 1];
  const double u = std::clamp(to_seconds(t - a.t) / to_seconds(b.t - a.t), 0.0, 1.0);
  const double dt = u * to_seconds(b.t - a.t);
  const Vec3 acc = (b.v - a.v) / to_seconds(b.t - a.t);
  out.q = interpolate({a.R, Vec3::Zero()}, {b.R, Vec3::Zero()}, u).R * p_I;
  out.y = out.q + a.s + dt * a.v + 0.5 * dt * dt * acc;
  return out;
}

}  // namespace aslio::pipeline
