#include "aslio/simulator/cars.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "aslio/config/binder.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/simulator/random.hpp"
#include "purposes.hpp"

namespace aslio::simulator {
namespace {

constexpr double kUnderside = 0.25, kBonnet = 0.85;     ///< of cars above the ground [m]
constexpr double kViewMargin = 0.0053;                  ///< 0.3 deg [rad]
constexpr double kGapSway = 1.5, kGapPerWay = 1 / 35.;  ///< the gap goes to and fro with the way [m], [rad/m]

bool meets_sphere(const Vec3& to_centre, double radius, const Vec3& direction) {
  const double along = to_centre.dot(direction), square = to_centre.squaredNorm();
  return square - along * along <= radius * radius && (along >= 0 || square <= radius * radius);
}

struct Face {
  double range = -1;  ///< [m]; negative: not met
  double cosine = 0;
};

/// Where a ray enters a box that stands along the axes.
Face enter_box(const CarBody::Part& box, const Vec3& origin, const Vec3& direction) {
  double from = 0, to = 1e9;
  int axis = -1;
  for (int k = 0; k < 3; ++k) {
    const double o = origin[k] - box.centre[k];
    if (std::abs(direction[k]) < 1e-12) {
      if (std::abs(o) > box.half[k]) return {};
      continue;
    }
    const double near = (-std::copysign(box.half[k], direction[k]) - o) / direction[k];
    const double far = (std::copysign(box.half[k], direction[k]) - o) / direction[k];
    if (near > from) {
      from = near;
      axis = k;
    }
    to = std::min(to, far);
  }
  if (axis < 0 || from > to) return {};
  return {from, std::abs(direction[axis])};
}

}  // namespace

void CarsParams::describe(config::Binder& b, CarsParams& params) {
  const config::Range count{.min = 0, .max = 200};
  b.integer("ahead", params.ahead, "1", count, "cars in the same lane that go and stop as the sensor does");
  b.integer("behind", params.behind, "1", count, "the same, behind the sensor");
  b.integer("oncoming", params.oncoming, "1", count, "cars of the other direction, met during the drive");
  b.integer("beside", params.beside, "1", count, "cars in the lane to the left, at a steady speed");
  b.real("gap", params.gap, "m", {.min = 7.0, .max = 200.0}, "from the sensor to the next car ahead or behind");
  b.real("speed", params.speed, "m/s", {.min = 1.0, .max = 40.0}, "of oncoming cars and those beside, within 10 %");
}

Cars::Cars(const CarsParams& params, const StreetParams& street, const Ground& ground, const Drive& sensor,
           std::uint64_t seed)
    : sensor_(&sensor), ground_(ground) {
  if (params.beside > 0 && street.lanes < 2)
    throw ConfigError("cars.beside: the street has one lane in each direction; give world.lanes of 2 or more");
  add(Lane::ahead, params.ahead, params, street, seed);
  add(Lane::behind, params.behind, params, street, seed);
  add(Lane::oncoming, params.oncoming, params, street, seed);
  add(Lane::beside, params.beside, params, street, seed);
}

/// Cars of one lane keep their order: equal speeds, and distances that are drawn about equal ones.
void Cars::add(Lane lane, std::int64_t count, const CarsParams& params, const StreetParams& street,
               std::uint64_t seed) {
  RandomStream random(seed, purpose::kCars, static_cast<std::uint64_t>(lane));
  const double speed = params.speed * random.uniform(0.9, 1.1), duration = sensor_->duration();
  const double last = sensor_->way(duration);
  for (std::int64_t k = 0; k < count; ++k) {
    const double kind = random.uniform(), size = random.uniform(-1, 1), shift = random.uniform(-0.3, 0.3);
    Car car;
    car.lane = lane;
    car.reflectivity = random.uniform(0.1, 0.8);
    car.sway = random.uniform(0, 2 * std::numbers::pi);
    car.length = 4.4 + 0.3 * size;
    car.width = 1.8 + 0.06 * size;
    car.height = 1.5 + 0.06 * size;
    if (kind < 0.15) {
      car.box = true;
      car.length = 6 + 0.6 * size;
      car.width = 2.2;
      car.height = 2.8 + 0.3 * size;
    }
    const double turn = static_cast<double>(k);
    if (lane == Lane::ahead || lane == Lane::behind) {
      car.begin = (lane == Lane::ahead ? 1 : -1) * (params.gap * (turn + 1) + 3 * shift);
    } else if (lane == Lane::oncoming) {
      // Met one after the other until the end.
      car.lateral = street.lane_against(k % street.lanes);
      car.speed = -speed;
      car.begin = (last + speed * duration) * (turn + 0.6 + shift) / static_cast<double>(count);
    } else {
      // Those that the sensor overtakes begin before it, those that overtake it behind.
      car.lateral = street.lane_along(1);
      car.speed = speed;
      const double gain = last - speed * duration, low = std::min(0.0, gain) - 30, high = std::max(0.0, gain) + 30;
      car.begin = low + (high - low) * (turn + 0.5 + shift) / static_cast<double>(count);
    }
    cars_.push_back(car);
  }
}

double Cars::way(std::size_t car, double t) const {
  const Car& c = cars_.at(car);
  if (c.lane == Lane::oncoming || c.lane == Lane::beside) return c.begin + c.speed * t;
  const double sensor = sensor_->way(t);
  return sensor + c.begin + kGapSway * std::sin(kGapPerWay * sensor + c.sway);
}

CarBody Cars::body(std::size_t car, double t) const {
  const Car& c = cars_.at(car);
  const RoadLine::Place place = sensor_->road().at(way(car, t));
  const Vec2 p = place.beside(c.lateral);
  const double sign = c.speed < 0 ? -1 : 1;
  CarBody body;
  body.at << p, ground_.height(p.x(), p.y());
  body.cos_yaw = sign * std::cos(place.heading);
  body.sin_yaw = sign * std::sin(place.heading);
  body.reflectivity = c.reflectivity;
  body.radius = Vec3(0.5 * c.length, 0.5 * c.width, c.height).norm();
  const auto part = [](const Vec3& low, const Vec3& high) {
    return CarBody::Part{0.5 * (low + high), 0.5 * (high - low)};
  };
  const double l = 0.5 * c.length, w = 0.5 * c.width, top = c.box ? c.height : kBonnet;
  body.parts[0] = part({-l, -w, kUnderside}, {l, w, top});
  body.parts[1] = part({-0.85 * l, -0.88 * w, top - 0.05}, {0.3 * l, 0.88 * w, c.height});
  return body;
}

void Cars::in_view(double t, const Vec3& origin, std::span<const Vec3> directions, std::vector<CarBody>& out) const {
  out.clear();
  for (std::size_t k = 0; k < cars_.size(); ++k) {
    const CarBody one = body(k, t);
    const Vec3 to_centre = one.at - origin;
    const double radius = one.radius + kViewMargin * to_centre.norm();
    if (std::any_of(directions.begin(), directions.end(),
                    [&](const Vec3& direction) { return meets_sphere(to_centre, radius, direction); }))
      out.push_back(one);
  }
}

void cast_cars(std::span<const CarBody> bodies, const Vec3& origin, const Vec3& direction, SurfaceHit& hit) {
  for (const CarBody& body : bodies) {
    const Vec3 from = origin - body.at;
    if (!meets_sphere(-from, body.radius, direction)) continue;
    const auto turned = [&](const Vec3& v) {
      return Vec3(body.cos_yaw * v.x() + body.sin_yaw * v.y(), body.cos_yaw * v.y() - body.sin_yaw * v.x(), v.z());
    };
    const Vec3 o = turned(from), d = turned(direction);
    for (const CarBody::Part& part : body.parts) {
      const Face face = enter_box(part, o, d);
      if (!(face.range > 0 && face.range < hit.range)) continue;
      hit.range = face.range;
      hit.cos_incidence = std::min(face.cosine, 1.0);
      hit.reflectivity = body.reflectivity;
      hit.moving = true;
    }
  }
}

}  // namespace aslio::simulator
