// Lines through neighbours against Eigen's decomposition, the distance against brute force, the Jacobian, the kernel.
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "plugins/build_environment.hpp"
#include "residuals/point_to_line.hpp"

using namespace aslio;
using plugins::PointToLine;

namespace {

struct Random {
  std::mt19937_64 engine{7};
  double operator()(double half) { return half * (2.0 * static_cast<double>(engine() >> 11) * 0x1p-53 - 1.0); }
  Vec3 vector(double half) { return {(*this)(half), (*this)(half), (*this)(half)}; }
};

Neighbours one(const std::vector<Vec3>& offsets, int k) {
  Neighbours n;
  n.resize(1, k);
  n.count[0] = static_cast<std::uint8_t>(offsets.size());
  for (std::size_t j = 0; j < offsets.size(); ++j) n.offsets[j] = offsets[j].cast<float>();
  return n;
}

/// Least distance of p to the line, by trying.
double by_trying(const Vec3& p, const Surface& line) {
  double centre = 0, span = 100, best = 1e9;
  for (int round = 0; round < 40; ++round) {
    double at = centre;
    for (int i = -20; i <= 20; ++i) {
      const double s = centre + span * i / 20.0, d = (p - line.anchor - s * line.normal).norm();
      if (d < best) {
        best = d;
        at = s;
      }
    }
    centre = at;
    span *= 0.5;
  }
  return best;
}

}  // namespace

TEST_CASE("a line needs neighbours whose scatter is long, by Eigen's values") {  // eq. RES-4
  test::BuildEnvironment environment;
  Random random;
  PointToLine residual({}, environment.context());
  int lines = 0, none = 0;
  for (int i = 0; i < 500; ++i) {
    const Vec3 along = random.vector(1.0).normalized();
    const double width = 0.3 * std::abs(random(1.0));
    std::vector<Vec3> offsets;
    Eigen::Matrix3Xd points(3, 5);
    for (int j = 0; j < 5; ++j) {
      offsets.push_back(random(0.4) * along + random.vector(width));
      points.col(j) = offsets.back().cast<float>().cast<double>();
    }
    const Vec3 query = random.vector(1e4), mean = points.rowwise().mean();
    const Eigen::Matrix3Xd centred = points.colwise() - mean;
    const Eigen::SelfAdjointEigenSolver<Mat3> solver(Mat3(centred * centred.transpose()));
    std::vector<Surface> found(1);
    residual.fit(std::vector<Vec3>{query}, one(offsets, 5), found);
    const double ratio = solver.eigenvalues()[2] / solver.eigenvalues()[1];
    if (std::abs(ratio - 3.0) < 1e-3) continue;
    REQUIRE(found[0].valid == (ratio > 3.0));
    (found[0].valid ? lines : none) += 1;
    if (!found[0].valid) continue;
    REQUIRE(found[0].normal.cross(solver.eigenvectors().col(2)).norm() < 1e-4);
    REQUIRE((found[0].anchor - query - mean).norm() < 1e-9);
  }
  CHECK(lines > 100);
  CHECK(none > 50);
}

TEST_CASE("neighbours that span no line give none") {
  test::BuildEnvironment environment;
  PointToLine residual({}, environment.context());
  std::vector<Surface> found(1);
  const std::vector<Vec3> query{Vec3::Zero()};
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const auto& offsets : {std::vector<Vec3>(5, Vec3(0.1, 0.2, 0.3)), std::vector<Vec3>(5, Vec3::Constant(nan)),
                              std::vector<Vec3>{{0, 0, 0}, {0.1, 0, 0}, {0.2, 0, 0}, {0.3, 0, 0}}}) {
    residual.fit(query, one(offsets, 5), found);
    CHECK_FALSE(found[0].valid);
  }
}

TEST_CASE("two rows are the distance to the line, and their Jacobian is that of central differences") {
  test::BuildEnvironment environment;
  Random random;
  PointToLine::Params params;
  params.kernel = PointToLine::Kernel::none;
  PointToLine residual(params, environment.context());
  const std::vector<float> range{5.0F};
  const auto rows_at = [&](const Vec3& p, const Surface& line) {
    std::vector<ResidualRow> rows(2);
    residual.evaluate(std::vector<Vec3>{p}, range, std::vector<Surface>{line}, 0.1, rows);
    return rows;
  };
  for (int i = 0; i < 50; ++i) {
    const Surface line{random.vector(1).normalized(), random.vector(20), 1.0, true};
    const Vec3 p = line.anchor + random.vector(3);
    const auto rows = rows_at(p, line);
    REQUIRE(std::hypot(rows[0].r, rows[1].r) == Approx(by_trying(p, line)).margin(1e-9));
    for (std::size_t row = 0; row < 2; ++row) {
      REQUIRE(rows[row].information == Approx(100.0));
      for (int axis = 0; axis < 3; ++axis) {
        const Vec3 step = 1e-6 * Vec3::Unit(axis);
        const double slope = (rows_at(p + step, line)[row].r - rows_at(p - step, line)[row].r) / 2e-6;
        REQUIRE(rows[row].J[axis] == Approx(slope).margin(1e-7));
      }
    }
  }
}

TEST_CASE("gate and kernel of a line are of the distance") {
  test::BuildEnvironment environment;
  const std::vector<Surface> line{{Vec3::UnitZ(), Vec3::Zero(), 0.5, true}};
  std::vector<ResidualRow> rows(2);
  for (const auto& [kernel, weight] :
       {std::pair{PointToLine::Kernel::huber, 0.2}, std::pair{PointToLine::Kernel::cauchy, 1.0 / 26.0}}) {
    PointToLine::Params params;
    params.kernel = kernel;
    PointToLine residual(params, environment.context());
    residual.evaluate(std::vector<Vec3>{{0.3, 0.4, 7.0}}, std::vector<float>{10.0F}, line, 1.0, rows);
    for (const ResidualRow& row : rows) CHECK(row.information == Approx(0.5 * weight));
  }
  PointToLine::Params params;
  params.gate = 20.0;  // range > 20 r^2: up to 0.5 m at 5 m
  PointToLine residual(params, environment.context());
  for (const auto& [range, inside] : {std::pair{4.9F, false}, std::pair{5.1F, true}}) {
    residual.evaluate(std::vector<Vec3>{{0.3, 0.4, 7.0}}, std::vector<float>{range}, line, 1.0, rows);
    CHECK((rows[0].information > 0) == inside);
  }
}
