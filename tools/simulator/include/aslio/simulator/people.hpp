#pragma once
/// People who walk about: bodies of capsules, so that each ray meets them where they are at its own time.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "aslio/simulator/caster.hpp"
#include "aslio/simulator/closed_line.hpp"
#include "aslio/simulator/ground.hpp"
#include "aslio/simulator/motion.hpp"
#include "aslio/simulator/route.hpp"

namespace aslio::config {
class Binder;
}

namespace aslio::simulator {

/// `people:` of a scene file.
struct PeopleParams {
  std::int64_t walking = 0;   ///< walk along the route in either direction, beside its middle, on their right
  std::int64_t ahead = 0;     ///< walk ahead of the sensor, in its direction and at its mean speed, on either side
  std::int64_t crossing = 0;  ///< walk to and fro across the route
  double distance = 4;        ///< at least about this far ahead is the first one [m]; they follow at 1.5 m along the
                              ///< route, on the right and on the left in turn
  double lateral = 0.7;       ///< distance of those who walk along the route from its line [m]
  static void describe(config::Binder& b, PeopleParams& params);
};

struct Capsule {
  Vec3 a = Vec3::Zero(), b = Vec3::Zero();  ///< ends of the axis [m], in W
  double radius = 0.1;                      ///< [m]
};
/// Torso, head, two legs and two arms that swing with the step.
inline constexpr std::size_t kBodyParts = 6;
struct Body {
  std::array<Capsule, kBodyParts> parts;
  Vec3 centre = Vec3::Zero();  ///< of a sphere round all of them [m], in W
  double radius = 0;           ///< of the sphere [m]
};

/// Thread-compatible: const after construction. People may pass through each other, and through furniture.
class People {
 public:
  /// Nobody comes nearer to the sensor than this, from the axis of the body in the plan, while it moves [m].
  static constexpr double kClearance = 0.5;

  People() = default;
  /// `sensor` goes round the route. `seed` draws sizes, speeds and where they start, again and again until they keep
  /// clear of the sensor. Throws ConfigError when there is no way to.
  People(const PeopleParams& params, const Route& route, const Ground& ground, const Motion& sensor,
         std::uint64_t seed);

  std::size_t size() const { return walkers_.size(); }
  /// Bodies `t` seconds after the start; replaces the content of `out`. Order: walking, ahead, crossing.
  void at(double t, std::vector<Body>& out) const;
  /// Only those that a ray from `origin` along one of the unit vectors, or within 0.3 deg of it, may meet: most of the
  /// time nobody, which is much cheaper.
  void in_view(double t, const Vec3& origin, std::span<const Vec3> directions, std::vector<Body>& out) const;
  /// On the ground between the feet of one of them.
  Vec3 position(std::size_t person, double t) const;

 private:
  struct Walker {
    std::size_t line = 0;
    double begin = 0;       ///< along the line [m]
    double speed = 1;       ///< [m/s]; negative: against the line
    double height = 1.7;    ///< [m]
    double step_phase = 0;  ///< [rad]
  };
  struct SensorPath;
  ClosedLine::Place place(const Walker& walker, double t) const;
  static Body body(const Walker& walker, const ClosedLine::Place& place, double t);
  void add_walking(const PeopleParams& params, const SensorPath& path, std::uint64_t seed);
  void add_ahead(const PeopleParams& params, const Route& route, const SensorPath& path, std::uint64_t seed);
  void add_crossing(const PeopleParams& params, const Route& route, const Ground& ground, const SensorPath& path,
                    std::uint64_t seed);
  bool clear(const Walker& walker, const SensorPath& path) const;

  std::vector<ClosedLine> lines_;
  std::vector<Walker> walkers_;
};

/// Nearest body along a ray: replaces `hit` when it is nearer. `direction` is a unit vector, `origin` outside of all
/// bodies.
void cast_people(std::span<const Body> bodies, const Vec3& origin, const Vec3& direction, SurfaceHit& hit);

}  // namespace aslio::simulator
