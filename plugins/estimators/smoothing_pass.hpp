#pragma once
/// The linear part of a fixed-lag smoother: one pass forward and one back over a chain of slices (docs/equations.md
/// SMO-2 to SMO-4).

#include <vector>

#include "aslio/stages/motion.hpp"

namespace aslio::plugins {

/// What a slice sees of its two ends: the errors (theta, p) of the pose at its begin, then of that at its end.
inline constexpr int kEndsDim = 12;
using EndsVector = Eigen::Matrix<double, kEndsDim, 1>;
using EndsMatrix = Eigen::Matrix<double, kEndsDim, kEndsDim>;

/// One slice for the errors e of its ends about the current iterate: e_end = F e_begin - d + w, cov(w) = Q, and rows
/// z + h (e_begin, e_end) = n with A = sum h^T h / R, b = sum h^T z / R.
struct SliceEquations {
  StateMatrix F = StateMatrix::Identity();
  StateMatrix Q = StateMatrix::Zero();
  StateVector d = StateVector::Zero();
  EndsMatrix A = EndsMatrix::Zero();
  EndsVector b = EndsVector::Zero();
  double weighted_sum = 0;  ///< sum z^2 / R
};

/// A Gaussian belief of an error state.
struct ErrorBelief {
  StateVector mean = StateVector::Zero();
  StateMatrix P = StateMatrix::Zero();
};

/// Kalman filter forward, then the smoother of Rauch, Tung and Striebel back, in the form of Bryson and Frazier: no
/// covariance is inverted, so states that are not estimated (variance 0) need no special case. Equal to least squares
/// over all slices at once.
class SmoothingPass {
 public:
  /// eqs. SMO-2, SMO-3. `first` is the belief of the begin of slice 0. Storage is reused.
  void run(const ErrorBelief& first, const std::vector<SliceEquations>& slices, std::size_t count);

  /// Smoothed mean at the begin of slice 0, and at the end of slice i.
  const StateVector& begin() const { return begin_; }
  const StateVector& end(std::size_t i) const { return slices_[i].smoothed; }
  /// What slices 0 .. i alone tell of the end of slice i.
  const ErrorBelief& filtered(std::size_t i) const { return slices_[i].filtered; }
  /// Squared innovation of the rows of slice i, given the slices before it.
  double squared_innovation(std::size_t i) const { return slices_[i].squared_innovation; }

 private:
  struct Slice {
    ErrorBelief filtered;
    Eigen::Matrix<double, kStateDim, kEndsDim> taken;  ///< K A: what the update takes of an error of the ends
    EndsVector pull;                                   ///< S (b + A y)
    StateVector smoothed;
    double squared_innovation = 0;
  };

  void forward(const ErrorBelief& before, const SliceEquations& slice, Slice& out);

  std::vector<Slice> slices_;
  StateVector begin_ = StateVector::Zero();
};

}  // namespace aslio::plugins
