// The filter algebra against textbook forms, and its Jacobians against central differences. (eq. IESKF-6)
#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>

#include "aslio/toolkit/information_lanes.hpp"
#include "aslio/toolkit/information_update.hpp"

using namespace aslio;

namespace {

StateMatrix some_covariance(double phase) {
  StateMatrix A;
  for (int i = 0; i < kStateDim; ++i) {
    for (int j = 0; j < kStateDim; ++j) A(i, j) = 0.1 * std::sin(phase + 1.3 * i + 0.7 * j + 0.11 * i * j);
  }
  return A * A.transpose() + 1e-3 * StateMatrix::Identity();
}

using PoseRows = Eigen::Matrix<double, 6, kStateDim>;

/// The pose alone is seen.
PoseRows pose_rows() { return PoseRows::Identity(); }

struct Rows {
  Eigen::MatrixXd H;  // n x 18
  Eigen::VectorXd z;
  double information = 900.0;
  PoseInformation sums;
};

Rows some_rows(int n, double phase, const Mat3& R) {
  Rows rows;
  rows.H = Eigen::MatrixXd::Zero(n, kStateDim);
  rows.z.resize(n);
  for (int i = 0; i < n; ++i) {
    const Vec3 p_I(3 * std::sin(phase + i), 2 * std::cos(1.7 * i), std::sin(0.3 * i * i));
    const Vec3 u = Vec3(std::sin(2.1 * i + phase), std::cos(0.9 * i), std::sin(0.4 * i + 1)).normalized();
    const double z = 0.02 * std::sin(5.0 * i + phase);
    rows.H.block<1, 3>(i, 0) = -u.transpose() * R * hat(p_I);
    rows.H.block<1, 3>(i, 3) = u.transpose();
    rows.z[i] = z;
    rows.sums.add(p_I, R.transpose(), u, z, rows.information);
  }
  return rows;
}

Eigen::MatrixXd gain(const StateMatrix& P, const Rows& rows) {
  const Eigen::MatrixXd S =
      rows.H * P * rows.H.transpose() + Eigen::MatrixXd::Identity(rows.z.size(), rows.z.size()) / rows.information;
  return P * rows.H.transpose() * S.inverse();
}

}  // namespace

TEST_CASE("the point-to-surface row is the derivative of the residual") {  // eq. IESKF-1
  NavState x;
  x.R = exp_so3(Vec3(0.4, -0.2, 0.9));
  x.p = Vec3(2, 1, -1);
  const Vec3 p_I(3, -1, 0.5);
  const Vec3 u = Vec3(0.3, 0.5, -0.8).normalized();
  const Vec3 q(1, 1, 1);
  const auto z = [&](const NavState& s) { return u.dot(s.R * p_I + s.p - q); };
  PoseInformation row;
  row.add(p_I, x.R.transpose(), u, 1.0, 1.0);  // b = h * z with z = 1, R = 1
  for (int i = 0; i < 6; ++i) {
    StateVector d = StateVector::Zero();
    d[i] = 1e-6;
    const double slope = (z(box_plus(x, d, false)) - z(box_plus(x, -d, false))) / 2e-6;
    CHECK(row.b[i] == Approx(slope).margin(1e-8));
  }
}

TEST_CASE("the iteration step equals the textbook Kalman step") {  // eqs. IESKF-4, IESKF-5
  const StateMatrix P = some_covariance(0.2);
  const Rows rows = some_rows(40, 0.5, exp_so3(Vec3(0.1, 0.2, 0.3)));
  StateVector d;
  for (int i = 0; i < kStateDim; ++i) d[i] = 0.01 * std::sin(2.0 * i);
  const Eigen::MatrixXd K = gain(P, rows);
  const StateVector expected = -K * rows.z - (StateMatrix::Identity() - K * rows.H) * d;
  const StateVector actual = iteration_step<6>(P, pose_rows(), rows.sums.A, rows.sums.b, d);
  CHECK((actual - expected).norm() < 1e-9);
}

// eq. IESKF-10.
TEST_CASE("the squared innovation of all residuals is that of the textbook") {
  const StateMatrix P = some_covariance(0.2);
  const Rows rows = some_rows(40, 0.5, exp_so3(Vec3(0.1, 0.2, 0.3)));
  const Eigen::MatrixXd covariance =
      rows.H * P * rows.H.transpose() + Eigen::MatrixXd::Identity(40, 40) / rows.information;
  const double expected = rows.z.dot(covariance.inverse() * rows.z);
  CHECK(rows.sums.weighted_sum == Approx(rows.information * rows.z.squaredNorm()));
  CHECK(squared_innovation<6>(P, pose_rows(), rows.sums.A, rows.sums.b, rows.sums.weighted_sum) == Approx(expected));
}

TEST_CASE("posterior covariance: without history every rule gives (I - KH) P, singular information is no problem") {
  const StateMatrix P = some_covariance(1.0);
  for (const int n : {40, 2, 0}) {
    const Rows rows = some_rows(n, 0.1, Mat3::Identity());
    StateMatrix expected = P;
    if (n > 0) expected = (StateMatrix::Identity() - gain(P, rows) * rows.H) * P;
    const Mat6 A = rows.sums.A;
    for (const auto rule : {HistoryCovariance::joseph, HistoryCovariance::new_only, HistoryCovariance::all}) {
      CHECK((posterior_covariance<6>(P, pose_rows(), A, A, rule) - expected).cwiseAbs().maxCoeff() < 1e-10);
    }
  }
}

TEST_CASE("posterior covariance with history: the Joseph form of the gain that was used") {  // eq. HIS-3
  const StateMatrix P = some_covariance(0.7);
  const Rows fresh = some_rows(30, 0.3, Mat3::Identity());
  const Rows old = some_rows(25, 2.3, Mat3::Identity());
  const Mat6 A_new = fresh.sums.A;
  const Mat6 A_all = A_new + 0.4 * old.sums.A;
  // K_new = P_c S h_new / R with S from all residuals; only fresh residuals carry noise.
  const Mat6 S = (Mat6::Identity() + A_all * P.topLeftCorner<6, 6>()).inverse();
  const Eigen::MatrixXd K = P.leftCols<6>() * S * fresh.H.leftCols<6>().transpose() * fresh.information;
  const StateMatrix X = StateMatrix::Identity() - K * fresh.H;
  const StateMatrix expected = X * P * X.transpose() + K * K.transpose() / fresh.information;
  CHECK((posterior_covariance<6>(P, pose_rows(), A_new, A_all, HistoryCovariance::joseph) - expected)
            .cwiseAbs()
            .maxCoeff() < 1e-12);
  // Re-used evidence must not make the filter more certain than the fresh points alone allow at best.
  const StateMatrix all = posterior_covariance<6>(P, pose_rows(), A_new, A_all, HistoryCovariance::all);
  const StateMatrix joseph = posterior_covariance<6>(P, pose_rows(), A_new, A_all, HistoryCovariance::joseph);
  CHECK(all.topLeftCorner<6, 6>().trace() < joseph.topLeftCorner<6, 6>().trace());
}

TEST_CASE("posterior covariance: what is known exactly keeps a variance of 0, whatever the rounding") {
  // The length of g where it points straight down: a variance of 0 that rounding made -5.6e-42 refused every update.
  StateMatrix P = some_covariance(0.7);
  for (const double known : {0.0, -1e-42, -1e-20}) {
    const int at = block::g + 2;
    P.row(at).setConstant(known);
    P.col(at).setConstant(known);
    const Mat6 A = some_rows(30, 0.3, Mat3::Identity()).sums.A;
    for (const auto rule : {HistoryCovariance::joseph, HistoryCovariance::new_only, HistoryCovariance::all}) {
      const StateMatrix posterior = posterior_covariance<6>(P, pose_rows(), A, A, rule);
      CHECK(posterior.diagonal().minCoeff() >= 0.0);
      CHECK(posterior(at, at) == 0.0);
    }
  }
  P(block::g + 2, block::g + 2) = -1e-6;  // an error, not rounding
  CHECK(posterior_covariance<6>(P, pose_rows(), Mat6::Zero(), Mat6::Zero(), HistoryCovariance::all)(
            block::g + 2, block::g + 2) < 0.0);
}

TEST_CASE("moments of the lag give the normal equations of rows that see velocity and rate too") {  // eq. DSK-3
  // h = [h_pose, -tau h_pose] C for every row, summed the long way.
  const StateMatrix P = some_covariance(0.4);
  const Mat3 R = exp_so3(Vec3(0.3, -0.1, 0.2));
  SeenRows C = SeenRows::Zero();
  for (int i = 0; i < kSeenDim; ++i) {
    for (int j = 0; j < kStateDim; ++j) C(i, j) = std::sin(1.0 + 0.7 * i + 1.9 * j);
  }
  constexpr int n = 40;
  constexpr double information = 900.0;
  WindowInformation sums;
  Eigen::MatrixXd H(n, kStateDim);
  Eigen::VectorXd z(n);
  for (int i = 0; i < n; ++i) {
    const Vec3 p_I(3 * std::sin(i), 2 * std::cos(1.7 * i), std::sin(0.3 * i * i));
    const Vec3 u = Vec3(std::sin(2.1 * i), std::cos(0.9 * i), std::sin(0.4 * i + 1)).normalized();
    const double tau = 0.1 * i / n;
    z[i] = 0.02 * std::sin(5.0 * i);
    Eigen::Matrix<double, 1, kSeenDim> h;
    h << -u.transpose() * R * hat(p_I), u.transpose(), tau * u.transpose() * R * hat(p_I), -tau * u.transpose();
    H.row(i) = h * C;
    sums.add_late(p_I, R.transpose(), u, z[i], information, tau);
  }
  Eigen::Matrix<double, kSeenDim, kSeenDim> A;
  Eigen::Matrix<double, kSeenDim, 1> b;
  A << sums.A, -sums.A1, -sums.A1.transpose(), sums.A2;
  b << sums.b, -sums.b1;
  const Eigen::MatrixXd S = H * P * H.transpose() + Eigen::MatrixXd::Identity(n, n) / information;
  const Eigen::MatrixXd K = P * H.transpose() * S.inverse();
  StateVector d;
  for (int i = 0; i < kStateDim; ++i) d[i] = 0.01 * std::sin(2.0 * i);
  const StateVector expected = -K * z - (StateMatrix::Identity() - K * H) * d;
  CHECK((iteration_step<kSeenDim>(P, C, A, b, d) - expected).norm() < 1e-8);
  const StateMatrix posterior = (StateMatrix::Identity() - K * H) * P;
  for (const auto rule : {HistoryCovariance::joseph, HistoryCovariance::new_only, HistoryCovariance::all}) {
    CHECK((posterior_covariance<kSeenDim>(P, C, A, A, rule) - posterior).cwiseAbs().maxCoeff() < 1e-8);
  }
}

TEST_CASE("the transported prior is what the linearisation of x [-] x_hat says") {  // eq. IESKF-3
  const NavState reference;
  StateVector offset = StateVector::Zero();
  offset.head<3>() = Vec3(0.3, -0.2, 0.5);
  const NavState x = box_plus(reference, offset, false);
  // J = d((x [+] delta) [-] x_hat)/d delta by central differences; transported P = J^-1 P J^-T.
  StateMatrix J;
  for (int i = 0; i < kStateDim; ++i) {
    StateVector d = StateVector::Zero();
    d[i] = 1e-6;
    J.col(i) = (box_minus(box_plus(x, d, false), reference) - box_minus(box_plus(x, -d, false), reference)) / 2e-6;
  }
  const StateMatrix P = some_covariance(0.4);
  const StateMatrix J_inverse = J.inverse();
  const StateMatrix expected = J_inverse * P * J_inverse.transpose();
  CHECK((transported_covariance(P, offset.head<3>()) - expected).cwiseAbs().maxCoeff() < 1e-7);
}

TEST_CASE("gravity on the sphere keeps its length") {  // eq. IESKF-2
  NavState x;
  StateVector d = StateVector::Zero();
  d.segment<3>(block::g) = Vec3(0.5, -0.3, 0.2);
  CHECK(box_plus(x, d, true).g.norm() == Approx(kStandardGravity).epsilon(1e-12));
  CHECK(box_plus(x, d, false).g.norm() != Approx(kStandardGravity).epsilon(1e-4));
}

TEST_CASE("rows summed up in lanes are rows summed up one by one") {  // eq. IESKF-1
  const Mat3 Rt = exp_so3(Vec3(0.4, -0.2, 0.9)).transpose();
  for (const int n : {0, 1, 7, 8, 9, 61}) {
    PoseInformation one_by_one;
    InformationLanes lanes(Rt);
    for (int i = 0; i < n; ++i) {
      const Vec3 p_I(3 * std::sin(1.3 * i), 2 * std::cos(1.7 * i), std::sin(0.3 * i * i));
      const Vec3 u = Vec3(std::sin(2.1 * i), std::cos(0.9 * i), std::sin(0.4 * i + 1)).normalized();
      const double z = 0.02 * std::sin(5.0 * i), information = 900.0 + i, share = 0.1 + 0.01 * i;
      one_by_one.add(p_I, Rt, share * u, z, information);
      lanes.add(p_I, u, z, information, share);
    }
    const PoseInformation sum = lanes.total();
    CHECK(sum.accepted == static_cast<std::size_t>(n));
    CHECK((sum.A - one_by_one.A).norm() <= 1e-13 * one_by_one.A.norm());
    CHECK((sum.b - one_by_one.b).norm() <= 1e-12 * one_by_one.b.norm());
    CHECK(sum.squared_sum == Approx(one_by_one.squared_sum));
    CHECK(sum.weighted_sum == Approx(one_by_one.weighted_sum));
    CHECK(sum.A == sum.A.transpose());
  }
}
