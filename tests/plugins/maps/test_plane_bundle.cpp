// Bundle adjustment on planes: its derivatives, rooms it must find, and scenes that tell too little. (eqs. MAP-10,
// MAP-11)
#include <Eigen/Eigenvalues>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "maps/plane_bundle.hpp"
#include "plugins/maps/map_fixture.hpp"

using namespace aslio;
using namespace aslio::test;
using plugins::PlaneBundle;
using plugins::PointMoments;
using Outcome = PlaneBundle::Outcome;

namespace {

struct Wall {
  Vec3 middle, normal;
};
const std::vector<Wall> kRoom = {{{4, 0, 0}, {1, 0, 0}},  {{-5, 0, 0}, {1, 0, 0}}, {{0, 3, 0}, {0, 1, 0}},
                                 {{0, -4, 0}, {0, 1, 0}}, {{0, 0, 2}, {0, 0, 1}},  {{0, 0, -1}, {0, 0, 1}}};

/// Places along a curve through the room, each turned otherwise.
std::vector<Pose> walk(std::size_t count) {
  std::vector<Pose> poses(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double s = static_cast<double>(i) / 4.0;
    poses[i] = {exp_so3(Vec3(0.1 * std::sin(s), 0.2 * std::cos(s), s)), Vec3(std::cos(s), 1.5 * std::sin(s), 0.1 * s)};
  }
  return poses;
}

Vec6 any(Uniform& uniform, double angle, double distance) {
  Vec6 xi;
  xi << uniform.in_box(Vec3::Zero(), angle), uniform.in_box(Vec3::Zero(), distance);
  return xi;
}

/// What the keyframes see of the walls: points in their frames, moved off the wall by up to `noise`.
class Scene {
 public:
  Scene(std::vector<Pose> poses, const std::vector<Wall>& walls, double noise, std::uint64_t seed = 1)
      : truth(std::move(poses)), uniform_(seed) {
    for (const Wall& wall : walls) {
      planes.emplace_back();
      for (std::uint32_t i = 0; i < truth.size(); ++i) planes.back().push_back({i, seen(wall, truth[i], noise)});
    }
  }
  /// The poses, moved by up to these from the truth, and all planes, at a weight of 1 / sigma^2.
  void load(PlaneBundle& bundle, double angle, double distance, double sigma) {
    start.clear();
    for (const Pose& pose : truth) {
      start.push_back(pose.moved(any(uniform_, angle, distance)));
      bundle.add_pose(start.back());
    }
    for (const auto& clusters : planes) {
      std::vector<PlaneBundle::Cluster> weighted;
      for (const auto& [pose, points] : clusters) weighted.push_back({pose, points.weighted(1.0 / (sigma * sigma))});
      bundle.add_plane({}, weighted);
    }
  }
  /// Root mean square of the distances from the truth [m], and of the angles [rad].
  std::pair<double, double> error(const std::vector<Pose>& poses) const {
    double shift = 0, turn = 0;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      shift += (poses[i].p - truth[i].p).squaredNorm();
      turn += log_so3(truth[i].R.transpose() * poses[i].R).squaredNorm();
    }
    const auto n = static_cast<double>(poses.size());
    return {std::sqrt(shift / n), std::sqrt(turn / n)};
  }

  std::vector<Pose> truth, start;
  std::vector<std::vector<PlaneBundle::Cluster>> planes;

 private:
  PointMoments seen(const Wall& wall, const Pose& pose, double noise) {
    PointMoments out;
    for (int i = 0; i < 50; ++i) {
      Vec3 p = uniform_.in_box(Vec3::Zero(), 1.0);
      p += (uniform_(-noise, noise) - p.dot(wall.normal)) * wall.normal;
      out.add(pose.inverse() * (wall.middle + p));
    }
    return out;
  }

  Uniform uniform_;
};

Mat6 information(double sigma_angle, double sigma_distance) {
  Vec6 diagonal;
  diagonal << Vec3::Constant(1.0 / (sigma_angle * sigma_angle)),
      Vec3::Constant(1.0 / (sigma_distance * sigma_distance));
  return diagonal.asDiagonal();
}

std::vector<Pose> with_move(const std::vector<Pose>& poses, Eigen::Index unknown, double by) {
  std::vector<Pose> out = poses;
  Vec6 xi = Vec6::Zero();
  xi[unknown % 6] = by;
  Pose& pose = out[static_cast<std::size_t>(unknown / 6)];
  pose = pose.moved(xi);
  return out;
}

/// Moves two unknowns in one chart, so that second differences are those of one function.
double cost_at(const PlaneBundle& bundle, const std::vector<Pose>& poses, Eigen::Index i, double a, Eigen::Index j,
               double b) {
  if (i / 6 != j / 6) return bundle.cost(with_move(with_move(poses, i, a), j, b));
  std::vector<Pose> out = poses;
  Vec6 xi = Vec6::Zero();
  xi[i % 6] += a;
  xi[j % 6] += b;
  Pose& pose = out[static_cast<std::size_t>(i / 6)];
  pose = pose.moved(xi);
  return bundle.cost(out);
}

}  // namespace

TEST_CASE("point moments move as their points do") {  // eq. MAP-10
  Uniform uniform(3);
  const Pose T = Pose{}.moved(any(uniform, 2.0, 5.0));
  PointMoments before, after;
  for (int i = 0; i < 20; ++i) {
    const Vec3 p = uniform.in_box(Vec3(1, 2, 3), 2.0);
    before.add(p);
    after.add(T * p);
  }
  const PointMoments moved = before.moved(T);
  CHECK(moved.n == 20);
  CHECK((moved.sum - after.sum).norm() < 1e-11);
  CHECK((moved.squares() - after.squares()).norm() < 1e-10);
  CHECK((moved.weighted(0.25).scatter() - 0.25 * after.scatter()).norm() < 1e-10);
}

TEST_CASE("plane bundle: the sum is that of squared distances from the best planes") {  // eq. MAP-10
  Uniform uniform(5);
  PlaneBundle bundle({});
  const std::vector<Pose> poses = walk(3);
  PointMoments fixed;
  std::vector<Vec3> world;
  std::vector<PlaneBundle::Cluster> clusters;
  for (int i = 0; i < 10; ++i) {
    world.push_back(uniform.in_box(Vec3(3, 1, 0), 1.0));
    fixed.add(world.back());
  }
  for (std::uint32_t k = 0; k < 3; ++k) {
    bundle.add_pose(poses[k]);
    PointMoments points;
    for (int i = 0; i < 15; ++i) {
      const Vec3 p = uniform.in_box(Vec3(0.3, 0, 0), 0.7);
      points.add(p);
      world.push_back(poses[k] * p);
    }
    clusters.push_back({k, points});
  }
  bundle.add_plane(fixed, clusters);
  Vec3 mean = Vec3::Zero();
  for (const Vec3& p : world) mean += p / static_cast<double>(world.size());
  Mat3 scatter = Mat3::Zero();
  for (const Vec3& p : world) scatter += (p - mean) * (p - mean).transpose();
  const Vec3 normal = Eigen::SelfAdjointEigenSolver<Mat3>(scatter).eigenvectors().col(0);
  double squares = 0;
  for (const Vec3& p : world) squares += std::pow(normal.dot(p - mean), 2);
  CHECK(bundle.cost(poses) == Approx(squares).epsilon(1e-10));
}

TEST_CASE("plane bundle: slope and curvature are those of central differences") {  // eq. MAP-11
  Scene scene(walk(3), {kRoom[0], kRoom[2], kRoom[5], {{2, 1, 1}, Vec3(1, 2, 2) / 3.0}}, 0.1);
  PlaneBundle bundle({});
  scene.load(bundle, 0.05, 0.1, 0.5);
  PointMoments fixed;
  Uniform uniform(9);
  for (int i = 0; i < 30; ++i) fixed.add(uniform.in_box(Vec3(1, 2, 0), 1.0).cwiseProduct(Vec3(1, 1, 0.1)));
  bundle.add_plane(fixed, std::vector{scene.planes[1][0], scene.planes[2][2]});
  // Increments and priors that agree, so that the curvature of Gauss and Newton is exact.
  bundle.add_increment(0, 2, scene.start[0].inverse() * scene.start[2], information(0.1, 0.2));
  bundle.add_prior(1, scene.start[1], information(0.3, 0.1));

  Eigen::VectorXd slope;
  Eigen::MatrixXd curvature;
  const double sum = bundle.linearise(scene.start, slope, curvature);
  CHECK(sum == Approx(bundle.cost(scene.start)).epsilon(1e-12));
  CHECK((curvature - curvature.transpose()).norm() < 1e-9 * curvature.norm());
  constexpr double h = 1e-5, h2 = 2e-4;
  const double largest = curvature.cwiseAbs().maxCoeff();
  for (Eigen::Index i = 0; i < slope.size(); ++i) {
    const double difference = bundle.cost(with_move(scene.start, i, h)) - bundle.cost(with_move(scene.start, i, -h));
    CHECK(std::abs(slope[i] - difference / (2 * h)) < 1e-6 * slope.norm());
    for (Eigen::Index j = 0; j <= i; ++j) {
      const auto at = [&](double a, double b) { return cost_at(bundle, scene.start, i, a, j, b); };
      const double second = (at(h2, h2) - at(h2, -h2) - at(-h2, h2) + at(-h2, -h2)) / (4 * h2 * h2);
      CAPTURE(i, j);
      CHECK(std::abs(curvature(i, j) - second) < 1e-5 * largest);
    }
  }
}

TEST_CASE("plane bundle: increments and priors that disagree have the slope of central differences") {
  Uniform uniform(4);
  PlaneBundle bundle({});
  const std::vector<Pose> poses = walk(2);
  for (const Pose& pose : poses) bundle.add_pose(pose);
  Mat6 known = information(0.1, 0.2);
  known(0, 4) = known(4, 0) = 3.0;
  bundle.add_increment(0, 1, (poses[0].inverse() * poses[1]).moved(any(uniform, 0.5, 0.5)), known);
  bundle.add_prior(0, poses[0].moved(any(uniform, 0.5, 0.5)), known);
  Eigen::VectorXd slope;
  Eigen::MatrixXd curvature;
  bundle.linearise(poses, slope, curvature);
  constexpr double h = 1e-5;
  for (Eigen::Index i = 0; i < slope.size(); ++i) {
    const double difference = bundle.cost(with_move(poses, i, h)) - bundle.cost(with_move(poses, i, -h));
    CHECK(std::abs(slope[i] - difference / (2 * h)) < 1e-6 * slope.norm());
  }
}

TEST_CASE("plane bundle: a room without noise is found to a micrometre") {
  Scene scene(walk(12), kRoom, 0.0);
  PlaneBundle bundle({.max_iterations = 30, .converged = 1e-10});
  scene.load(bundle, 0.03, 0.05, 0.02);
  bundle.add_prior(0, scene.truth[0], information(1e-6, 1e-6));
  const auto result = bundle.solve();
  CHECK(result.outcome == Outcome::converged);
  CHECK(result.before > 1000.0);
  CHECK(result.after < 1e-6);
  const auto [shift, turn] = scene.error(bundle.poses());
  CHECK(shift < 1e-6);
  CHECK(turn < 1e-6);
}

TEST_CASE("plane bundle: with noise the error falls to what the points tell") {
  constexpr double half = 0.03;  // of an even distribution [m]
  const double sigma = half / std::sqrt(3.0);
  Scene scene(walk(12), kRoom, half);
  PlaneBundle bundle({.max_iterations = 30});
  scene.load(bundle, 0.03, 0.05, sigma);
  bundle.add_prior(0, scene.truth[0], information(1e-6, 1e-6));
  const auto result = bundle.solve();
  CHECK(result.outcome == Outcome::converged);
  const auto [shift, turn] = scene.error(bundle.poses());
  // 50 points on each of six walls: sigma / sqrt(100) along an axis, and the wall of the first keyframe as much again.
  CHECK(shift < 2.0 * std::sqrt(6.0) * sigma / 10.0);
  CHECK(turn < 0.005);
  // 12 keyframes x 6 walls x 50 points, less 3 unknowns per wall and 6 per keyframe but the first.
  const double rows = 12 * 6 * 50 - 6 * 3 - 6 * 11;
  CHECK(result.after == Approx(rows).epsilon(0.08));
}

TEST_CASE("plane bundle: points that do not move hold the poses that see their planes") {
  Scene scene(walk(4), kRoom, 0.0);
  PlaneBundle bundle({.max_iterations = 30, .converged = 1e-10});
  Uniform uniform(8);
  for (const Pose& pose : scene.truth) bundle.add_pose(pose.moved(any(uniform, 0.02, 0.05)));
  for (const auto& clusters : scene.planes) {
    const PointMoments fixed = clusters[0].points.moved(scene.truth[0]);
    bundle.add_plane(fixed.weighted(1e4), std::vector(clusters.begin() + 1, clusters.end()));
  }
  bundle.add_prior(0, scene.truth[0], information(1, 1));
  CHECK(bundle.solve().outcome == Outcome::converged);
  CHECK(scene.error(bundle.poses()).first < 1e-6);
}

TEST_CASE("plane bundle: what one floor does not tell stays at the prior") {
  Scene scene(walk(3), {kRoom[5]}, 0.0);
  // The floor is told to lie 0.1 m lower, and nothing else is known but where the poses were.
  PointMoments fixed;
  Uniform uniform(2);
  for (int i = 0; i < 100; ++i)
    fixed.add(uniform.in_box(Vec3(0, 0, 0), 2.0).cwiseProduct(Vec3(1, 1, 0)) + Vec3(0, 0, -1.1));
  PlaneBundle moved({.max_iterations = 50, .converged = 1e-12});
  for (std::uint32_t i = 0; i < 3; ++i) {
    moved.add_pose(scene.truth[i]);
    moved.add_prior(i, scene.truth[i], information(1.0, 1.0));
  }
  for (std::uint32_t i = 0; i < 3; ++i)
    moved.add_plane(fixed.weighted(1e8), std::vector{PlaneBundle::Cluster{i, scene.planes[0][i].points.weighted(1e4)}});
  CHECK(moved.solve().outcome == Outcome::converged);
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 shift = moved.poses()[i].p - scene.truth[i].p;
    CHECK(shift.head<2>().norm() < 1e-4);
    CHECK(shift.z() == Approx(-0.1).epsilon(1e-3));
    CHECK(log_so3(scene.truth[i].R.transpose() * moved.poses()[i].R).norm() < 1e-3);
  }
}

TEST_CASE("plane bundle: an unknown that nothing holds ends it, and the poses stay") {
  PlaneBundle bundle({});
  const std::vector<Pose> poses = walk(2);
  for (const Pose& pose : poses) bundle.add_pose(pose);
  bundle.add_prior(0, poses[0], information(1, 1));
  CHECK(bundle.solve().outcome == Outcome::failed);
  for (std::size_t i = 0; i < 2; ++i) CHECK(bundle.poses()[i].p == poses[i].p);
}

TEST_CASE("plane bundle: nothing, too little and what is not a number give finite poses") {
  PlaneBundle bundle({});
  CHECK(bundle.solve().outcome == Outcome::converged);
  CHECK(bundle.poses().empty());

  bundle.add_pose({});
  bundle.add_prior(0, {}, information(0.1, 0.1));
  bundle.add_plane({}, {});
  PointMoments one, line;
  one.add(Vec3(1, 2, 3));
  for (int i = 0; i < 5; ++i) line.add(Vec3(i, 0, 0));
  bundle.add_plane({}, std::vector{PlaneBundle::Cluster{0, one}});
  bundle.add_plane({}, std::vector{PlaneBundle::Cluster{0, line}});
  const auto result = bundle.solve();
  CHECK(result.after == 0);
  CHECK(bundle.poses()[0].p.norm() == 0);

  line.add(Vec3::Constant(std::numeric_limits<double>::quiet_NaN()));
  bundle.add_plane({}, std::vector{PlaneBundle::Cluster{0, line}});
  bundle.solve();
  CHECK(bundle.poses()[0].p.allFinite());

  bundle.clear();
  CHECK(bundle.planes() == 0);
  bundle.add_pose({Mat3::Identity(), Vec3::Constant(std::numeric_limits<double>::infinity())});
  bundle.add_prior(0, {}, information(0.1, 0.1));
  CHECK(bundle.solve().outcome == Outcome::failed);
}

TEST_CASE("plane bundle: the same input gives the same bits, in fresh storage and in used one") {
  PlaneBundle used({});
  std::vector<Pose> first;
  for (int run = 0; run < 2; ++run) {
    Scene scene(walk(6), kRoom, 0.02);
    used.clear();
    scene.load(used, 0.01, 0.02, 0.02);
    used.add_prior(0, scene.truth[0], information(1e-3, 1e-3));
    used.solve();
    if (run == 0) first = used.poses();
  }
  for (std::size_t i = 0; i < first.size(); ++i) {
    CHECK(first[i].p == used.poses()[i].p);
    CHECK(first[i].R == used.poses()[i].R);
  }
}
