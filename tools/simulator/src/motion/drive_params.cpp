#include "aslio/config/binder.hpp"
#include "aslio/simulator/drive.hpp"

namespace aslio::simulator {

void Stop::describe(config::Binder& b, Stop& stop) {
  b.real("at", stop.at, "1", {.above = 0.0, .below = 1.0}, "where on the road, share of its length; not in a bend");
  b.real("hold", stop.hold, "s", {.min = 0.0, .max = 600.0}, "time at rest");
}

void SpeedLimit::describe(config::Binder& b, SpeedLimit& limit) {
  b.real("from", limit.from, "1", {.min = 0.0, .max = 1.0}, "begin, share of the road's length");
  b.real("to", limit.to, "1", {.min = 0.0, .max = 1.0}, "end, share of the road's length");
  b.real("speed", limit.speed, "m/s", {.min = 0.5, .max = 40.0}, "at most this there");
  b.require(limit.from < limit.to, "to", "must be above from");
}

void DriveParams::describe(config::Binder& b, DriveParams& params) {
  b.real("speed", params.speed, "m/s", {.min = 0.5, .max = 40.0}, "on free straights");
  b.real("start_speed", params.start_speed, "m/s", {.min = 0.0, .max = 40.0},
         "at time 0; 0: the car stands still first");
  b.real("end_speed", params.end_speed, "m/s", {.min = 0.0, .max = 40.0},
         "at the end of the road, at most; 0: the car stands still there");
  b.real("acceleration", params.acceleration, "m/s^2", {.min = 0.2, .max = 10.0},
         "along the road, faster and slower, at most");
  b.real("lateral_acceleration", params.lateral_acceleration, "m/s^2", {.min = 0.2, .max = 10.0},
         "in bends, at most: the car slows down before them");
  b.real("bend_radius", params.bend_radius, "m", {.min = 5.0, .max = 5000.0},
         "tightest radius of the bends at the corners of the route; less where the edges are short");
  b.real("standstill", params.standstill, "s", {.min = 0.0, .max = 60.0}, "at a start and at an end at rest");
  b.real("height", params.height, "m", {.min = 0.1, .max = 5.0}, "of the IMU above the road");
  b.real("suspension", params.suspension, "1", {.min = 0.0, .max = 5.0},
         "pitch and roll by acceleration: 1 is 0.5 and 1.2 deg at 3 m/s^2, 0 none");
  b.real("roughness", params.roughness, "1", {.min = 0.0, .max = 10.0},
         "vibration by the road: 1 is a good one, 0.4 m/s^2 (RMS) at 30 m/s; 0 none");
  b.optional_real("duration", params.duration, "s", {.min = 1.0, .max = 36000.0}, "= to the end of the road",
                  "the recording ends after this at the latest");
  b.groups("stops", params.stops, "places where the car waits");
  b.groups("limits", params.limits, "stretches with a limit of their own below speed");
  b.require(params.start_speed <= params.speed, "start_speed", "must not be above speed");
  b.require(params.end_speed <= params.speed, "end_speed", "must not be above speed");
}

}  // namespace aslio::simulator
