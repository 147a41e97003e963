#pragma once
/// A car on a road: how fast it goes where, and how its body moves meanwhile.

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "aslio/simulator/ground.hpp"
#include "aslio/simulator/motion.hpp"
#include "aslio/simulator/road.hpp"

namespace aslio::config {
class Binder;
}

namespace aslio::simulator {

/// The car comes to rest and waits.
struct Stop {
  double at = 0.5;  ///< share of the road's length in (0, 1)
  double hold = 3;  ///< [s]
  static void describe(config::Binder& b, Stop& stop);
};

/// A slower or faster stretch.
struct SpeedLimit {
  double from = 0, to = 1;  ///< shares of the road's length
  double speed = 10;        ///< at most this there [m/s]
  static void describe(config::Binder& b, SpeedLimit& limit);
};

/// `drive:` of a scene file with `motion: drive`.
struct DriveParams {
  double speed = 14;                ///< on free straights [m/s]
  double start_speed = 0;           ///< at time 0 [m/s]; 0: after a standstill
  double end_speed = 0;             ///< at the end of the road, at most [m/s]; 0: standstill there
  double acceleration = 3;          ///< along the road, either way, at most [m/s^2]
  double lateral_acceleration = 3;  ///< in bends, at most [m/s^2]
  double bend_radius = 14;          ///< the tightest one of the bends at the corners of the route [m]
  double standstill = 2;            ///< at a start and at an end at rest [s]
  double height = 1.7;              ///< of the IMU above the road [m]
  double suspension = 1;            ///< pitch and roll by acceleration: 1 is a usual car, 0 none
  double roughness = 1;             ///< vibration by the road: 1 is a good road, 0 none
  std::optional<double> duration;   ///< the recording ends after this at the latest [s]
  std::vector<Stop> stops;
  std::vector<SpeedLimit> limits;
  static void describe(config::Binder& b, DriveParams& params);
};

struct Jet;
class SpeedPlan;

/// Changes of speed follow the quintic step of time, bends the septic step of the way: three times continuously
/// differentiable. The car heads along the road and leans with the ground. Thread-compatible: const.
class Drive final : public Motion {
 public:
  /// Only the waves of the ground count. `seed` draws the phases of the road's unevenness. Throws ConfigError when the
  /// speeds cannot be had on this road, naming the key.
  Drive(const RoadLine& road, const Ground& ground, const DriveParams& params, std::uint64_t seed);
  ~Drive() override;

  MotionState at(double t) const override;
  double duration() const override { return duration_; }
  /// Along the road from its first point [m].
  double way(double t) const;
  /// Along the road [m/s].
  double speed(double t) const;
  const RoadLine& road() const { return road_; }

 private:
  /// One wave of the road's surface as the body feels it.
  struct Unevenness {
    double k = 1;                       ///< [rad/m]
    double z = 0, pitch = 0, roll = 0;  ///< amplitudes [m], [rad]
    double phase_z = 0, phase_pitch = 0, phase_roll = 0;
  };
  struct Lean {
    double begin = 0, length = 1, roll = 0;  ///< a bend [m], the roll in its middle [rad]
  };
  void add_unevenness(double roughness, std::uint64_t seed);
  void sway(double t, const Jet& way, Jet& z, Jet& pitch, Jet& roll) const;

  RoadLine road_;
  Ground ground_;
  double height_ = 0, pitch_per_acceleration_ = 0, duration_ = 0;
  std::unique_ptr<SpeedPlan> plan_;
  std::vector<Unevenness> unevenness_;
  std::vector<Lean> leans_;
};

}  // namespace aslio::simulator
