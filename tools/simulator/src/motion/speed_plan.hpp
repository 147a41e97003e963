#pragma once
/// How fast a car goes along a road.

#include <vector>

#include "aslio/simulator/drive.hpp"
#include "jet.hpp"

namespace aslio::simulator {

/// From one speed to another by the quintic step of time; `from` == `to`: steady.
struct SpeedPiece {
  double t = 0, duration = 0, way = 0;  ///< begin [s], [s], at its begin [m]
  double from = 0, to = 0;              ///< [m/s]
  double peak_acceleration() const { return duration > 0 ? 1.875 * (to - from) / duration : 0; }
};

/// As fast as speed, limits, bends and stops allow, with bounded acceleration.
class SpeedPlan {
 public:
  /// Throws ConfigError naming the key that cannot be met.
  SpeedPlan(const RoadLine& road, const DriveParams& params);

  /// Along the road and its derivatives by time.
  Jet way(double t) const;
  /// The one at that time; the first before, the last after.
  const SpeedPiece& piece(double t) const;
  double duration() const { return pieces_.back().t + pieces_.back().duration; }
  /// When the car is there the first time [s].
  double time_at(double way) const;

 private:
  struct Node {
    double at = 0, hold = 0;  ///< [m], waits there [s]
    double most = 0;          ///< speed [m/s]
  };
  struct Stretch {
    double from = 0, to = 0, speed = 0;
  };
  std::vector<Stretch> stretches(const RoadLine& road) const;
  void set_nodes(const RoadLine& road);
  double free_speed(double at) const;
  double time(double from, double to) const;
  double distance(double from, double to) const { return 0.5 * (from + to) * time(from, to); }
  double fastest(double from, double length, double limit) const;
  void limit_nodes();
  void add(double duration, double from, double to);
  void drive_between(const Node& from, const Node& to);

  DriveParams params_;
  std::vector<Stretch> stretches_;
  std::vector<Node> nodes_;
  std::vector<SpeedPiece> pieces_;
};

}  // namespace aslio::simulator
