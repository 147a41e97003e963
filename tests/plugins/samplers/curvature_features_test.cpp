// Edges and planes on scan lines whose shape is known, and against the definition written out.
#include "samplers/curvature_features.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>

#include "plugins/build_environment.hpp"
#include "plugins/samplers/batch.hpp"
#include "samplers/voxel.hpp"

namespace aslio {
namespace {

using plugins::CurvatureFeatures;
constexpr std::uint8_t kClear = feature_class::clearest, kLine = feature_class::line, kPlane = feature_class::plane;

struct Scan : test::Batch {
  std::vector<std::uint8_t> features;
  void point(const Eigen::Vector3f& p, std::uint8_t line = 0) {
    add(p);
    raw.back().line = line;
    raw.back().t = static_cast<TimeNs>(raw.size());
    features.push_back(feature_class::none);
  }
  /// Beams each 0.25 deg over 90 deg, `range` [m] of the angle [rad] from -45 deg; nothing where it is 0.
  void sweep(const std::function<double(double)>& range, std::uint8_t line = 0) {
    for (int i = -180; i <= 180; ++i) {
      const double angle = i * 0.25 * 3.14159265358979 / 180.0, r = range(angle);
      if (r > 0) point(Eigen::Vector3d(r * std::cos(angle), r * std::sin(angle), 0.1 * line).cast<float>(), line);
    }
  }
  void classify(const CurvatureFeatures::Params& params) {
    test::BuildEnvironment environment;
    CurvatureFeatures sampler(params, environment.context());
    SampleBatch batch = view();
    batch.features = features;
    sampler.sample(batch);
  }
  std::vector<std::size_t> of(std::uint8_t feature) const {
    std::vector<std::size_t> found;
    for (std::size_t i = 0; i < features.size(); ++i) {
      if ((features[i] & feature) == feature) found.push_back(i);
    }
    return found;
  }
  float y(std::size_t i) const { return raw[i].y; }
};

CurvatureFeatures::Params one_sector() {
  CurvatureFeatures::Params params;
  params.sectors = 1;
  return params;
}

/// Two walls that meet at right angles in (4, 0).
double corner(double angle) { return 4.0 / (std::cos(angle) + std::abs(std::sin(angle))); }

/// A board at x = 3 for |y| <= 0.5 in front of a wall that comes nearer to the sides: where the board hides it, it
/// bends more than the board does.
double board(double angle) {
  const double at_board = 3.0 / std::cos(angle);
  return std::abs(at_board * std::sin(angle)) <= 0.5 ? at_board : 6.5 - 5.0 * std::abs(angle);
}

/// FEA-1 as it is written.
double bend(const Scan& scan, std::size_t i, std::size_t s) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  const auto p = [&](std::size_t j) {
    return Eigen::Vector3d(scan.raw[j].x, scan.raw[j].y, static_cast<double>(scan.raw[j].z));
  };
  for (std::size_t j = i - s; j <= i + s; ++j) sum += p(j) - p(i);
  return sum.squaredNorm();
}

}  // namespace

TEST_CASE("the corner of two walls is a line, and the walls are planes") {  // eq. FEA-1
  Scan scan;
  scan.sweep(corner);
  scan.classify(one_sector());
  const auto lines = scan.of(kLine), clearest = scan.of(kLine | kClear);
  REQUIRE(clearest.size() == 1);
  CHECK(std::abs(scan.y(clearest[0])) < 0.02F);
  for (const std::size_t i : lines) CHECK(std::abs(scan.y(i)) < 0.15F);
  const auto planes = scan.of(kPlane);
  CHECK(planes.size() > 300);
  CHECK(scan.of(kPlane | kClear).size() == 4);
  for (const std::size_t i : planes) CHECK(bend(scan, i, 5) < 0.1);
  // The first and the last five have no neighbours on one side.
  CHECK(scan.features.front() == feature_class::none);
  CHECK((scan.uses.front() & mask(PointUse::map)) == 0);
  CHECK((scan.uses.front() & mask(PointUse::overlap)) != 0);
  CHECK((scan.uses[lines[0]] & mask(PointUse::match)) != 0);
}

TEST_CASE("the border of what is in front is a line, that of the wall behind it is none") {  // eq. FEA-2
  Scan scan;
  scan.sweep(board);
  scan.classify(one_sector());
  const auto lines = scan.of(kLine);
  REQUIRE(lines.size() == 2);  // its two borders
  for (const std::size_t i : lines) {
    CHECK(scan.raw[i].x == Approx(3.0));
    CHECK(std::abs(scan.y(i)) > 0.45F);
  }
  Scan open;
  open.sweep(board);
  CurvatureFeatures::Params params = one_sector();
  params.occlusion = 10.0;
  open.classify(params);
  const auto all = open.of(kLine);
  CHECK(std::any_of(all.begin(), all.end(), [&](std::size_t i) { return open.raw[i].x > 5.0F; }));
}

TEST_CASE("a surface along the beam, and a lone return, are no features") {  // eq. FEA-2
  // A wall that the beams all but graze: y = 0.4, seen up to 40 m.
  const auto grazed = [](double angle) { return angle > 0.01 && angle < 0.3 ? 0.4 / std::sin(angle) : 0.0; };
  Scan scan;
  scan.sweep(grazed);
  CurvatureFeatures::Params params = one_sector();
  params.occlusion = 100.0;
  scan.classify(params);
  for (const std::size_t i : scan.of(kClear)) {
    const double angle = std::atan2(static_cast<double>(scan.y(i)), static_cast<double>(scan.raw[i].x));
    CHECK(0.25 * 3.14159265 / 180.0 / std::tan(angle) < 0.021);  // change of range per beam
  }
  Scan lone;
  lone.sweep([](double angle) { return std::abs(angle) < 1e-6 ? 5.0 : 6.0; });
  params.occlusion = 0.3;
  lone.classify(params);
  CHECK(lone.of(kLine).empty());
}

TEST_CASE("each sector gives no more than its share, the clearest first and none beside another") {
  CurvatureFeatures::Params params;
  params.lines = 3;
  params.clearest_lines = 1;
  params.clearest_planes = 2;
  params.occlusion = 100.0;
  params.parallel = 10.0;
  Scan scan;
  std::mt19937_64 random(4);
  for (std::uint8_t line = 0; line < 4; ++line) {
    scan.sweep([&](double) { return 5.0 + 0.2 * static_cast<double>(random() % 1000) / 1000.0; }, line);
  }
  scan.classify(params);
  std::size_t left_out = 0;
  for (std::size_t line = 0; line < 4; ++line) {
    const std::size_t first = 361 * line, s = 5, inner = 361 - 2 * s;
    std::size_t last_line = 0;
    for (std::size_t k = 0; k < 6; ++k) {
      const std::size_t begin = first + s + inner * k / 6, end = first + s + inner * (k + 1) / 6;
      std::size_t lines = 0, clear = 0, flat = 0;
      double least_picked = 1e9, sharpest = 0;
      for (std::size_t i = begin; i < end; ++i) {
        const double bent = bend(scan, i, s);
        if ((scan.features[i] & kPlane) != 0) CHECK(bent < 0.1);
        flat += (scan.features[i] & (kPlane | kClear)) == (kPlane | kClear) ? 1 : 0;
        if ((scan.features[i] & kLine) == 0) continue;
        if (last_line != 0) CHECK(i > last_line + s);
        last_line = i;
        ++lines;
        CHECK(bent > 0.1);
        least_picked = std::min(least_picked, bent);
        if ((scan.features[i] & kClear) != 0) {
          ++clear;
          sharpest = bent;
        }
      }
      CHECK(lines <= 3);
      CHECK(clear == std::min<std::size_t>(lines, 1));
      CHECK(flat <= 2);
      for (std::size_t i = begin; i < end; ++i) {
        if ((scan.features[i] & kLine) != 0) CHECK(bend(scan, i, s) <= sharpest * (1 + 1e-4));
      }
      // What was left out, though not beside one that was taken, bends less than those.
      for (std::size_t i = begin; i < end && lines == 3; ++i) {
        bool beside = false;
        for (std::size_t j = i - s; j <= i + s; ++j) beside = beside || (scan.features[j] & kLine) != 0;
        if (beside) continue;
        CHECK(bend(scan, i, s) <= least_picked * (1 + 1e-4));
        ++left_out;
      }
    }
  }
  CHECK(scan.of(kLine).size() > 40);
  CHECK(left_out > 100);
}

TEST_CASE("scan lines are told apart, however their points come mixed") {
  Scan mixed, apart;
  for (int i = -180; i <= 180; ++i) {
    const double angle = i * 0.25 * 3.14159265358979 / 180.0;
    for (std::uint8_t line = 0; line < 3; ++line) {
      const double r = line == 1 ? corner(angle) : 6.0 / std::cos(angle);
      mixed.point(Eigen::Vector3d(r * std::cos(angle), r * std::sin(angle), 0.1 * line).cast<float>(), line);
    }
  }
  apart.sweep(corner, 1);
  mixed.classify(one_sector());
  apart.classify(one_sector());
  for (std::size_t i = 0; i < 361; ++i) {
    REQUIRE(mixed.features[3 * i + 1] == apart.features[i]);
    REQUIRE((mixed.features[3 * i] & kLine) == 0);
  }
}

TEST_CASE("voxels of one class leave the other alone, and keep the clearest") {
  Scan scan;
  for (int i = 0; i < 100; ++i) scan.point({0.5F + 0.001F * static_cast<float>(i), 0.5F, 0.5F});
  for (std::size_t i = 0; i < 100; ++i) scan.features[i] = i < 50 ? kLine : kPlane;
  scan.features[90] = kPlane | kClear;
  test::BuildEnvironment environment;
  plugins::VoxelSampler::Params params;
  params.leaf = 1.0;
  params.of = plugins::VoxelSampler::Of::plane;
  plugins::VoxelSampler sampler(params, environment.context());
  SampleBatch batch = scan.view();
  batch.features = scan.features;
  sampler.sample(batch);
  CHECK(scan.count(PointUse::match) == 51);
  CHECK((scan.uses[90] & mask(PointUse::match)) != 0);
}

}  // namespace aslio
