#include "aslio/simulator/route.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "aslio/core/errors.hpp"

namespace aslio::simulator {
namespace {

constexpr double kShortestEdge = 1;  ///< [m]

}  // namespace

Route::Route(std::vector<Vec2> points) : points_(std::move(points)) {
  if (points_.size() < 2)
    throw ConfigError(fmt::format("route: has {} points, needs at least 2: the start and one more", points_.size()));
  for (std::size_t k = 0; k < points_.size(); ++k) {
    const Vec2 &a = points_[k], &b = points_[(k + 1) % points_.size()];
    const double edge = (b - a).norm();
    if (!(edge >= kShortestEdge && std::isfinite(edge)))
      throw ConfigError(
          fmt::format("route: edge {} from ({:g}, {:g}) to ({:g}, {:g}) is {:.3g} m long, must be at least {} m: use a "
                      "larger scale or fewer points (the last edge leads back to the start)",
                      k + 1, a.x(), a.y(), b.x(), b.y(), edge, kShortestEdge));
    start_of_edge_.push_back(length_);
    length_ += edge;
  }
}

Route::Place Route::at(double s) const {
  double on_round = std::fmod(s, length_);
  if (on_round < 0) on_round += length_;
  const auto next = std::upper_bound(start_of_edge_.begin(), start_of_edge_.end(), on_round);
  const auto k = static_cast<std::size_t>(next - start_of_edge_.begin() - 1);
  const Vec2 &a = points_[k], &b = points_[(k + 1) % points_.size()];
  const Vec2 direction = (b - a).normalized();
  return {a + (on_round - start_of_edge_[k]) * direction, direction};
}

double Route::distance(const Vec2& p) const {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < points_.size(); ++k) {
    const Vec2& a = points_[k];
    const Vec2 edge = points_[(k + 1) % points_.size()] - a;
    const double u = std::clamp((p - a).dot(edge) / edge.squaredNorm(), 0.0, 1.0);
    nearest = std::min(nearest, (p - a - u * edge).norm());
  }
  return nearest;
}

Vec2 Route::low() const {
  Vec2 corner = points_.front();
  for (const Vec2& p : points_) corner = corner.cwiseMin(p);
  return corner;
}

Vec2 Route::high() const {
  Vec2 corner = points_.front();
  for (const Vec2& p : points_) corner = corner.cwiseMax(p);
  return corner;
}

}  // namespace aslio::simulator
