// Plane fits against Eigen's decompositions, degenerate neighbours, gates, kernels, and the Jacobian.
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "plugins/build_environment.hpp"
#include "residuals/point_to_plane.hpp"

using namespace aslio;
using plugins::PointToPlane;

namespace {

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  double operator()(double half) { return half * (2.0 * static_cast<double>(engine_() >> 11) * 0x1p-53 - 1.0); }
  Vec3 direction() {
    Vec3 v;
    do {
      v = Vec3((*this)(1), (*this)(1), (*this)(1));
    } while (v.norm() < 0.1 || v.norm() > 1.0);
    return v.normalized();
  }

 private:
  std::mt19937_64 engine_;
};

/// k neighbours per query, as offsets.
struct Batch {
  explicit Batch(int k) : k_(k) {}
  void add(const Vec3& query, const std::vector<Vec3>& offsets) {
    queries.push_back(query);
    Neighbours grown;
    grown.resize(queries.size(), k_);
    std::copy(neighbours.count.begin(), neighbours.count.end(), grown.count.begin());
    std::copy(neighbours.offsets.begin(), neighbours.offsets.end(), grown.offsets.begin());
    neighbours = grown;
    neighbours.count.back() = static_cast<std::uint8_t>(offsets.size());
    for (std::size_t j = 0; j < offsets.size(); ++j) {
      neighbours.offsets[(queries.size() - 1) * neighbours.k() + j] = offsets[j].cast<float>();
    }
  }
  std::vector<Surface> fit(PointToPlane& residual) {
    std::vector<Surface> surfaces(queries.size());
    residual.fit(queries, neighbours, surfaces);
    return surfaces;
  }
  Eigen::Matrix3Xd offsets(std::size_t i) const {
    Eigen::Matrix3Xd m(3, k_);
    for (int j = 0; j < k_; ++j) m.col(j) = neighbours.offset(i, static_cast<std::size_t>(j)).cast<double>();
    return m;
  }

  std::vector<Vec3> queries;
  Neighbours neighbours;

 private:
  int k_;
};

std::vector<Vec3> patch(Random& random, const Vec3& normal, int k, double noise) {
  const Vec3 u = normal.unitOrthogonal(), v = normal.cross(u);
  const double height = random(0.2);
  std::vector<Vec3> offsets;
  for (int j = 0; j < k; ++j) {
    offsets.push_back(random(0.4) * u + random(0.4) * v + (height + random(noise)) * normal);
  }
  return offsets;
}

double angle(const Vec3& a, const Vec3& b) { return a.cross(b).norm(); }

}  // namespace

TEST_CASE("planes equal the eigenvector of the scatter wherever the points lie in one") {  // eq. RES-1
  test::BuildEnvironment environment;
  Random random(1);
  for (const int k : {3, 5, 8, 20}) {
    PointToPlane::Params params;
    params.k = k;
    params.plane_threshold = 10.0;
    params.min_spread = 0.0;
    PointToPlane residual(params, environment.context());
    for (const double noise : {0.0, 0.001, 0.02, 0.05}) {
      Batch batch(k);
      for (int i = 0; i < 300; ++i) batch.add(1e5 * random.direction(), patch(random, random.direction(), k, noise));
      const auto surfaces = batch.fit(residual);
      int checked = 0;
      for (std::size_t i = 0; i < surfaces.size(); ++i) {
        const Eigen::Matrix3Xd points = batch.offsets(i);
        const Vec3 mean = points.rowwise().mean();
        const Eigen::Matrix3Xd centred = points.colwise() - mean;
        const Eigen::SelfAdjointEigenSolver<Mat3> solver(Mat3(centred * centred.transpose()));
        if (solver.eigenvalues()[0] > 0.3 * solver.eigenvalues()[1]) continue;  // no plane to speak of
        REQUIRE(surfaces[i].valid);
        REQUIRE(surfaces[i].normal.norm() == Approx(1.0).epsilon(1e-12));
        REQUIRE(angle(surfaces[i].normal, solver.eigenvectors().col(0)) < 1e-6);
        REQUIRE((surfaces[i].anchor - batch.queries[i] - mean).norm() < 1e-9);
        ++checked;
      }
      REQUIRE(checked > 250);
    }
  }
}

TEST_CASE("planes agree with the QR solution of n.x + 1 = 0 where there is little noise") {
  test::BuildEnvironment environment;
  PointToPlane residual({}, environment.context());
  Random random(2);
  Batch batch(5);
  for (int i = 0; i < 200; ++i) batch.add(Vec3::Zero(), patch(random, random.direction(), 5, 0.0));
  const auto surfaces = batch.fit(residual);
  int checked = 0;
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    if (!surfaces[i].valid) continue;  // nearly collinear by chance
    // Seen from 2 m in front, so that the plane does not pass through the origin, where that equation has no solution.
    const Eigen::Matrix3Xd points = batch.offsets(i).colwise() + 2.0 * surfaces[i].normal;
    const Vec3 n = points.transpose().colPivHouseholderQr().solve(-Eigen::VectorXd::Ones(5));
    REQUIRE(angle(n.normalized(), surfaces[i].normal) < 1e-5);
    ++checked;
  }
  REQUIRE(checked > 180);
}

TEST_CASE("neighbours that span no plane give none") {
  test::BuildEnvironment environment;
  PointToPlane residual({}, environment.context());
  Random random(3);
  for (int i = 0; i < 100; ++i) {
    Batch batch(5);
    const Vec3 d = random.direction();
    std::vector<Vec3> line, point, pair, few = patch(random, d, 4, 0.0);
    for (int j = 0; j < 5; ++j) {
      line.push_back(0.1 * j * d + Vec3(random(0.002), random(0.002), random(0.002)));
      point.push_back(0.3 * d);
      pair.push_back((j % 2 == 0 ? 0.2 : -0.1) * d);
    }
    batch.add(Vec3::Zero(), line);
    batch.add(Vec3::Zero(), point);
    batch.add(Vec3::Zero(), pair);
    batch.add(Vec3::Zero(), few);
    batch.add(Vec3::Zero(), std::vector<Vec3>(5, Vec3::Constant(std::numeric_limits<double>::quiet_NaN())));
    for (const Surface& surface : batch.fit(residual)) REQUIRE(!surface.valid);
  }
}

TEST_CASE("fewer neighbours make a plane where asked, each query of as many as it has") {
  test::BuildEnvironment environment;
  PointToPlane::Params params;
  params.k_min = 3;
  PointToPlane some(params, environment.context());
  PointToPlane all({}, environment.context());
  Batch batch(5);
  const std::vector<std::size_t> counts{5, 3, 2, 4, 5, 0, 3};
  for (const std::size_t count : counts) {
    std::vector<Vec3> square{{0.5, 0.5, 0.1}, {0.5, -0.5, 0.1}, {-0.5, 0.4, 0.1}, {-0.4, -0.5, 0.1}, {0.1, 0.0, 0.1}};
    square.resize(count);
    batch.add(Vec3(1, 2, 3), square);
  }
  const auto of_some = batch.fit(some), of_all = batch.fit(all);
  for (std::size_t i = 0; i < counts.size(); ++i) {
    CAPTURE(i, counts[i]);
    CHECK(of_all[i].valid == (counts[i] == 5));
    REQUIRE(of_some[i].valid == (counts[i] >= 3));
    if (!of_some[i].valid) continue;
    CHECK(angle(of_some[i].normal, Vec3::UnitZ()) < 1e-6);
    CHECK(of_some[i].anchor.z() == Approx(3.1));
  }
}

TEST_CASE("a plane is refused exactly when a neighbour lies beyond the threshold") {
  test::BuildEnvironment environment;
  // A square with its centre raised by h: the plane lies at h / 5, the centre 4 h / 5 above it.
  for (const double h : {0.05, 0.124, 0.126, 0.2}) {
    PointToPlane residual({}, environment.context());
    Batch batch(5);
    batch.add(Vec3(1, 2, 3), {{0.5, 0.5, 0}, {0.5, -0.5, 0}, {-0.5, 0.5, 0}, {-0.5, -0.5, 0}, {0, 0, h}});
    const auto surfaces = batch.fit(residual);
    REQUIRE(surfaces[0].valid == (0.8 * h <= 0.1));
    if (surfaces[0].valid) REQUIRE(surfaces[0].anchor.z() == Approx(3.0 + 0.2 * h).epsilon(1e-6));
  }
}

TEST_CASE("the Jacobian equals central differences of the residual") {
  test::BuildEnvironment environment;
  PointToPlane residual({}, environment.context());
  Random random(4);
  for (int i = 0; i < 50; ++i) {
    const std::vector<Surface> surface{{random.direction(), 100.0 * random.direction(), 1.0, true}};
    const std::vector<float> range{1e6F};
    const Vec3 p = surface[0].anchor + 0.3 * random.direction();
    std::vector<ResidualRow> row(1), plus(1), minus(1);
    residual.evaluate(std::vector<Vec3>{p}, range, surface, 0.03, row);
    REQUIRE(row[0].information == Approx(1.0 / 0.0009).epsilon(1e-12));
    for (int axis = 0; axis < 3; ++axis) {
      constexpr double step = 1e-4;
      residual.evaluate(std::vector<Vec3>{p + step * Vec3::Unit(axis)}, range, surface, 0.03, plus);
      residual.evaluate(std::vector<Vec3>{p - step * Vec3::Unit(axis)}, range, surface, 0.03, minus);
      REQUIRE(row[0].J[axis] == Approx((plus[0].r - minus[0].r) / (2 * step)).margin(1e-9));
    }
  }
}

TEST_CASE("gate, kernels and quality weigh a row") {  // eq. RES-1
  test::BuildEnvironment environment;
  const std::vector<Surface> surface{{Vec3::UnitZ(), Vec3::Zero(), 0.5, true}};
  const auto information = [&](const PointToPlane::Params& params, double r, float range) {
    PointToPlane residual(params, environment.context());
    std::vector<ResidualRow> row(1, {7.0, Vec3::Ones(), 7.0});
    residual.evaluate(std::vector<Vec3>{{3, 4, r}}, std::vector<float>{range}, surface, 0.1, row);
    // Whatever the gate says, the distance is told.
    if (std::isfinite(r)) REQUIRE((row[0].r == r && row[0].measures()));
    return row[0].information;
  };
  PointToPlane::Params params;
  // FAST-LIO2: 1 - 0.9 |r| / sqrt(range) > 0.9.
  for (const float range : {1.0F, 4.0F, 25.0F}) {
    for (const double r : {0.05, -0.11, 0.112, 0.2, -0.23, 0.5, 0.6}) {
      const bool kept = 1.0 - 0.9 * std::abs(r) / std::sqrt(static_cast<double>(range)) > 0.9;
      REQUIRE(information(params, r, range) == Approx(kept ? 50.0 : 0.0));
    }
  }
  params.gate = 0;
  REQUIRE(information(params, 5.0, 1.0F) == Approx(50.0));
  REQUIRE(information(params, std::numeric_limits<double>::quiet_NaN(), 1.0F) == 0.0);
  params.max_residual = 0.3;  // on either side, at any range
  for (const double r : {0.29, -0.29}) REQUIRE(information(params, r, 1.0F) == Approx(50.0));
  for (const double r : {0.31, -0.31}) REQUIRE(information(params, r, 100.0F) == 0.0);
  params.max_residual.reset();
  params.kernel = PointToPlane::Kernel::huber;
  REQUIRE(information(params, 0.05, 1.0F) == Approx(50.0));
  REQUIRE(information(params, -0.4, 1.0F) == Approx(12.5));
  params.kernel = PointToPlane::Kernel::cauchy;
  REQUIRE(information(params, 0.1, 1.0F) == Approx(25.0));
}

TEST_CASE("matches of one plane of the map share its error") {  // eq. RES-5
  test::BuildEnvironment environment;
  const double sigma = 0.02, plane = 0.006;
  std::vector<Surface> surfaces(9, {Vec3::UnitZ(), Vec3::Zero(), 0.5, true});
  for (std::size_t i = 0; i < 6; ++i) surfaces[i].shared_matches = i < 4 ? 3.0 : 2.5;
  surfaces[3].valid = false;
  const std::vector<Vec3> world(surfaces.size(), Vec3(3, 4, 0));
  const std::vector<float> range(surfaces.size(), 5.0F);
  const auto information = [&](PointToPlane::Planes planes, double common) {
    PointToPlane residual({.planes = planes, .plane_sigma = common}, environment.context());
    std::vector<ResidualRow> rows(surfaces.size());
    residual.evaluate(world, range, surfaces, sigma, rows);
    std::vector<double> found;
    for (const ResidualRow& row : rows) found.push_back(row.information);
    return found;
  };
  const auto shared = information(PointToPlane::Planes::map, plane);
  const auto expected = [&](double n) { return Approx(0.5 / (sigma * sigma + n * plane * plane)).epsilon(1e-12); };
  for (const std::size_t i : {0, 1, 2}) CHECK(shared[i] == expected(3));
  CHECK(shared[3] == 0.0);
  for (const std::size_t i : {4, 5}) CHECK(shared[i] == expected(2.5));
  for (const std::size_t i : {6, 7, 8}) CHECK(shared[i] == expected(1));
  // Planes fitted to neighbours share nothing, nor does anything without an error in common.
  for (const auto& alone :
       {information(PointToPlane::Planes::neighbours, plane), information(PointToPlane::Planes::map, 0.0)}) {
    for (std::size_t i = 0; i < surfaces.size(); ++i) CHECK(alone[i] == (i == 3 ? 0.0 : 0.5 * (1.0 / (sigma * sigma))));
  }
  // However many they are, all matches of a plane together know no more than its own error lets them.
  surfaces.assign(100000, surfaces[0]);
  for (Surface& surface : surfaces) surface.shared_matches = 100000;
  PointToPlane residual({.planes = PointToPlane::Planes::map, .plane_sigma = plane}, environment.context());
  std::vector<ResidualRow> rows(surfaces.size());
  residual.evaluate(std::vector<Vec3>(surfaces.size(), Vec3(3, 4, 0)), std::vector<float>(surfaces.size(), 5.0F),
                    surfaces, sigma, rows);
  double sum = 0;
  for (const ResidualRow& row : rows) sum += row.information;
  CHECK(sum < 0.5 / (plane * plane));
  CHECK(sum > 0.49 / (plane * plane));
}

TEST_CASE("planes weigh by how flat their neighbours lie and how near they are") {  // eq. RES-3
  test::BuildEnvironment environment;
  PointToPlane residual({.k = 8, .plane_threshold = 1.0, .weighting = PointToPlane::Weighting::planarity},
                        environment.context());
  Random random(11);
  for (const double noise : {0.0, 0.05, 0.2}) {
    Batch batch(8);
    batch.add(Vec3(1, 2, 3), patch(random, random.direction(), 8, noise));
    batch.neighbours.squared.assign(8, 0.25F);
    const Surface surface = batch.fit(residual)[0];
    REQUIRE(surface.valid);
    const Eigen::Matrix3Xd centred = batch.offsets(0).colwise() - batch.offsets(0).rowwise().mean();
    const Eigen::SelfAdjointEigenSolver<Mat3> solver(centred * centred.transpose() / 8.0);
    const Vec3 deviation = solver.eigenvalues().cwiseMax(0.0).cwiseSqrt();  // ascending
    const double flat = (deviation[1] - deviation[0]) / deviation[2];
    CHECK(surface.quality == Approx(0.9 * flat * flat + 0.1 * std::exp(-0.5 / (0.3 * 8))).epsilon(1e-6));
  }
}

TEST_CASE("an invalid surface gives a row without information") {
  test::BuildEnvironment environment;
  PointToPlane residual({}, environment.context());
  std::vector<ResidualRow> row(1, {7.0, Vec3::Ones(), 7.0});
  residual.evaluate(std::vector<Vec3>{{0, 0, 0}}, std::vector<float>{10.0F}, std::vector<Surface>(1), 0.1, row);
  REQUIRE(row[0].information == 0.0);
  REQUIRE(row[0].J == Vec3::Zero());
}

TEST_CASE("planes do not depend on the place in the batch, nor on what else is in it") {
  test::BuildEnvironment environment;
  PointToPlane residual({}, environment.context());
  Random random(5);
  const auto offsets = patch(random, random.direction(), 5, 0.02);
  Batch alone(5), many(5);
  alone.add(Vec3(1, 2, 3), offsets);
  for (int i = 0; i < 37; ++i) many.add(Vec3::Zero(), patch(random, random.direction(), 5, 0.02));
  many.add(Vec3(1, 2, 3), offsets);
  const Surface a = alone.fit(residual)[0], b = many.fit(residual)[37];
  REQUIRE(a.valid);
  REQUIRE(a.normal == b.normal);
  REQUIRE(a.anchor == b.anchor);
}

TEST_CASE("the kernel follows the noise, the gate stays (eq. NOI-2)") {
  test::BuildEnvironment environment;
  PointToPlane::Params params;
  params.gate = 81;
  params.kernel = PointToPlane::Kernel::cauchy;
  params.kernel_width = 0.035;
  PointToPlane residual(params, environment.context());
  Surface floor;
  floor.normal = Vec3::UnitZ();
  floor.valid = true;
  const auto information = [&](double r, float range, double sigma) {
    std::vector<ResidualRow> row(1);
    residual.evaluate(std::vector<Vec3>{{0, 0, r}}, std::vector<float>{range}, std::vector<Surface>{floor}, sigma, row);
    return row[0].information;
  };
  const double at_width = information(0.035, 5.0F, 0.02);
  CHECK(at_width == Approx(0.5 / (0.02 * 0.02)));
  CHECK(information(0.3, 5.0F, 0.02) == 0.0);  // 0.25 m at 5 m
  residual.set_noise_scale(3.0);
  CHECK(information(0.105, 5.0F, 0.06) == Approx(0.5 / (0.06 * 0.06)));
  CHECK(information(0.3, 5.0F, 0.06) == 0.0);
  residual.set_noise_scale(1.0);
  CHECK(information(0.035, 5.0F, 0.02) == at_width);
}
