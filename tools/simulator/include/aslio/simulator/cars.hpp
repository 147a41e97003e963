#pragma once
/// Cars that drive on the road of a drive: boxes that each ray meets where they are at its own time.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "aslio/simulator/caster.hpp"
#include "aslio/simulator/drive.hpp"
#include "aslio/simulator/worlds/street.hpp"

namespace aslio::config {
class Binder;
}

namespace aslio::simulator {

/// `cars:` of a scene file with `motion: drive` in a street.
struct CarsParams {
  std::int64_t ahead = 0;     ///< in the same lane, one behind the other; they slow down and stop as the sensor does
  std::int64_t behind = 0;    ///< as `ahead`, after the sensor
  std::int64_t oncoming = 0;  ///< in the lanes of the other direction, met during the drive, at a steady speed
  std::int64_t beside = 0;    ///< in the lane to the left, same direction, at a steady speed of their own
  double gap = 18;            ///< from the sensor to the middle of the next car ahead or behind [m]
  double speed = 12;          ///< of oncoming cars and those beside, about [m/s]
  static void describe(config::Binder& b, CarsParams& params);
};

/// One car at one time. Its frame stands upright on the ground, x forward.
struct CarBody {
  struct Part {
    Vec3 centre = Vec3::Zero(), half = Vec3::Zero();  ///< in the frame of the car [m]
  };
  std::array<Part, 2> parts;  ///< body and cabin
  Vec3 at = Vec3::Zero();     ///< origin of its frame, in W [m]
  double cos_yaw = 1, sin_yaw = 0;
  double radius = 0;  ///< of a sphere about `at` round both parts [m]
  double reflectivity = 0.5;
};

/// Thread-compatible: const after construction. Road and drive must outlive it.
class Cars {
 public:
  enum class Lane : std::uint8_t { ahead, behind, oncoming, beside };

  Cars() = default;
  /// `seed` draws sizes, gaps and speeds. Throws ConfigError for cars beside on a street with one lane.
  Cars(const CarsParams& params, const StreetParams& street, const Ground& ground, const Drive& sensor,
       std::uint64_t seed);

  std::size_t size() const { return cars_.size(); }
  Lane lane(std::size_t car) const { return cars_.at(car).lane; }
  /// Along the road [m], at `t` seconds after the start.
  double way(std::size_t car, double t) const;
  CarBody body(std::size_t car, double t) const;
  /// Only those that a ray from `origin` along one of the unit vectors, or within 0.3 deg of it, may meet.
  void in_view(double t, const Vec3& origin, std::span<const Vec3> directions, std::vector<CarBody>& out) const;

 private:
  struct Car {
    Lane lane = Lane::ahead;
    double lateral = 0;  ///< left of the road's line [m]
    double begin = 0;    ///< at time 0 [m]; of cars ahead and behind: from the sensor
    double speed = 0;    ///< [m/s], negative: against the line; of cars ahead and behind: none
    double sway = 0;     ///< of the gap [rad]
    double length = 4.4, width = 1.8, height = 1.5;  ///< [m]
    bool box = false;                                ///< a van or lorry without a bonnet
    double reflectivity = 0.5;
  };
  void add(Lane lane, std::int64_t count, const CarsParams& params, const StreetParams& street, std::uint64_t seed);

  const Drive* sensor_ = nullptr;
  Ground ground_;
  std::vector<Car> cars_;
};

/// Nearest car along a ray: replaces `hit` when it is nearer. `direction` is a unit vector, `origin` outside of all.
void cast_cars(std::span<const CarBody> bodies, const Vec3& origin, const Vec3& direction, SurfaceHit& hit);

}  // namespace aslio::simulator
