#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <cmath>

#include "aslio/core/errors.hpp"
#include "aslio/evaluation/alignment.hpp"
#include "aslio/evaluation/statistics.hpp"
#include "evaluation/paths.hpp"

namespace {

using namespace aslio;
using namespace aslio::evaluation;

/// Pairs whose estimate is T^-1 times the reference.
std::vector<PosePair> pairs_of(const std::vector<Vec3>& reference, const Pose& T) {
  std::vector<PosePair> pairs;
  for (const Vec3& p : reference) {
    const Pose truth{Mat3::Identity(), p};
    pairs.push_back({static_cast<TimeNs>(pairs.size()), T.inverse() * truth, truth});
  }
  return pairs;
}

std::vector<double> ones(const std::vector<PosePair>& pairs) { return std::vector<double>(pairs.size(), 1.0); }

double cost(const Pose& A, const std::vector<PosePair>& pairs, const std::vector<double>& weights) {
  double sum = 0.0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    sum += weights[i] * (A * pairs[i].estimate.p - pairs[i].reference.p).squaredNorm();
  }
  return sum;
}

const std::vector<Vec3> kCloud = {{0, 0, 0}, {3, 0, 0.5}, {3, 4, -1}, {-1, 2, 2}, {0.5, -2, 1}};

}  // namespace

TEST_CASE("se3 finds the transform it was given, also for planar positions") {  // eq. EVAL-4
  const Pose T{exp_so3(Vec3(0.4, -1.0, 2.0)), Vec3(10, -20, 3)};
  std::vector<Vec3> planar = kCloud;
  for (Vec3& p : planar) p.z() = 0.0;
  for (const auto& cloud : {kCloud, planar}) {
    const auto pairs = pairs_of(cloud, T);
    const Pose A = align(Alignment::se3, pairs, ones(pairs));
    CHECK((A.R - T.R).norm() < 1e-13);
    CHECK((A.p - T.p).norm() < 1e-12);
    CHECK(A.R.determinant() == Approx(1.0));
  }
}

TEST_CASE("se3 gives a rotation where the best orthogonal matrix is a mirror") {
  std::vector<PosePair> pairs;
  for (const Vec3& p : kCloud)
    pairs.push_back({0, {Mat3::Identity(), p}, {Mat3::Identity(), Vec3(p.x(), p.y(), -p.z())}});
  const Pose A = align(Alignment::se3, pairs, ones(pairs));
  CHECK(A.R.determinant() == Approx(1.0));
}

TEST_CASE("the alignments are minima of the weighted cost") {
  auto pairs = pairs_of(kCloud, {exp_so3(Vec3(0.05, -0.1, 2.0)), Vec3(1, 2, 3)});
  pairs[1].estimate.p += Vec3(0.3, -0.2, 0.1);
  pairs[3].estimate.p += Vec3(-0.1, 0.4, 0.2);
  const std::vector<double> weights = {1.0, 0.5, 2.0, 4.0, 0.25};
  for (const Alignment alignment : {Alignment::se3, Alignment::yaw}) {
    const Pose A = align(alignment, pairs, weights);
    const double least = cost(A, pairs, weights);
    for (int i = 0; i < 6; ++i) {
      if (alignment == Alignment::yaw && i < 2) continue;
      for (const double step : {1e-3, -1e-3}) {
        const Vec6 xi = step * Vec6::Unit(i);
        CHECK(cost(exp_se3(xi) * A, pairs, weights) > least);
      }
    }
  }
}

TEST_CASE("yaw turns about z only") {  // eq. EVAL-5
  const Pose T{exp_so3(Vec3(0, 0, 2.5)), Vec3(1, 2, 3)};
  const auto pairs = pairs_of(kCloud, T);
  const Pose A = align(Alignment::yaw, pairs, ones(pairs));
  CHECK((A.R - T.R).norm() < 1e-13);
  CHECK((A.p - T.p).norm() < 1e-13);
  const auto tilted = pairs_of(kCloud, {exp_so3(Vec3(0.2, 0, 0)), Vec3::Zero()});
  CHECK(align(Alignment::yaw, tilted, ones(tilted)).R.col(2) == Vec3(0, 0, 1));
}

TEST_CASE("none changes nothing") {
  const auto pairs = pairs_of(kCloud, {exp_so3(Vec3(0.2, 0, 0)), Vec3(1, 0, 0)});
  const Pose A = align(Alignment::none, pairs, ones(pairs));
  CHECK(A.R == Mat3::Identity());
  CHECK(A.p == Vec3::Zero());
}

TEST_CASE("positions that do not determine the alignment are refused") {
  std::vector<Vec3> line, vertical;
  for (int i = 0; i < 20; ++i) {
    line.push_back(Vec3(100.3, 200.1, 5.7) + 0.37 * i * Vec3(1, 2, 0.5));
    vertical.push_back(Vec3(100.3, 200.1, 0.37 * i));
  }
  const Pose T{exp_so3(Vec3(0, 0, 0.3)), Vec3(1, 2, 3)};
  const auto on_line = pairs_of(line, T);
  CHECK_THROWS_AS(align(Alignment::se3, on_line, ones(on_line)), DataError);
  CHECK_THROWS_WITH(align(Alignment::se3, on_line, ones(on_line)),
                    "alignment se3: the 20 matched positions lie on a line or in a point, which leaves the rotation "
                    "open; use a longer trajectory, or `aslio evaluate --alignment yaw` or none");
  CHECK((align(Alignment::yaw, on_line, ones(on_line)).R - T.R).norm() < 1e-9);
  const auto upright = pairs_of(vertical, T);
  CHECK_THROWS_WITH(align(Alignment::yaw, upright, ones(upright)), Catch::StartsWith("alignment yaw: the 20 matched"));
}

TEST_CASE("the nearest rotation to a scaled and disturbed rotation") {  // eq. EVAL-6
  const Mat3 R = exp_so3(Vec3(1, 2, -0.5));
  CHECK((nearest_rotation(3.0 * R) - R).norm() < 1e-14);
  Mat3 M = R;
  M(0, 1) += 1e-3;
  const Mat3 N = nearest_rotation(M);
  CHECK((N * N.transpose() - Mat3::Identity()).norm() < 1e-14);
  CHECK((N - M).norm() < (R - M).norm());
}

TEST_CASE("statistics with equal weights are the usual ones") {  // eq. EVAL-7
  const std::vector<double> values = {4, 1, 3, 2}, weights = {0.25, 0.25, 0.25, 0.25};
  const Statistics s = weighted_statistics(values, weights);
  CHECK(s.n == 4);
  CHECK(s.mean == Approx(2.5));
  CHECK(s.rmse == Approx(std::sqrt(7.5)));
  CHECK(s.median == Approx(2.5));
  CHECK(s.std == Approx(std::sqrt(1.25)));
  CHECK(s.min == 1.0);
  CHECK(s.max == 4.0);
  CHECK(weighted_statistics(std::vector<double>{5, 1, 3}, std::vector<double>{1, 1, 1}).median == 3.0);
  CHECK(weighted_statistics({}, {}).n == 0);
}

TEST_CASE("a weight of three is a value three times") {
  const Statistics weighted = weighted_statistics(std::vector<double>{2, 7, 1}, std::vector<double>{3, 1, 2});
  const Statistics repeated = weighted_statistics(std::vector<double>{2, 2, 2, 7, 1, 1}, std::vector<double>(6, 1.0));
  CHECK(weighted.mean == Approx(repeated.mean));
  CHECK(weighted.rmse == Approx(repeated.rmse));
  CHECK(weighted.std == Approx(repeated.std));
  CHECK(weighted.median == repeated.median);
}

TEST_CASE("time weights are half the gaps, and a long gap counts only so much") {  // eq. EVAL-8
  std::vector<PosePair> pairs(4);
  pairs[1].t = kSecond / 10;
  pairs[2].t = 3 * kSecond / 10;
  pairs[3].t = 10 * kSecond;
  const std::vector<double> w = time_weights(pairs, kSecond);
  const double expected[] = {0.05, 0.15, 0.6, 0.5};
  for (std::size_t i = 0; i < 4; ++i) CHECK(w[i] == Approx(expected[i]));
  CHECK(time_weights(std::vector<PosePair>(1), kSecond) == std::vector<double>{1.0});
}
