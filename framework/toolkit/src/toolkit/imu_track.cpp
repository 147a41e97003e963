#include "aslio/toolkit/imu_track.hpp"

#include "aslio/toolkit/information_update.hpp"

namespace aslio {

ImuTrack::ImuTrack(const Params& params, const BuildContext& context)
    : params_(params), sensor_(context.sensor), motion_(params.motion.make(context)) {}

void ImuTrack::reset(const InitialState& initial) {
  P_ = initial_covariance(initial, estimated_, initial.sigma_velocity);
  unresolved_ = {};
}

NavState ImuTrack::predict(const NavState& from, std::span<const ImuSample> imu) const {
  NavState state = from;
  for (std::size_t i = 1; i < imu.size(); ++i) motion_->step(state, imu[i - 1], imu[i]);
  return state;
}

NavState ImuTrack::propagate(const NavState& from, const Window& window, WindowTrajectory* path) {
  const StateMatrix before = P_;
  NavState state = from;
  unresolved_.observe(window);
  const ImuNoisePreset::Circumstances how{false, window.imu_gap, unresolved_.density()};
  for (std::size_t i = 1; i < window.imu.size(); ++i) {
    const ImuSample &begin = window.imu[i - 1], &end = window.imu[i];
    motion_->propagate_covariance(state, begin, end, params_.noise.over(begin, end, sensor_, from.b_w, how), P_);
    const MotionSegment segment = motion_->step(state, begin, end);
    if (path != nullptr) path->append(segment, state);
  }
  P_ = (0.5 * (P_ + P_.transpose())).eval();
  if (!P_.allFinite()) P_ = before;
  state.t = window.plan.end;
  return state;
}

NavState ImuTrack::correct(const NavState& predicted, const Pose& pose, const Mat6& information) {
  Eigen::Matrix<double, 6, kStateDim> H = Eigen::Matrix<double, 6, kStateDim>::Zero();
  H.leftCols<6>().setIdentity();
  Vec6 off;
  off << log_so3(predicted.R.transpose() * pose.R), pose.p - predicted.p;
  const Vec6 b = -information * off;
  const StateVector delta = iteration_step<6>(P_, H, information, b, StateVector::Zero().eval());
  P_ = posterior_covariance<6>(P_, H, information, information, HistoryCovariance::all);
  const NavState corrected = box_plus(predicted, delta, true);
  turn_with_gravity(predicted.g, corrected.g, block::g, P_);
  return corrected;
}

}  // namespace aslio
