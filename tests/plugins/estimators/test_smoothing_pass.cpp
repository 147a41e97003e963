// The pass of the smoother against least squares over all slices at once.
#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <random>

#include "estimators/smoothing_pass.hpp"

using namespace aslio;
using namespace aslio::plugins;

namespace {

/// A chain of slices drawn at random: every state is driven and seen, some through others.
struct Chain {
  ErrorBelief first;
  std::vector<SliceEquations> slices;

  explicit Chain(std::size_t count, std::uint32_t seed) : random(seed) {
    first.mean = vector<kStateDim>();
    first.P = covariance(1.0);
    for (std::size_t i = 0; i < count; ++i) {
      SliceEquations slice;
      slice.F += 0.3 * matrix<kStateDim, kStateDim>();
      slice.Q = covariance(0.2);
      slice.d = vector<kStateDim>();
      rows(slice, i % 3 == 1 ? 2 : 20);  // too few for a pose now and then
      slices.push_back(slice);
    }
  }

 private:
  template <int R, int C>
  Eigen::Matrix<double, R, C> matrix() {
    std::normal_distribution<double> normal;
    return Eigen::Matrix<double, R, C>::NullaryExpr([&]() { return normal(random); });
  }
  template <int R>
  Eigen::Matrix<double, R, 1> vector() {
    return matrix<R, 1>();
  }
  StateMatrix covariance(double scale) {
    const StateMatrix root = matrix<kStateDim, kStateDim>();
    return scale * (StateMatrix::Identity() + 0.05 * root * root.transpose());
  }
  void rows(SliceEquations& slice, int count) {
    for (int i = 0; i < count; ++i) {
      const EndsVector h = vector<kEndsDim>();
      const double z = vector<1>()[0], information = 4.0;
      slice.A += information * h * h.transpose();
      slice.b += information * z * h;
      slice.weighted_sum += information * z * z;
    }
  }

  std::mt19937 random;
};

/// Unknowns of all slices, begin first, and the inverse of their information.
struct Batch {
  Eigen::VectorXd x;
  Eigen::MatrixXd covariance;

  Batch(const Chain& chain, std::size_t count) {
    const Eigen::Index n = kStateDim, size = n * static_cast<Eigen::Index>(count + 1);
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(size, size);
    Eigen::VectorXd b = Eigen::VectorXd::Zero(size);
    const StateMatrix known = chain.first.P.inverse();
    A.topLeftCorner(n, n) += known;
    b.head(n) += known * chain.first.mean;
    for (std::size_t i = 0; i < count; ++i) {
      const SliceEquations& slice = chain.slices[i];
      const Eigen::Index at = n * static_cast<Eigen::Index>(i);
      Eigen::MatrixXd J(n, 2 * n);  // e_end - F e_begin + d = w
      J << -slice.F, StateMatrix::Identity();
      const StateMatrix certain = slice.Q.inverse();
      A.block(at, at, 2 * n, 2 * n) += J.transpose() * certain * J;
      b.segment(at, 2 * n) -= J.transpose() * certain * slice.d;
      Eigen::MatrixXd seen = Eigen::MatrixXd::Zero(kEndsDim, 2 * n);
      seen.topLeftCorner(6, 6).setIdentity();
      seen.block(6, n, 6, 6).setIdentity();
      A.block(at, at, 2 * n, 2 * n) += seen.transpose() * slice.A * seen;
      b.segment(at, 2 * n) -= seen.transpose() * slice.b;
    }
    const Eigen::LDLT<Eigen::MatrixXd> solver(A);
    x = solver.solve(b);
    covariance = solver.solve(Eigen::MatrixXd::Identity(size, size));
  }
  StateVector at(std::size_t i) const { return x.segment<kStateDim>(kStateDim * static_cast<Eigen::Index>(i)); }
};

}  // namespace

TEST_CASE("smoothing over slices is least squares over all of them at once") {  // eqs. SMO-2, SMO-3
  for (const std::size_t count : {1U, 2U, 7U, 12U}) {
    CAPTURE(count);
    const Chain chain(count, 7 + static_cast<std::uint32_t>(count));
    SmoothingPass pass;
    pass.run(chain.first, chain.slices, count);
    const Batch batch(chain, count);
    CHECK((pass.begin() - batch.at(0)).norm() < 1e-9 * batch.x.norm());
    for (std::size_t i = 0; i < count; ++i) CHECK((pass.end(i) - batch.at(i + 1)).norm() < 1e-9 * batch.x.norm());
    const StateMatrix last = batch.covariance.bottomRightCorner<kStateDim, kStateDim>();
    CHECK((pass.filtered(count - 1).P - last).norm() < 1e-9 * last.norm());
  }
}

TEST_CASE("what has left the lag stays in the belief of its end") {  // eq. SMO-4
  const Chain chain(9, 3);
  SmoothingPass all, early, late;
  all.run(chain.first, chain.slices, 9);
  early.run(chain.first, chain.slices, 4);
  const std::vector<SliceEquations> rest(chain.slices.begin() + 4, chain.slices.end());
  late.run(early.filtered(3), rest, rest.size());
  CHECK((late.begin() - all.end(3)).norm() < 1e-9);
  for (std::size_t i = 0; i < rest.size(); ++i) CHECK((late.end(i) - all.end(i + 4)).norm() < 1e-9);
  CHECK((late.filtered(4).P - all.filtered(8).P).norm() < 1e-9);
}

TEST_CASE("smoothing leaves alone what is known exactly, and slices without rows follow the motion") {
  Chain chain(5, 11);
  constexpr int fixed = block::d;
  chain.first.P.row(fixed).setZero();
  chain.first.P.col(fixed).setZero();
  chain.first.mean.setZero();
  for (SliceEquations& slice : chain.slices) {
    slice.F.row(fixed).setZero();
    slice.F(fixed, fixed) = 1.0;
    slice.Q.row(fixed).setZero();
    slice.Q.col(fixed).setZero();
    slice.d[fixed] = 0;
  }
  SmoothingPass pass;
  pass.run(chain.first, chain.slices, 5);
  CHECK(pass.begin()[fixed] == 0.0);
  for (std::size_t i = 0; i < 5; ++i) {
    CHECK(pass.end(i)[fixed] == 0.0);
    CHECK(pass.end(i).allFinite());
    CHECK(pass.end(i).norm() > 0.1);
  }
  for (SliceEquations& slice : chain.slices) {
    slice.A.setZero();
    slice.b.setZero();
  }
  pass.run(chain.first, chain.slices, 5);
  StateVector e = chain.first.mean;
  CHECK(pass.begin() == e);
  for (std::size_t i = 0; i < 5; ++i) {
    e = (chain.slices[i].F * e - chain.slices[i].d).eval();
    CHECK((pass.end(i) - e).norm() < 1e-12 * (1 + e.norm()));
  }
}

TEST_CASE("the squared innovation of a slice counts its rows once") {  // eq. IESKF-10
  const Chain chain(3, 5);
  SmoothingPass pass;
  pass.run(chain.first, chain.slices, 3);
  // The long way, for the last slice: rows from A = H^T R^-1 H by its square root.
  const SliceEquations& slice = chain.slices[2];
  const ErrorBelief& before = pass.filtered(1);
  Eigen::Matrix<double, kEndsDim, kStateDim> of_begin = Eigen::Matrix<double, kEndsDim, kStateDim>::Zero();
  of_begin.topRows<6>() = StateMatrix::Identity().topRows<6>();
  of_begin.bottomRows<6>() = slice.F.topRows<6>();
  EndsMatrix of_noise = EndsMatrix::Zero();
  of_noise.bottomRightCorner<6, 6>() = slice.Q.topLeftCorner<6, 6>();
  const EndsMatrix P_yy = of_begin * before.P * of_begin.transpose() + of_noise;
  EndsVector y = of_begin * before.mean;
  y.tail<6>() -= slice.d.head<6>();
  const Eigen::LLT<EndsMatrix> root(slice.A);
  const EndsMatrix H = root.matrixU();
  const EndsVector z = H.transpose().fullPivLu().solve(slice.b);
  const EndsVector innovation = z + H * y;
  const EndsMatrix spread = H * P_yy * H.transpose() + EndsMatrix::Identity();
  const double unexplained = slice.weighted_sum - z.squaredNorm();  // what no pose removes
  CHECK(pass.squared_innovation(2) ==
        Approx(innovation.dot(spread.llt().solve(innovation)) + unexplained).epsilon(1e-8));
}
