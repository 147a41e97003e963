#pragma once
/// People who walk about: bodies of capsules in closed form, so that each ray meets them where they are at its own
/// time.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "aslio/simulator/caster.hpp"
#include "aslio/simulator/ground.hpp"
#include "aslio/simulator/route.hpp"

namespace aslio::config {
class Binder;
}

namespace aslio::simulator {

/// `people:` of a scene file.
struct PeopleParams {
  std::int64_t walking = 0;   ///< walk along the route in either direction, beside its middle
  std::int64_t ahead = 0;     ///< walk ahead of the sensor, in its direction and at its mean speed
  std::int64_t crossing = 0;  ///< walk to and fro across the route
  double distance = 4;        ///< of the first one ahead [m]; the others follow at 1.5 m from each other
  double lateral = 0.7;       ///< distance of the walking ones from the line of the route [m]
  static void describe(config::Binder& b, PeopleParams& params);
};

struct Capsule {
  Vec3 a = Vec3::Zero(), b = Vec3::Zero();  ///< ends of the axis [m], in W
  double radius = 0.1;                      ///< [m]
};
/// Torso, head, two legs and two arms that swing with the step.
inline constexpr std::size_t kBodyParts = 6;
using Body = std::array<Capsule, kBodyParts>;

/// Thread-compatible: const after construction.
class People {
 public:
  People() = default;
  /// `mean_speed` of the sensor along the route [m/s]. `seed` draws sizes, speeds and where they start.
  People(const PeopleParams& params, const Route& route, const Ground& ground, double mean_speed, std::uint64_t seed);

  std::size_t size() const { return walkers_.size(); }
  /// Bodies `t` seconds after the start; replaces the content of `out`.
  void at(double t, std::vector<Body>& out) const;

 private:
  struct Walker;
  std::vector<Walker> walkers_;
  std::vector<Vec2> line_;
  Ground ground_;
};

/// Nearest body along a ray: replaces `hit` when it is nearer. `origin` is outside of all bodies.
void cast_people(std::span<const Body> bodies, const Vec3& origin, const Vec3& direction, SurfaceHit& hit);

}  // namespace aslio::simulator
