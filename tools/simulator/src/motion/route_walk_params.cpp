#include "aslio/config/binder.hpp"
#include "aslio/simulator/pose_spline.hpp"
#include "aslio/simulator/route_walk.hpp"

namespace aslio::simulator {

void Glance::describe(config::Binder& b, Glance& glance) {
  b.real("at", glance.at, "1", {.above = 0.0, .below = 1.0}, "where on the round it begins, share of its length");
  b.real("angle", glance.angle, "deg", {.min = -180.0, .max = 180.0}, "how far, positive to the left");
  b.real("turn", glance.turn, "s", {.min = 0.1, .max = 10.0}, "time of the turn there and of the turn back");
  b.real("hold", glance.hold, "s", {.min = 0.0, .max = 60.0}, "time between the two turns");
}

void WalkParams::describe(config::Binder& b, WalkParams& params) {
  b.choice("gait", params.gait,
           {{"smooth", GaitKind::smooth},
            {"walking", GaitKind::walking},
            {"oscillating", GaitKind::oscillating},
            {"running", GaitKind::running}},
           "steps: none; 1.9 Hz, 1.5 cm, 1 deg; 1.9 Hz, 3 cm, 2 deg; 2.7 Hz, 2.5 cm (peaks of 2.4 g), 7 deg");
  b.real("speed", params.speed, "m/s", {.min = 0.1, .max = 10.0}, "on straight parts");
  b.real("corner_speed", params.corner_speed, "m/s", {.min = 0.1, .max = 10.0},
         "into and out of a corner of 90 deg; gentler ones are walked faster, sharper ones slower");
  b.real("corner_radius", params.corner_radius, "m", {.min = 0.1, .max = 3.0},
         "the line is left and met again this far from a corner; at most a third of an edge");
  b.real("turn_min", params.turn_min, "s", {.min = 0.1, .max = 10.0}, "shortest time for a turn of 90 deg");
  b.real("turn_max", params.turn_max, "s", {.min = 0.1, .max = 10.0}, "longest time for a turn of 90 deg");
  b.real("standstill", params.standstill, "s", {.min = 0.0, .max = 60.0}, "at the start and at the end");
  b.flag("dynamic_start", params.dynamic_start, "in full walk at time 0, standstill at the end only");
  b.real("height", params.height, "m", {.min = 0.1, .max = 10.0}, "of the IMU above the ground");
  b.integer("laps", params.laps, "1", {.min = 1.0, .max = 1000.0}, "rounds without a stop between them");
  b.groups("glances", params.glances, "turns of the head, away and back, on every round");
  b.require(params.corner_speed <= params.speed, "corner_speed", "must not be above speed");
  b.require(params.turn_min <= params.turn_max, "turn_min", "must not be above turn_max");
}

void FollowParams::describe(config::Binder& b, FollowParams& params) {
  b.text("file", params.file, "trajectory of the IMU (TUM, T_W_I), relative to the scene file");
  b.real("knot_interval", params.knot_interval, "s", {.min = 0.01, .max = 10.0},
         "of the spline through the poses: shorter follows closer, longer smooths noise");
}

}  // namespace aslio::simulator
