#include "estimators/smoothing_pass.hpp"

#include <Eigen/LU>

namespace aslio::plugins {

/// eq. SMO-2: predict, then update with rows that see both ends. P_y is the covariance of the end's error with what is
/// seen, y = (pose at the begin, pose at the end).
void SmoothingPass::forward(const ErrorBelief& before, const SliceEquations& slice, Slice& out) {
  const StateMatrix FP = slice.F * before.P;
  StateMatrix P = FP * slice.F.transpose() + slice.Q;
  P = (0.5 * (P + P.transpose())).eval();
  const StateVector predicted = slice.F * before.mean - slice.d;

  Eigen::Matrix<double, kStateDim, kEndsDim> P_y;
  P_y << FP.leftCols<6>(), P.leftCols<6>();
  EndsMatrix P_yy;
  P_yy.topLeftCorner<6, 6>() = before.P.topLeftCorner<6, 6>();
  P_yy.topRightCorner<6, 6>() = FP.topLeftCorner<6, 6>().transpose();
  P_yy.bottomRows<6>() = P_y.topRows<6>();
  EndsVector y;
  y << before.mean.head<6>(), predicted.head<6>();

  const EndsMatrix S_inverse = EndsMatrix::Identity() + slice.A * P_yy;
  const EndsMatrix S = Eigen::PartialPivLU<EndsMatrix>(S_inverse).inverse();
  const Eigen::Matrix<double, kStateDim, kEndsDim> gain = P_y * S;
  const EndsVector off = slice.b + slice.A * y;
  out.taken = gain * slice.A;
  out.pull = S * off;
  out.filtered.mean = predicted - gain * off;
  out.filtered.P = P - out.taken * P_y.transpose();
  out.filtered.P = (0.5 * (out.filtered.P + out.filtered.P.transpose())).eval();
  const double squares = slice.weighted_sum + 2.0 * y.dot(slice.b) + y.dot(slice.A * y);
  out.squared_innovation = squares - off.dot(P_yy * out.pull);  // eq. IESKF-10
}

void SmoothingPass::run(const ErrorBelief& first, const std::vector<SliceEquations>& slices, std::size_t count) {
  if (slices_.size() < count) slices_.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    forward(i == 0 ? first : slices_[i - 1].filtered, slices[i], slices_[i]);
  }
  // eq. SMO-3: lambda is what all later slices say of the error at the end of slice i.
  StateVector lambda = StateVector::Zero();
  for (std::size_t i = count; i-- > 0;) {
    Slice& slice = slices_[i];
    slice.smoothed = slice.filtered.mean - slice.filtered.P * lambda;
    const EndsVector seen = slice.pull - slice.taken.transpose().lazyProduct(lambda);
    lambda.head<6>() += seen.tail<6>();
    lambda = slices[i].F.transpose().lazyProduct(lambda).eval();
    lambda.head<6>() += seen.head<6>();
  }
  begin_ = first.mean - first.P * lambda;
}

}  // namespace aslio::plugins
