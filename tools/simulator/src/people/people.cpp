#include "aslio/simulator/people.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "aslio/config/binder.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/simulator/random.hpp"
#include "purposes.hpp"

namespace aslio::simulator {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr double kRounding = 0.8;      ///< of corners of a walker's line [m]
constexpr double kSpacingAhead = 1.5;  ///< [m]
constexpr double kBeyond = 0.1;        ///< crossing ones go this much farther from the line than walking ones [m]
constexpr double kHalfWidth = 0.35;    ///< of the loop of a crossing one, along the route [m]
constexpr int kAttempts = 200;
/// Who is drawn from which part of the stream.
constexpr std::uint64_t kWalking = 0, kAhead = 1'000'000, kCrossing = 2'000'000;

[[noreturn]] void fail(std::string_view key, std::size_t person) {
  throw ConfigError(
      fmt::format("people.{}: person {} has no path that keeps {} m from the sensor: ask for fewer people, or give a "
                  "larger people.lateral",
                  key, person + 1, People::kClearance));
}

/// An ellipse across the route.
std::vector<Vec2> loop_across(const Route::Place& place, double half_length) {
  constexpr int kCorners = 128;
  const Vec2 across(-place.direction.y(), place.direction.x());
  std::vector<Vec2> points;
  for (int k = 0; k < kCorners; ++k) {
    const double angle = kTurn * k / kCorners;
    points.push_back(place.at + half_length * std::cos(angle) * across +
                     kHalfWidth * std::sin(angle) * place.direction);
  }
  return points;
}

}  // namespace

/// Where the sensor is.
struct People::SensorPath {
  static constexpr double kStep = 0.05;  ///< [s]
  std::vector<Vec2> positions;
  double mean_speed = 0;  ///< along the route [m/s]
  double lead = 0;        ///< the sensor is at most this far ahead of a point at its mean speed [m]

  SensorPath(const Motion& sensor, const Route& route) {
    const auto count = static_cast<std::size_t>(sensor.duration() / kStep) + 1;
    std::vector<double> travelled;
    for (std::size_t k = 0; k < count; ++k) {
      const Vec2 p = sensor.at(kStep * static_cast<double>(k)).p.head<2>();
      travelled.push_back(k == 0 ? 0 : travelled.back() + (p - positions.back()).norm());
      positions.push_back(p);
    }
    // Corners are cut: whole rounds tell the length along the route.
    const double rounds = std::max(std::round(travelled.back() / route.length()), 1.0);
    mean_speed = rounds * route.length() / sensor.duration();
    if (travelled.back() <= 0) return;
    for (std::size_t k = 0; k < count; ++k) {
      const double progress = rounds * route.length() * travelled[k] / travelled.back();
      lead = std::max(lead, progress - mean_speed * kStep * static_cast<double>(k));
    }
  }
};

void PeopleParams::describe(config::Binder& b, PeopleParams& params) {
  const config::Range count{.min = 0, .max = 200};
  b.integer("walking", params.walking, "1", count, "people who walk along the route in either direction");
  b.integer("ahead", params.ahead, "1", count, "people who walk ahead of the sensor at its mean speed");
  b.integer("crossing", params.crossing, "1", count, "people who walk to and fro across the route");
  b.real("distance", params.distance, "m", {.min = 1.5, .max = 100.0},
         "of the first one ahead; the others are 1.5 m from each other");
  b.real("lateral", params.lateral, "m", {.min = 0.6, .max = 20.0},
         "distance from the line of the route of those who walk along it");
}

People::People(const PeopleParams& params, const Route& route, const Ground& ground, const Motion& sensor,
               std::uint64_t seed) {
  if (params.walking + params.ahead + params.crossing == 0) return;
  const SensorPath path(sensor, route);
  for (const double side : {1.0, -1.0}) lines_.emplace_back(beside(route, side * params.lateral), kRounding, ground);
  add_walking(params, path, seed);
  add_ahead(params, route, path, seed);
  add_crossing(params, route, ground, path, seed);
}

bool People::clear(const Walker& walker, const SensorPath& path) const {
  for (std::size_t k = 0; k < path.positions.size(); ++k) {
    const Vec3 p = place(walker, SensorPath::kStep * static_cast<double>(k)).at;
    if ((p.head<2>() - path.positions[k]).norm() < kClearance) return false;
  }
  return true;
}

void People::add_walking(const PeopleParams& params, const SensorPath& path, std::uint64_t seed) {
  for (std::int64_t person = 0; person < params.walking; ++person) {
    RandomStream random(seed, purpose::kPeople, kWalking + static_cast<std::uint64_t>(person));
    Walker walker;
    for (int attempt = 0;; ++attempt) {
      if (attempt == kAttempts) fail("walking", static_cast<std::size_t>(person));
      // On the right: the left line is walked against its direction.
      const bool forth = random.uniform() < 0.5;
      walker.line = forth ? 1 : 0;
      walker.speed = random.uniform(0.9, 1.5) * (forth ? 1 : -1);
      walker.begin = random.uniform(0, lines_[walker.line].length());
      walker.height = random.uniform(1.55, 1.9);
      walker.step_phase = random.uniform(0, kTurn);
      if (clear(walker, path)) break;
    }
    walkers_.push_back(walker);
  }
}

void People::add_ahead(const PeopleParams& params, const Route& route, const SensorPath& path, std::uint64_t seed) {
  for (std::int64_t person = 0; person < params.ahead; ++person) {
    RandomStream random(seed, purpose::kPeople, kAhead + static_cast<std::uint64_t>(person));
    Walker walker;
    walker.line = person % 2 == 0 ? 1 : 0;
    walker.height = random.uniform(1.55, 1.9);
    walker.step_phase = random.uniform(0, kTurn);
    const ClosedLine& line = lines_[walker.line];
    walker.speed = path.mean_speed * line.length() / route.length();
    double distance = params.distance + kSpacingAhead * static_cast<double>(person) + path.lead;
    for (int attempt = 0;; ++attempt) {
      if (attempt == kAttempts) fail("ahead", static_cast<std::size_t>(person));
      const Route::Place place = route.at(distance);
      walker.begin = line.nearest(place.at, place.direction);
      if (clear(walker, path)) break;
      distance += 0.5;
    }
    walkers_.push_back(walker);
  }
}

void People::add_crossing(const PeopleParams& params, const Route& route, const Ground& ground, const SensorPath& path,
                          std::uint64_t seed) {
  for (std::int64_t person = 0; person < params.crossing; ++person) {
    RandomStream random(seed, purpose::kPeople, kCrossing + static_cast<std::uint64_t>(person));
    Walker walker;
    walker.line = lines_.size();
    for (int attempt = 0;; ++attempt) {
      if (attempt == kAttempts) fail("crossing", static_cast<std::size_t>(person));
      const Route::Place place = route.at(random.uniform(0, route.length()));
      lines_.emplace_back(loop_across(place, params.lateral + kBeyond), 0, ground);
      walker.speed = random.uniform(0.7, 1.1) * (random.uniform() < 0.5 ? 1 : -1);
      walker.begin = random.uniform(0, lines_.back().length());
      walker.height = random.uniform(1.55, 1.9);
      walker.step_phase = random.uniform(0, kTurn);
      if (clear(walker, path)) break;
      lines_.pop_back();
    }
    walkers_.push_back(walker);
  }
}

ClosedLine::Place People::place(const Walker& walker, double t) const {
  ClosedLine::Place place = lines_[walker.line].at(walker.begin + walker.speed * t);
  if (walker.speed < 0) place.direction = -place.direction;
  return place;
}

Vec3 People::position(std::size_t person, double t) const { return place(walkers_.at(person), t).at; }

void People::at(double t, std::vector<Body>& out) const {
  out.clear();
  for (const Walker& walker : walkers_) out.push_back(body(walker, place(walker, t), t));
}

}  // namespace aslio::simulator
