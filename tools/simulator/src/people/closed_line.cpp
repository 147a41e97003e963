#include "aslio/simulator/closed_line.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace aslio::simulator {
namespace {

constexpr double kFine = 0.01;            ///< sampling while the line is made [m]
constexpr double kKnotSpacing = 0.1;      ///< [m], at most
constexpr std::size_t kFewestKnots = 64;  ///< of a short line

Vec2 left_of(const Vec2& direction) { return {-direction.y(), direction.x()}; }

Vec2 rotated(const Vec2& v, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  return {c * v.x() - s * v.y(), s * v.x() + c * v.y()};
}

/// `count` points at equal distances along a closed polygon.
std::vector<Vec2> resampled(const std::vector<Vec2>& polygon, std::size_t count) {
  std::vector<double> along{0};
  for (std::size_t k = 0; k < polygon.size(); ++k)
    along.push_back(along.back() + (polygon[(k + 1) % polygon.size()] - polygon[k]).norm());
  std::vector<Vec2> points;
  points.reserve(count);
  std::size_t edge = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const double s = along.back() * static_cast<double>(k) / static_cast<double>(count);
    while (edge + 1 < polygon.size() && along[edge + 1] <= s) ++edge;
    const Vec2 &a = polygon[edge], &b = polygon[(edge + 1) % polygon.size()];
    points.push_back(a + (s - along[edge]) / (along[edge + 1] - along[edge]) * (b - a));
  }
  return points;
}

double length_of(const std::vector<Vec2>& polygon) {
  double length = 0;
  for (std::size_t k = 0; k < polygon.size(); ++k) length += (polygon[(k + 1) % polygon.size()] - polygon[k]).norm();
  return length;
}

/// Each point becomes the mean of those up to `reach` places away.
std::vector<Vec2> averaged(const std::vector<Vec2>& points, std::size_t reach) {
  const std::size_t n = points.size();
  const double width = static_cast<double>(2 * reach + 1);
  Vec2 sum = Vec2::Zero();
  for (std::size_t k = 0; k < 2 * reach + 1; ++k) sum += points[(n + k - reach) % n];
  std::vector<Vec2> means;
  means.reserve(n);
  for (std::size_t k = 0; k < n; ++k) {
    means.push_back(sum / width);
    sum += points[(k + reach + 1) % n] - points[(n + k - reach) % n];
  }
  return means;
}

}  // namespace

ClosedLine::ClosedLine(const std::vector<Vec2>& polygon, double rounding, const Ground& ground) {
  const auto pieces = [](double length, double spacing) {
    return static_cast<std::size_t>(std::ceil(length / spacing));
  };
  std::vector<Vec2> points = resampled(polygon, pieces(length_of(polygon), kFine));
  // Twice over half the reach: direction and curvature become continuous.
  const std::size_t reach = std::min(static_cast<std::size_t>(0.5 * rounding / kFine), points.size() / 4);
  if (reach > 0) points = averaged(averaged(points, reach), reach);

  const double length = length_of(points);
  points = resampled(points, std::max(pieces(length, kKnotSpacing), kFewestKnots));
  const std::size_t n = points.size();
  spacing_ = length / static_cast<double>(n);
  knots_.resize(n);
  for (std::size_t k = 0; k < n; ++k) knots_[k].at << points[k], ground.height(points[k].x(), points[k].y());
  for (std::size_t k = 0; k < n; ++k) knots_[k].slope = 0.5 * (knots_[(k + 1) % n].at - knots_[(n + k - 1) % n].at);
}

ClosedLine::Place ClosedLine::at(double s) const {
  const double n = static_cast<double>(knots_.size());
  double u = s / spacing_;
  u -= n * std::floor(u / n);
  const std::size_t k = std::min(static_cast<std::size_t>(u), knots_.size() - 1);
  const Knot &a = knots_[k], &b = knots_[k + 1 == knots_.size() ? 0 : k + 1];
  const double f = u - static_cast<double>(k);
  const Vec3 step = b.at - a.at;
  const Vec3 square = 3 * step - 2 * a.slope - b.slope, cube = a.slope + b.slope - 2 * step;
  const Vec3 tangent = a.slope + f * (2 * square + 3 * f * cube);
  return {a.at + f * (a.slope + f * (square + f * cube)), tangent.head<2>().normalized()};
}

double ClosedLine::nearest(const Vec2& p, const Vec2& direction) const {
  double best = std::numeric_limits<double>::infinity();
  std::size_t at = 0;
  for (std::size_t k = 0; k < knots_.size(); ++k) {
    const double distance = (knots_[k].at.head<2>() - p).norm();
    if (distance < best && knots_[k].slope.head<2>().dot(direction) > 0) {
      best = distance;
      at = k;
    }
  }
  return spacing_ * static_cast<double>(at);
}

std::vector<Vec2> beside(const Route& route, double lateral) {
  constexpr double kInsideMost = 0.75 * std::numbers::pi;  // sharper ones are walked round
  constexpr double kArcStep = 0.15;                        // [rad]
  const std::vector<Vec2>& p = route.points();
  const double side = lateral < 0 ? -1 : 1;
  std::vector<Vec2> line;
  for (std::size_t k = 0; k < p.size(); ++k) {
    const Vec2 before = p[k] - p[(k + p.size() - 1) % p.size()], after = p[(k + 1) % p.size()] - p[k];
    const Vec2 from = before.normalized(), to = after.normalized();
    double turn = std::atan2(from.x() * to.y() - from.y() * to.x(), from.dot(to));
    if (side * turn > 0 && side * turn < kInsideMost) {
      const double cut =
          std::min(std::abs(lateral) * std::tan(0.5 * std::abs(turn)), 0.45 * std::min(before.norm(), after.norm()));
      line.push_back(p[k] - cut * from + lateral * left_of(from));
      line.push_back(p[k] + cut * to + lateral * left_of(to));
      continue;
    }
    if (side * turn > 0) turn -= side * 2 * std::numbers::pi;
    const auto steps = static_cast<int>(std::ceil(std::abs(turn) / kArcStep));
    line.push_back(p[k] + lateral * left_of(from));
    for (int i = 1; i <= steps; ++i) line.push_back(p[k] + lateral * rotated(left_of(from), turn * i / steps));
  }
  return line;
}

}  // namespace aslio::simulator
