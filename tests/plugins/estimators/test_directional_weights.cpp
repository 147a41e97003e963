// Information by direction of the pose, where errors of the normals make up what a view seems to see (docs/equations.md
// IESKF-12, IESKF-13).
#include <Eigen/Eigenvalues>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "aslio/core/angles.hpp"
#include "aslio/core/lie.hpp"
#include "estimators/directional_weights.hpp"
#include "plugins/estimators/corridor.hpp"
#include "plugins/estimators/room_filter.hpp"

using namespace aslio;
using namespace aslio::test;
using plugins::DirectionalWeights;
using Rule = DirectionalWeights::Rule;

namespace {

constexpr double kSigma = 0.02;  // of a point [m]

/// Rows of a corridor whose normals are in error, for a pose that is off by `error` (theta, p) in the attitude R.
struct Rows {
  plugins::WindowMatches set;
  WindowInformation sum;
  Mat3 R = exp_so3(Vec3(0.1, -0.2, 0.7));
  std::mt19937 random{7};

  explicit Rows(double normal_error_deg, const Vec6& error = Vec6::Zero(), int ends = 0) {
    auto points = corridor_points(900, 8.0, random);
    for (int i = 0; i < ends; ++i) points.push_back({Vec3(8, 0.01 * i - 1, 0.02 * i - 1), Vec3::UnitX()});
    std::normal_distribution<double> angle;
    const double size = normal_error_deg * kRadPerDeg;
    for (const CorridorPoint& point : points) {
      set.body.push_back(R.transpose() * point.p);
      const Vec3 u =
          exp_so3(point.normal.cross(size * Vec3(angle(random), angle(random), angle(random)))) * point.normal;
      const double r = row(set.body.back(), point.normal).dot(error);
      set.rows.push_back({r, u, 1.0 / (kSigma * kSigma)});
      sum.add(set.body.back(), R.transpose(), u, r, set.rows.back().information);
    }
  }
  Vec6 row(const Vec3& p_I, const Vec3& u) const {
    Vec6 h;
    h << p_I.cross(R.transpose() * u), u;
    return h;
  }
  DirectionalWeights::Rows all() const { return {set, 1, 0.0, R}; }
};

DirectionalWeights weights(double normal_error, const Rows& rows) {
  DirectionalWeights out({Rule::damped, normal_error});
  out.find(rows.all(), rows.sum.A);
  return out;
}

double least_eigenvalue(const Eigen::Ref<const Eigen::MatrixXd>& A) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(A).eigenvalues()[0];
}

/// The 12 x 12 of DSK-3 from these rows, at times spread over 0.1 s.
SeenMatrix seen_late(const Rows& rows) {
  SeenMatrix A = SeenMatrix::Zero();
  for (std::size_t i = 0; i < rows.set.body.size(); ++i) {
    const Vec6 h = rows.row(rows.set.body[i], rows.set.rows[i].J);
    SeenVector both;
    both << h, -0.1 * static_cast<double>(i % 97) / 97 * h;
    A += rows.set.rows[i].information * both * both.transpose();
  }
  return A;
}

/// Where 30 updates at rest in a noisy corridor lead.
struct Standing {
  Vec3 moved = Vec3::Zero();
  double sigma_along = 0, least = 0;
};

Standing stand(const std::string& rule, unsigned seed, int threads = 1) {
  Filter filter({"estimator={type: ieskf, noise: physical, directional: " + rule + "}"}, 0.02, true,
                Vec3(0, 0, -kStandardGravity), threads);
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0.0, kSigma);
  std::vector<WorldPoint> map;
  for (const CorridorPoint& point : corridor_points(2000, 9.0, random)) {
    map.push_back({.p_W = point.p + noise(random) * point.normal});
  }
  filter.map->insert(map, 1);
  Standing out;
  for (std::uint32_t k = 2; k < 32; ++k) {
    const CorridorWindow window(k, 900, kSigma, random);
    const Update& update = filter.update(window);
    REQUIRE(update.accepted);
    out.moved = update.state.p;
    out.sigma_along = std::sqrt(update.P(3, 3));
    out.least = std::min(out.least, least_eigenvalue(update.P));
  }
  return out;
}

}  // namespace

TEST_CASE("directional: errors of the normals alone make a direction weak, and a clear one is none") {  // eq. IESKF-12
  const Rows bare(2.0);
  const DirectionalWeights found = weights(2.0, bare);
  REQUIRE(found.weak() == 1);
  CHECK(found.share(0) < 0.15);
  const Vec6 v = found.direction(0).normalized();
  CHECK(std::abs(v[3]) > 0.99);  // along x, as a displacement
  CHECK(weights(3.0, bare).share(0) == 0.0);
  // Information of five times the error counts in part, of far more in full.
  const double five = weights(2.0, Rows(2.0, Vec6::Zero(), 4)).share(0);
  CHECK(five > 0.6);
  CHECK(five < 0.98);
  CHECK(weights(2.0, Rows(2.0, Vec6::Zero(), 100)).weak() == 0);
  CHECK(weights(2.0, Rows(0.0)).share(0) == 0.0);
}

TEST_CASE("directional damped: the weak direction loses information, and all else stays") {  // eq. IESKF-13
  const Rows rows(2.0, Vec6::Zero(), 4);
  const DirectionalWeights found = weights(2.0, rows);
  REQUIRE(found.weak() == 1);
  const SeenMatrix A = seen_late(rows), L = found.damping(A), damped = L * A;
  CHECK((damped - damped.transpose()).norm() < 1e-9 * A.norm());
  CHECK(least_eigenvalue(damped) > -1e-9 * A.norm());
  CHECK(least_eigenvalue(A - damped) > -1e-9 * A.norm());
  const Vec6 v = found.direction(0);
  CHECK(v.dot(damped.topLeftCorner<6, 6>() * v) == Approx(found.share(0) * v.dot(rows.sum.A * v)).epsilon(1e-6));
  CHECK(damped(4, 4) == Approx(A(4, 4)).epsilon(1e-3));
  CHECK(damped(5, 5) == Approx(A(5, 5)).epsilon(1e-3));
  CHECK((damped.topLeftCorner<3, 3>() - A.topLeftCorner<3, 3>()).norm() < 1e-3 * A.topLeftCorner<3, 3>().norm());
  // The same measurement with more noise: its residuals still point to the same error.
  SeenVector y;
  y << 1, -2, 3, 4, -5, 6, 7, 8, -9, 1, 2, 3;
  CHECK((L * (A * y) - damped * y).norm() < 1e-9 * (A * y).norm());
}

TEST_CASE("directional damped: an extra error of the points, as a filter would carry it") {  // eq. IESKF-13
  const Rows rows(2.0, Vec6::Zero(), 4);
  const DirectionalWeights found = weights(2.0, rows);
  const SeenMatrix A = seen_late(rows) + SeenMatrix::Identity();
  const Vec6 v = found.direction(0);
  const double information = v.dot(rows.sum.A * v), share = found.share(0);
  // (A^-1 + E Q E^T)^-1 with the variance q = (1 - s) / (s information) along v.
  SeenMatrix cov = A.inverse();
  cov.topLeftCorner<6, 6>() += (1 - share) / (share * information) * v * v.transpose();
  const SeenMatrix expected = cov.inverse();
  CHECK((found.damping(A) * A - expected).norm() < 1e-6 * expected.norm());
}

TEST_CASE("directional: a plane has the error that its neighbours leave it") {  // eq. IESKF-12
  // Five neighbours of every point, spread by 0.1 m in their wall: 0.02 / (0.1 sqrt(5)) is 5 deg.
  const auto found = [](double apart, double s, double most = 1.0) {
    Rows rows(5.0);
    rows.set.neighbours.resize(rows.set.body.size(), 5);
    for (std::size_t i = 0; i < rows.set.body.size(); ++i) {
      rows.set.neighbours.count[i] = 5;
      const Vec3 u = rows.set.rows[i].J, a = u.unitOrthogonal(), b = u.cross(a);
      for (std::size_t j = 0; j < 5; ++j) {
        const double angle = 72 * kRadPerDeg * static_cast<double>(j);
        // On a wave about the plane, so that what is left of it has the variance s^2 over two degrees of freedom.
        const Vec3 offset = std::sqrt(2.0) * apart * (std::cos(angle) * a + std::sin(angle) * b) +
                            2.0 / std::sqrt(5.0) * s * std::cos(2 * angle) * u;
        rows.set.neighbours.offsets[i * 5 + j] = offset.cast<float>();
      }
    }
    DirectionalWeights out({Rule::damped, 1e-3});
    out.find({rows.set, 1, most, rows.R}, rows.sum.A);
    return out;
  };
  REQUIRE(found(0.1, kSigma).weak() == 1);
  CHECK(found(0.1, kSigma).share(0) < 0.15);
  CHECK(found(0.03, kSigma).share(found(0.03, kSigma).weak() - 1) == 0.0);
  CHECK(found(0.2, kSigma).share(0) > 0.7);  // 2.5 deg are a quarter of that
  CHECK(found(0.1, 0.0).weak() == 0);
  CHECK(found(0.03, kSigma, 1e-3 * kSigma).weak() == 0);  // no noisier than the filter takes points for
}

TEST_CASE("directional: what is not finite, and no row at all, has no weak direction") {
  Rows rows(2.0);
  rows.sum.A(2, 3) = std::numeric_limits<double>::quiet_NaN();
  CHECK(weights(3.0, rows).weak() == 0);
  Rows empty(2.0);
  empty.set.rows.assign(empty.set.rows.size(), ResidualRow{});
  empty.sum = WindowInformation{};
  CHECK(weights(3.0, empty).weak() == 0);
}

TEST_CASE("directional: in a corridor the filter drifts less along it, and no more across") {
  const auto rms = [](const std::string& rule) {
    Vec3 squares = Vec3::Zero();
    double worst = 0;
    for (unsigned seed = 1; seed <= 4; ++seed) {
      const Standing found = stand(rule, seed);
      CHECK(found.least > -1e-12);
      squares += found.moved.cwiseAbs2() / 4.0;
      worst = std::max(worst, std::abs(found.moved.x()) / found.sigma_along);
    }
    return std::pair<Vec3, double>(squares.cwiseSqrt(), worst);
  };
  const auto [none, none_sigmas] = rms("none");
  const auto [damped, sigmas] = rms("damped");
  CAPTURE(none.transpose(), damped.transpose(), none_sigmas, sigmas);
  CHECK(damped.x() < 0.5 * none.x());
  CHECK(damped.y() < 1.2 * none.y() + 1e-4);
  CHECK(damped.z() < 1.05 * none.z());
  // The errors of the map are the same in every window, and the filter takes them for new noise each time.
  CHECK(sigmas < 0.25 * none_sigmas);
}

TEST_CASE("directional: same bits for any number of threads, and those without it in a clear room") {
  const Standing one = stand("damped", 1, 1), three = stand("damped", 1, 3);
  CHECK(one.moved == three.moved);
  CHECK(one.sigma_along == three.sigma_along);
  const auto clear = [](const std::string& rule) {
    Filter filter({"estimator.directional=" + rule});
    filter.build_map(1);
    return filter.update(RoomWindow(kRoomEpoch, kTenth, Pose{Mat3::Identity(), Vec3(0.05, 0, 0)}, 2)).state;
  };
  const NavState without = clear("none"), with = clear("damped");
  CHECK(without.p == with.p);
  CHECK(without.R == with.R);
  CHECK(without.v == with.v);
}
