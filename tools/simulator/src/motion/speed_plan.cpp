#include "speed_plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "aslio/core/errors.hpp"
#include "bisection.hpp"

namespace aslio::simulator {
namespace {

constexpr double kSmoothRide = 5;     ///< change of the acceleration, at most [m/s^3]
constexpr double kSamePlace = 1e-3;   ///< nodes nearer than this are one [m]
constexpr double kSpeedSlack = 1e-6;  ///< [m/s]

}  // namespace

SpeedPlan::SpeedPlan(const RoadLine& road, const DriveParams& params) : params_(params) {
  stretches_ = stretches(road);
  set_nodes(road);
  limit_nodes();
  pieces_.push_back({0, params_.start_speed > 0 ? 0 : params_.standstill, 0, params_.start_speed, params_.start_speed});
  for (std::size_t k = 0; k + 1 < nodes_.size(); ++k) drive_between(nodes_[k], nodes_[k + 1]);
}

/// Where the car may not go as fast as on free straights.
std::vector<SpeedPlan::Stretch> SpeedPlan::stretches(const RoadLine& road) const {
  std::vector<Stretch> all;
  for (const RoadLine::Bend& bend : road.bends())
    all.push_back({bend.begin, bend.begin + bend.length, std::sqrt(params_.lateral_acceleration * bend.radius())});
  for (const SpeedLimit& limit : params_.limits)
    all.push_back({limit.from * road.length(), limit.to * road.length(), limit.speed});
  return all;
}

double SpeedPlan::free_speed(double at) const {
  double speed = params_.speed;
  for (const Stretch& stretch : stretches_)
    if (stretch.from <= at && at <= stretch.to) speed = std::min(speed, stretch.speed);
  return speed;
}

void SpeedPlan::set_nodes(const RoadLine& road) {
  std::vector<Node> all;
  for (std::size_t k = 0; k < params_.stops.size(); ++k) {
    const double at = params_.stops[k].at * road.length();
    for (const RoadLine::Bend& bend : road.bends())
      if (bend.begin < at && at < bend.begin + bend.length)
        throw ConfigError(fmt::format(
            "drive.stops[{}].at: {:g} of the road is in a bend, from {:.3f} to {:.3f} of it; "
            "stop on a straight",
            k, params_.stops[k].at, bend.begin / road.length(), (bend.begin + bend.length) / road.length()));
    all.push_back({at, params_.stops[k].hold, 0});
  }
  for (const Stretch& stretch : stretches_)
    for (const double at : {stretch.from, stretch.to})
      if (at > kSamePlace && at < road.length() - kSamePlace) all.push_back({at, 0, free_speed(at)});
  // Stops first: of two nodes in one place the first stays.
  std::stable_sort(all.begin(), all.end(), [](const Node& a, const Node& b) { return a.at < b.at; });
  nodes_.push_back({0, 0, std::min(params_.start_speed, free_speed(0))});
  for (const Node& node : all) {
    if (node.at - nodes_.back().at > kSamePlace) {
      nodes_.push_back(node);
    } else if (nodes_.size() > 1) {
      nodes_.back().most = std::min(nodes_.back().most, node.most);
      nodes_.back().hold += node.hold;
    }
  }
  nodes_.push_back({road.length(), params_.end_speed > 0 ? 0 : params_.standstill,
                    std::min(params_.end_speed, free_speed(road.length()))});
}

double SpeedPlan::time(double from, double to) const {
  // The step's first and second derivatives peak at 15/8 and 10/sqrt(3).
  const double change = std::abs(to - from);
  return std::max(1.875 * change / params_.acceleration, std::sqrt(10 / std::numbers::sqrt3 * change / kSmoothRide));
}

/// The highest speed up to `limit` that can be had, or lost, within `length` metres.
double SpeedPlan::fastest(double from, double length, double limit) const {
  if (limit <= from) return limit;
  return highest(from, limit, [&](double v) { return distance(from, v) <= length; });
}

void SpeedPlan::limit_nodes() {
  for (std::size_t k = 0; k + 1 < nodes_.size(); ++k)
    nodes_[k + 1].most = fastest(nodes_[k].most, nodes_[k + 1].at - nodes_[k].at, nodes_[k + 1].most);
  for (std::size_t k = nodes_.size() - 1; k-- > 0;)
    nodes_[k].most = fastest(nodes_[k + 1].most, nodes_[k + 1].at - nodes_[k].at, nodes_[k].most);
  if (nodes_.front().most < params_.start_speed - kSpeedSlack)
    throw ConfigError(
        fmt::format("drive.start_speed: is {:g} m/s, the car can slow down in time for this road from at most {:.3g}; "
                    "raise speed or limits, or move the first bend or stop away",
                    params_.start_speed, nodes_.front().most));
}

void SpeedPlan::add(double duration, double from, double to) {
  if (duration <= 0) return;
  const SpeedPiece& last = pieces_.back();
  const double way = last.way + 0.5 * (last.from + last.to) * last.duration;
  pieces_.push_back({last.t + last.duration, duration, way, from, to});
}

/// Up to the free speed as far as there is room, and down to what the next place allows.
void SpeedPlan::drive_between(const Node& from, const Node& to) {
  const double length = to.at - from.at, low = std::max(from.most, to.most);
  const double limit = std::max(low, free_speed(0.5 * (from.at + to.at)));
  const double top =
      highest(low, limit, [&](double v) { return distance(from.most, v) + distance(v, to.most) <= length; });
  add(time(from.most, top), from.most, top);
  const double steady = length - distance(from.most, top) - distance(top, to.most);
  if (top > 0) add(steady / top, top, top);
  add(time(top, to.most), top, to.most);
  add(to.hold, to.most, to.most);
}

const SpeedPiece& SpeedPlan::piece(double t) const {
  const auto later = [](double time, const SpeedPiece& piece) { return time < piece.t; };
  return std::upper_bound(pieces_.begin() + 1, pieces_.end(), t, later)[-1];
}

Jet SpeedPlan::way(double t) const {
  const SpeedPiece& p = piece(t);
  const double since = t - p.t, change = p.to - p.from;
  if (since <= 0) return {p.way + p.from * since, p.from, 0};
  if (since >= p.duration) {
    const double end = p.way + 0.5 * (p.from + p.to) * p.duration;
    return {end + p.to * (since - p.duration), p.to, 0};
  }
  const double u = since / p.duration, u2 = u * u, rest = 1 - u;
  return {p.way + p.duration * (p.from * u + change * u2 * u2 * (2.5 - 3 * u + u2)),
          p.from + change * u2 * u * (10 - 15 * u + 6 * u2), change / p.duration * 30 * u2 * rest * rest};
}

double SpeedPlan::time_at(double at) const {
  return highest(0, duration(), [&](double t) { return way(t).x < at; });
}

}  // namespace aslio::simulator
