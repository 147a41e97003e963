#include "estimators/sensor_states.hpp"

#include <limits>

#include "aslio/core/angles.hpp"

namespace aslio::plugins {

namespace {

constexpr int kRotation = 0, kTranslation = 3, kScale = 6;  // offsets among the own states

}  // namespace

void SensorStates::describe(config::Binder& b, Params& p) {
  b.choice("extrinsic", p.extrinsic,
           {{"none", Extrinsic::none}, {"rotation", Extrinsic::rotation}, {"full", Extrinsic::full}},
           "what of T_imu_lidar is estimated: nothing, its rotation, or its translation, too (needs turns about two "
           "axes)");
  b.real("sigma_extrinsic_deg", p.sigma_extrinsic_deg, "deg", {.above = 0, .max = 30},
         "extrinsic: rotation, full: standard deviation of each axis of its rotation at the start");
  b.real("sigma_extrinsic_m", p.sigma_extrinsic_m, "m", {.above = 0, .max = 1},
         "extrinsic: full: standard deviation of each axis of its translation at the start");
  b.flag("acc_scale", p.acc_scale, "estimate the scale factors of the accelerometer");
  b.real("sigma_acc_scale", p.sigma_acc_scale, "", {.above = 0, .max = 0.5},
         "acc_scale: standard deviation of each scale factor at the start");
}

void SensorStates::reset(bool at_rest) {
  active_ = at_rest && params_.any();
  now_ = prior_ = {declared_, Vec3::Zero()};
  own_.setZero();
  cross_.setZero();
  if (!active_) return;
  const auto known_to = [&](int at, double sigma) { own_.diagonal().segment<3>(at).setConstant(sigma * sigma); };
  if (params_.extrinsic != Extrinsic::none) known_to(kRotation, params_.sigma_extrinsic_deg * kRadPerDeg);
  if (params_.extrinsic == Extrinsic::full) known_to(kTranslation, params_.sigma_extrinsic_m);
  if (params_.acc_scale) known_to(kScale, params_.sigma_acc_scale);
}

void SensorStates::start_map(const NavState& at, bool gravity, StateMatrix& P) {
  if (!active()) return;
  Eigen::Matrix<double, kStateDim, kOwn> J = Eigen::Matrix<double, kStateDim, kOwn>::Zero();
  J.topRows<6>() = -shown(at.R);             // what the points see of pose and mounting is right
  const Vec3 g_I = at.R.transpose() * at.g;  // and g is known from where the IMU is
  if (gravity) J.middleRows<3>(block::g) = -at.R * hat(g_I) * J.topRows<3>();
  cross_ = J * own_;
  P += J * own_ * J.transpose();
}

std::span<const ImuSample> SensorStates::read(std::span<const ImuSample> imu) {
  if (!active_ || !params_.acc_scale) return imu;
  scaled_.clear();
  for (const ImuSample& sample : imu) scaled_.push_back(read(sample));
  return scaled_;
}

ImuSample SensorStates::read(ImuSample sample) const {
  if (active_ && params_.acc_scale) sample.acc = sample.acc.cwiseQuotient(Vec3::Ones() + now_.acc_scale);
  return sample;
}

void SensorStates::propagate(const StateMatrix& F, const ImuSample& from, const ImuSample& to, StateMatrix& P) {
  cross_ = (F * cross_).eval();
  if (!params_.acc_scale) return;
  // A scale factor that is off by s shows as a bias of s times the force.
  const Vec3 force = 0.5 * (from.acc + to.acc);
  Eigen::Matrix<double, kStateDim, 3> by_scale = F.middleCols<3>(block::b_a) * force.asDiagonal();
  by_scale.middleRows<3>(block::b_a).setZero();
  const StateMatrix mixed = cross_.middleCols<3>(kScale) * by_scale.transpose();
  const Mat3 scale = own_.block<3, 3>(kScale, kScale);
  P += mixed + mixed.transpose() + by_scale * scale * by_scale.transpose();
  cross_ += by_scale * own_.middleRows<3>(kScale);
}

SensorStates::Joint SensorStates::joint(const StateMatrix& P) const {
  Joint all;
  all.topLeftCorner<kStateDim, kStateDim>() = P;
  all.topRightCorner<kStateDim, kOwn>() = cross_;
  all.bottomLeftCorner<kOwn, kStateDim>() = cross_.transpose();
  all.bottomRightCorner<kOwn, kOwn>() = own_;
  return all;
}

// eq. IESKF-9.
/// A turn of the LiDAR by e on the IMU shows as a turn by R_e e of the pose, with a shift by what it moves the origin.
Eigen::Matrix<double, 6, SensorStates::kOwn> SensorStates::shown(const Mat3& R) const {
  Eigen::Matrix<double, 6, kOwn> D = Eigen::Matrix<double, 6, kOwn>::Zero();
  D.block<3, 3>(0, kRotation) = now_.T.R;
  D.block<3, 3>(3, kRotation) = R * hat(now_.T.p) * now_.T.R;
  D.block<3, 3>(3, kTranslation) = R;
  return D;
}

SensorStates::Rows SensorStates::rows(const SeenRows& seen, const Mat3& R) const {
  Rows C = Rows::Zero();
  C.leftCols<kStateDim>() = seen;
  C.topRightCorner<6, kOwn>() = shown(R);
  return C;
}

double SensorStates::squared_innovation(const StateMatrix& P, const SeenRows& seen, const Mat3& R, const SeenMatrix& A,
                                        const SeenVector& b, double weighted_sum) const {
  return aslio::squared_innovation<kSeenDim, kAll>(joint(P), rows(seen, R), A, b, weighted_sum);
}

StateVector SensorStates::step(const StateMatrix& P, const SeenRows& seen, const NavState& at, const StateVector& d,
                               const SeenMatrix& A, const SeenVector& b) {
  Eigen::Matrix<double, kAll, 1> from_prior;
  from_prior << d, log_so3(prior_.T.R.transpose() * now_.T.R), now_.T.p - prior_.T.p, now_.acc_scale - prior_.acc_scale;
  iterate_ = transported_covariance<kAll>(joint(P), d.head<3>());
  seen_ = rows(seen, at.R);
  const Eigen::Matrix<double, kAll, 1> delta = iteration_step<kSeenDim, kAll>(iterate_, seen_, A, b, from_prior);
  const Vector own = delta.tail<kOwn>();
  if (own.allFinite()) {
    now_.T.R = orthonormalised(now_.T.R * exp_so3(own.segment<3>(kRotation)));
    now_.T.p += own.segment<3>(kTranslation);
    now_.acc_scale += own.segment<3>(kScale);
  }
  return delta.head<kStateDim>();
}

StateMatrix SensorStates::posterior(const SeenMatrix& A_new, const SeenMatrix& A_all, HistoryCovariance rule) {
  const Joint all = posterior_covariance<kSeenDim, kAll>(iterate_, seen_, A_new, A_all, rule);
  own_ = all.bottomRightCorner<kOwn, kOwn>();
  cross_ = all.topRightCorner<kStateDim, kOwn>();
  if (!(own_.diagonal().minCoeff() >= 0)) return StateMatrix::Constant(std::numeric_limits<double>::quiet_NaN());
  return all.topLeftCorner<kStateDim, kStateDim>();
}

SensorEstimate SensorStates::estimate() const {
  const Vector sigma = own_.diagonal().cwiseMax(0.0).cwiseSqrt();
  SensorEstimate out;
  out.T_imu_lidar = now_.T;
  out.declared = declared_;
  out.sigma_rotation = sigma.segment<3>(kRotation);
  out.sigma_translation = sigma.segment<3>(kTranslation);
  out.acc_scale = now_.acc_scale;
  out.sigma_acc_scale = sigma.segment<3>(kScale);
  return out;
}

}  // namespace aslio::plugins
