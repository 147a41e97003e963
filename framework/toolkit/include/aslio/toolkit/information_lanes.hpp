#pragma once
/// Rows of a pose summed up eight at a time, which a compiler turns into vector instructions: the sum is a large part
/// of an update.

#include <array>

#include "aslio/toolkit/information_update.hpp"
#include "aslio/toolkit/point_lanes.hpp"

namespace aslio {

/// The same sums as PoseInformation::add() row by row, but for rounding. Each row goes to the next lane in turn and the
/// lanes are added in their order: the result depends on the order of the rows alone.
class InformationLanes {
 public:
  /// `R_transposed` of the pose at which all rows are taken.
  explicit InformationLanes(const Mat3& R_transposed) : Rt_(R_transposed) {}

  /// One row z = h(x): h = share [(p_I x R^T u)^T, u^T], information 1/R.
  void add(const Vec3& p_I, const Vec3& u, double z, double information, double share = 1.0) {
    for (int axis = 0; axis < 3; ++axis) {
      p_[slot(axis)][lane_] = p_I[axis];
      u_[slot(axis)][lane_] = u[axis];
    }
    z_[lane_] = z;
    information_[lane_] = information;
    share_[lane_] = share;
    ++accepted_;
    if (++lane_ == kWidth) sum_up();
  }

  /// Of all rows so far.
  PoseInformation total() {
    // Lanes that are not taken keep old rows, which must count for nothing.
    for (; lane_ > 0 && lane_ < kWidth; ++lane_) z_[lane_] = information_[lane_] = 0;
    if (lane_ == kWidth) sum_up();
    PoseInformation out;
    std::size_t k = 0;
    for (int c = 0; c < 6; ++c) {
      for (int r = c; r < 6; ++r) out.A(r, c) = out.A(c, r) = across(A_[k++]);
      out.b[c] = across(b_[slot(c)]);
    }
    out.squared_sum = across(squared_);
    out.weighted_sum = across(weighted_);
    out.accepted = accepted_;
    return out;
  }

 private:
  static constexpr std::size_t kWidth = PointLanes::kWidth;
  using Lanes = PointLanes::Lane;

  static constexpr std::size_t slot(int i) { return static_cast<std::size_t>(i); }
  static double across(const Lanes& lanes) {
    double sum = 0;
    for (const double lane : lanes) sum += lane;
    return sum;
  }

  void sum_up() {
    std::array<Lanes, 6> h;
    std::array<Lanes, 3> v;  // R^T u
    for (std::size_t i = 0; i < 3; ++i) {
      const double x = Rt_(static_cast<int>(i), 0), y = Rt_(static_cast<int>(i), 1), w = Rt_(static_cast<int>(i), 2);
      for (std::size_t l = 0; l < kWidth; ++l) v[i][l] = x * u_[0][l] + y * u_[1][l] + w * u_[2][l];
    }
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
      for (std::size_t l = 0; l < kWidth; ++l) {
        h[i][l] = share_[l] * (p_[j][l] * v[k][l] - p_[k][l] * v[j][l]);
        h[3 + i][l] = share_[l] * u_[i][l];
      }
    }
    std::size_t n = 0;
    for (std::size_t c = 0; c < 6; ++c) {
      Lanes weighted;
      for (std::size_t l = 0; l < kWidth; ++l) weighted[l] = information_[l] * h[c][l];
      for (std::size_t r = c; r < 6; ++r, ++n) {
        for (std::size_t l = 0; l < kWidth; ++l) A_[n][l] += weighted[l] * h[r][l];
      }
      for (std::size_t l = 0; l < kWidth; ++l) b_[c][l] += weighted[l] * z_[l];
    }
    for (std::size_t l = 0; l < kWidth; ++l) {
      squared_[l] += z_[l] * z_[l];
      weighted_[l] += z_[l] * z_[l] * information_[l];
    }
    lane_ = 0;
  }

  Mat3 Rt_;
  std::size_t lane_ = 0, accepted_ = 0;
  std::array<Lanes, 3> p_{}, u_{};
  Lanes z_{}, information_{}, share_{};
  std::array<Lanes, 21> A_{};  ///< lower triangle, by column
  std::array<Lanes, 6> b_{};
  Lanes squared_{}, weighted_{};
};

}  // namespace aslio
