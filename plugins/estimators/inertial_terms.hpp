#pragma once
/// The rows of a fixed-lag smoother over states (theta, p, v, b_w, b_a): what the IMU, a registration, and all that
/// came before say of them.

#include "aslio/core/types.hpp"
#include "estimators/preintegration.hpp"

namespace aslio::plugins {

/// Unknowns of a state.
inline constexpr int kNodeDim = 15;
using Vec15 = Eigen::Matrix<double, kNodeDim, 1>;
using Mat15 = Eigen::Matrix<double, kNodeDim, kNodeDim>;

/// x [+] xi: right perturbation of R, the rest added.
NavState moved(const NavState& x, const Vec15& xi);
/// x [-] reference.
Vec15 difference(const NavState& x, const NavState& reference);

/// Rows that depend on one state of a chain, or on two that follow each other.
class StateTerm {
 public:
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kNodeDim, 1>;
  using Slopes = Eigen::Matrix<double, Eigen::Dynamic, kNodeDim, 0, kNodeDim, kNodeDim>;
  /// What the term says at two states: rows, weighted to unit variance, and their slopes for x [+] xi of each.
  struct At {
    Rows r;
    Slopes J_i, J_j;
  };

  StateTerm(int rows, int node, bool two) : rows_(rows), node_(node), two_(two) {}
  virtual ~StateTerm() = default;
  int rows() const { return rows_; }
  /// The state, and whether the next one counts, too.
  int node() const { return node_; }
  bool two() const { return two_; }
  /// The oldest state has left.
  void shift() { --node_; }
  /// `j` is null unless two().
  At at(const NavState& i, const NavState* j) const;

 protected:
  /// Everything is zero before.
  virtual void fill(const NavState& i, const NavState* j, At& out) const = 0;

 private:
  int rows_, node_;
  bool two_;
};

/// U (x [-] reference) + offset. eq. LAG-3
class PriorTerm final : public StateTerm {
 public:
  PriorTerm(int node, const NavState& reference, const Mat15& U, const Vec15& offset)
      : StateTerm(kNodeDim, node, false), reference_(reference), U_(U), offset_(offset) {}

 private:
  void fill(const NavState& i, const NavState* j, At& out) const override;
  NavState reference_;
  Mat15 U_;
  Vec15 offset_;
};

/// The motion from one state to the next. eq. LAG-1
class InertialTerm final : public StateTerm {
 public:
  InertialTerm(int first, const Preintegration& motion, const Vec3& gravity, const InertialNoise& noise);

 private:
  void fill(const NavState& i, const NavState* j, At& out) const override;
  Preintegration motion_;
  Vec3 g_;
  Preintegration::Mat9 whiten_;
  double whiten_gyro_bias_, whiten_acc_bias_;
};

/// A pose that was found, to so many rad and m. eq. LAG-2
class PoseTerm final : public StateTerm {
 public:
  PoseTerm(int node, const Pose& found, double sigma_rotation, double sigma_position)
      : StateTerm(6, node, false), found_(found), rotation_(1.0 / sigma_rotation), position_(1.0 / sigma_position) {}

 private:
  void fill(const NavState& i, const NavState* j, At& out) const override;
  Pose found_;
  double rotation_, position_;
};

}  // namespace aslio::plugins
