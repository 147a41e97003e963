#pragma once
/// What a filter may estimate of the sensor file, beside its state (docs/equations.md IESKF-9).

#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "aslio/config/binder.hpp"
#include "aslio/core/sensor.hpp"
#include "aslio/stages/estimator.hpp"
#include "aslio/toolkit/information_update.hpp"

namespace aslio::plugins {

/// Constants of the sensors that are estimated together with the state: the rotation and the translation of
/// T_imu_lidar, and the scale factors of the accelerometer. Their covariance, and the one with the state, are kept
/// here, so that a filter that estimates none of them has the size and the cost of its own state.
class SensorStates {
 public:
  enum class Extrinsic : std::uint8_t { none, rotation, full };
  struct Params {
    Extrinsic extrinsic = Extrinsic::none;
    double sigma_extrinsic_deg = 0.5;  ///< of each axis at the start
    double sigma_extrinsic_m = 0.01;   ///< of each axis at the start
    bool acc_scale = false;
    double sigma_acc_scale = 0.01;  ///< of each axis at the start
    bool any() const { return extrinsic != Extrinsic::none || acc_scale; }
  };
  static void describe(config::Binder& b, Params& p);

  SensorStates(const Params& params, const SensorModel& sensor) : params_(params), declared_(sensor.T_imu_lidar) {
    reset(false);
  }
  bool active() const { return active_; }
  /// As the sensor file says, with the covariance of the start. A start in motion leaves the tilt and the velocity
  /// open, which an error of the sensors resembles: then nothing is estimated.
  void reset(bool at_rest);
  /// An empty map: what it will hold is placed by the mounting as it is now, so that an error of the mounting is one of
  /// the pose `at` and, where `gravity` is estimated, of gravity in the frame of the map. Adds that to `P`, the
  /// covariance of the state at the start.
  void start_map(const NavState& at, bool gravity, StateMatrix& P);
  /// The state is not believed: it says nothing of the sensors any more.
  void forget_state() { cross_.setZero(); }
  /// Errors of g turn with it. eq. IESKF-14.
  void turn_with_gravity(const Vec3& from, const Vec3& to) {
    const Mat3 turn = Eigen::Quaterniond::FromTwoVectors(from, to).toRotationMatrix();
    cross_.middleRows<3>(block::g) = (turn * cross_.middleRows<3>(block::g)).eval();
  }

  const Pose& T_imu_lidar() const { return now_.T; }
  /// The samples with the scale factors of the accelerometer taken out; `imu` itself where none are estimated. Valid
  /// until the next call.
  std::span<const ImuSample> read(std::span<const ImuSample> imu);
  ImuSample read(ImuSample sample) const;
  /// Over one interval between two samples of read(), after the motion model has taken P over it; `F` is its
  /// transition.
  void propagate(const StateMatrix& F, const ImuSample& from, const ImuSample& to, StateMatrix& P);

  /// restore() goes back to here: values and covariances.
  void begin() {
    prior_ = now_;
    prior_own_ = own_;
    prior_cross_ = cross_;
  }
  void restore() {
    now_ = prior_;
    own_ = prior_own_;
    cross_ = prior_cross_;
  }
  /// eq. IESKF-10 with what is estimated here. `R` is R_W_I of the prior.
  double squared_innovation(const StateMatrix& P, const SeenRows& seen, const Mat3& R, const SeenMatrix& A,
                            const SeenVector& b, double weighted_sum) const;
  /// One iteration from the iterate `at`, which is `d` from the prior: moves what is estimated here and returns the
  /// step of the state. `P` is the prior's covariance, `seen` what the points see of the state.
  StateVector step(const StateMatrix& P, const SeenRows& seen, const NavState& at, const StateVector& d,
                   const SeenMatrix& A, const SeenVector& b);
  /// Covariance of the state after the last step(), by the rule; takes on its own. Not finite where either is none.
  StateMatrix posterior(const SeenMatrix& A_new, const SeenMatrix& A_all, HistoryCovariance rule);

  /// What is known now.
  SensorEstimate estimate() const;

 private:
  static constexpr int kAll = kWithSensors,
                       kOwn = kAll - kStateDim;  ///< rotation [rad], translation [m], scale of the accelerometer
  using Vector = Eigen::Matrix<double, kOwn, 1>;
  using Own = Eigen::Matrix<double, kOwn, kOwn>;
  using Cross = Eigen::Matrix<double, kStateDim, kOwn>;
  using Joint = Eigen::Matrix<double, kAll, kAll>;
  using Rows = Eigen::Matrix<double, kSeenDim, kAll>;
  struct Values {
    Pose T;
    Vec3 acc_scale = Vec3::Zero();
  };

  Joint joint(const StateMatrix& P) const;
  Eigen::Matrix<double, 6, kOwn> shown(const Mat3& R) const;
  Rows rows(const SeenRows& seen, const Mat3& R) const;

  Params params_;
  bool active_ = false;
  Pose declared_;
  Values now_, prior_;
  Own own_ = Own::Zero(), prior_own_ = Own::Zero();
  Cross cross_ = Cross::Zero(), prior_cross_ = Cross::Zero();  ///< with the state
  Joint iterate_ = Joint::Zero();                              ///< covariance that the last step() started from
  Rows seen_ = Rows::Zero();                                   ///< of the last step()
  std::vector<ImuSample> scaled_;
};

}  // namespace aslio::plugins
