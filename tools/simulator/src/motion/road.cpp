#include "aslio/simulator/road.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "aslio/core/angles.hpp"
#include "aslio/core/errors.hpp"
#include "jet.hpp"

namespace aslio::simulator {
namespace {

constexpr double kSharpest = 150 * kRadPerDeg;
constexpr double kNoBend = 1e-9;       ///< corners below this angle are straight on [rad]
constexpr double kBendKnot = 0.5;      ///< distance of the knots of a bend, at most [m]
constexpr double kShortestRoad = 1;    ///< of an edge [m]
constexpr double kShareOfEdge = 0.49;  ///< that one bend may take

/// Gauss-Legendre of four nodes over [0, 1]: on half a metre of a bend exact to rounding.
constexpr std::array<double, 4> kNodes = {0.0694318442029737, 0.3300094782075719, 0.6699905217924281,
                                          0.9305681557970263};
constexpr std::array<double, 4> kWeights = {0.1739274225687269, 0.3260725774312731, 0.3260725774312731,
                                            0.1739274225687269};

/// Heading within a bend and its derivatives by the way.
Jet heading_within(double heading, double angle, double length, double along) {
  return Jet{heading, 0, 0} + angle * smooth_step({along / length, 1 / length, 0});
}

/// The way from `from` to `to` along a bend, as a vector.
Vec2 moved_within(double heading, double angle, double length, double from, double to) {
  Vec2 sum = Vec2::Zero();
  for (std::size_t k = 0; k < kNodes.size(); ++k) {
    const double theta = heading_within(heading, angle, length, from + kNodes.at(k) * (to - from)).x;
    sum += kWeights.at(k) * Vec2(std::cos(theta), std::sin(theta));
  }
  return (to - from) * sum;
}

/// Chord of a bend, share of its length.
double chord(double angle) {
  constexpr int kParts = 64;
  double sum = 0;
  for (int k = 0; k < kParts; ++k)
    sum +=
        moved_within(-0.5 * angle, angle, 1, static_cast<double>(k) / kParts, static_cast<double>(k + 1) / kParts).x();
  return sum;
}

}  // namespace

double RoadLine::Bend::radius() const { return length / (kPeak * std::abs(angle)); }

Vec2 RoadLine::Place::beside(double lateral) const {
  return at + lateral * Vec2(-std::sin(heading), std::cos(heading));
}

RoadLine::RoadLine(const std::vector<Vec2>& points, double bend_radius) {
  if (points.size() < 2) throw ConfigError(fmt::format("route: has {} points, a road needs at least 2", points.size()));
  std::vector<double> edges, headings;
  for (std::size_t k = 0; k + 1 < points.size(); ++k) {
    const Vec2 edge = points[k + 1] - points[k];
    if (!(edge.norm() >= kShortestRoad && std::isfinite(edge.norm())))
      throw ConfigError(fmt::format("route: edge {} of the road is {:.3g} m long, must be at least {} m", k + 1,
                                    edge.norm(), kShortestRoad));
    edges.push_back(edge.norm());
    headings.push_back(std::atan2(edge.y(), edge.x()));
  }
  end_ = points.front();
  heading_ = headings.front();
  double taken = 0;  // of the edge, by the bend before it
  for (std::size_t k = 0; k + 1 < edges.size(); ++k) {
    const double angle = std::remainder(headings[k + 1] - headings[k], 2 * std::numbers::pi);
    if (std::abs(angle) > kSharpest)
      throw ConfigError(
          fmt::format("route: the corner at point {} of the road turns by {:.0f} deg, at most 150 can be "
                      "driven",
                      k + 2, std::abs(angle) / kRadPerDeg));
    if (std::abs(angle) < kNoBend) {
      add_straight(edges[k] - taken);
      taken = 0;
      continue;
    }
    // From the corner to both ends of the bend, per metre of its length.
    const double reach = 0.5 * chord(angle) / std::cos(0.5 * angle);
    const double length =
        std::min(kPeak * std::abs(angle) * bend_radius, kShareOfEdge * std::min(edges[k], edges[k + 1]) / reach);
    add_straight(edges[k] - taken - length * reach);
    add_bend(length, angle);
    taken = length * reach;
  }
  add_straight(edges.back() - taken);
}

void RoadLine::add_straight(double length) {
  pieces_.push_back({length_, length, heading_, 0, end_, {}});
  length_ += length;
  end_ += length * Vec2(std::cos(heading_), std::sin(heading_));
}

void RoadLine::add_bend(double length, double angle) {
  Piece piece{length_, length, heading_, angle, end_, {}};
  const auto count = static_cast<std::size_t>(std::ceil(length / kBendKnot));
  const double step = length / static_cast<double>(count);
  for (std::size_t k = 0; k < count; ++k) {
    piece.knots.push_back(end_);
    const double from = step * static_cast<double>(k);
    end_ += moved_within(heading_, angle, length, from, from + step);
  }
  bends_.push_back({length_, length, angle});
  pieces_.push_back(std::move(piece));
  length_ += length;
  heading_ += angle;
}

RoadLine::Place RoadLine::on(const Piece& piece, double along) const {
  if (piece.knots.empty()) {
    return {piece.from + along * Vec2(std::cos(piece.heading), std::sin(piece.heading)), piece.heading, 0, 0};
  }
  const double step = piece.length / static_cast<double>(piece.knots.size());
  const auto k = std::min(static_cast<std::size_t>(along / step), piece.knots.size() - 1);
  const Jet heading = heading_within(piece.heading, piece.angle, piece.length, along);
  return {piece.knots[k] + moved_within(piece.heading, piece.angle, piece.length, step * static_cast<double>(k), along),
          heading.x, heading.d, heading.dd};
}

RoadLine::Place RoadLine::at(double s) const {
  const auto later = [](double way, const Piece& piece) { return way < piece.begin; };
  const auto next = std::upper_bound(pieces_.begin() + 1, pieces_.end(), s, later);
  return on(next[-1], s - next[-1].begin);
}

}  // namespace aslio::simulator
