#include "aslio/simulator/realism.hpp"

#include <algorithm>

#include "aslio/config/binder.hpp"

namespace aslio::simulator {
namespace {

constexpr std::string_view kPresets = "= the preset's";
constexpr config::Range kMultiple{.min = 0.0, .max = 10.0};

/// docs/simulator.md has the source of each value.
Realism preset_realism(RealismPreset preset) {
  Realism r;
  if (preset == RealismPreset::none) return r;
  r.mount = {.angle = 0.5, .offset = 0.010};
  r.clock = {.drift = 20, .jitter = 500};
  r.ranging = {.offset = 0.02,
               .line = 0.005,
               .incidence = 0.05,
               .reflectivity = 0.015,
               .near = 0.02,
               .warm_up = 0.01,
               .noise_growth = 2};
  r.footprint = 1;
  r.surface = {.unevenness = 1, .relief = 1};
  r.glass = 0.9;
  r.gait = {.heel = 1, .sway = 1, .tremor = 1, .turns = 1};
  r.imu = {.filter = 1, .temperature = 10, .vibration = 0.3};
  return r;
}

/// What the preset gives to the parts that are named.
Realism chosen(const RealismParams& params) {
  const Realism all = preset_realism(params.preset);
  const auto has = [&](std::string_view part) {
    return std::find(params.parts.begin(), params.parts.end(), part) != params.parts.end();
  };
  Realism r;
  if (has("mount")) r.mount = all.mount;
  if (has("clock")) r.clock = all.clock;
  if (has("ranging")) r.ranging = all.ranging;
  if (has("footprint")) r.footprint = all.footprint;
  if (has("surface")) r.surface = all.surface;
  if (has("glass")) r.glass = all.glass;
  if (has("gait")) r.gait = all.gait;
  if (has("imu")) r.imu = all.imu;
  return r;
}

}  // namespace

void RealismParams::Mount::describe(config::Binder& b, Mount& p) {
  b.optional_real("angle", p.angle, "deg", {.min = 0.0, .max = 45.0}, kPresets,
                  "error of the rotation in the sensor file, about a random axis: between a fifth of this and this");
  b.optional_real("offset", p.offset, "m", {.min = 0.0, .max = 1.0}, kPresets,
                  "error of the translation in the sensor file, in a random direction: between 3/10 of this and this");
}

void RealismParams::Clock::describe(config::Binder& b, Clock& p) {
  b.optional_real("drift", p.drift, "ppm", {.min = 0.0, .max = 1000.0}, kPresets,
                  "the clock of the IMU is fast or slow by this or less, by a twentieth of it or more");
  b.optional_real("jitter", p.jitter, "us", {.min = 0.0, .max = 10000.0}, kPresets,
                  "standard deviation of the stamps of the IMU: between a tenth of this and this; their order is kept");
}

void RealismParams::Ranging::describe(config::Binder& b, Ranging& p) {
  const config::Range length{.min = 0.0, .max = 1.0};
  b.optional_real("offset", p.offset, "m", length, kPresets, "error of every range, uniform up to this");
  b.optional_real("line", p.line, "m", length, kPresets, "error of every range of a line, uniform up to this");
  b.optional_real("incidence", p.incidence, "m", length, kPresets,
                  "a range is too short by this at 10 m and 80 deg; grows with range and tangent, at most 0.2 m");
  b.optional_real("reflectivity", p.reflectivity, "m", length, kPresets,
                  "a black surface seems farther or nearer than a white one, uniform up to this");
  b.optional_real("near", p.near, "m", length, kPresets,
                  "error at range 0, uniform up to this; falls with the square to 0 at 2 m");
  b.optional_real("warm_up", p.warm_up, "m", length, kPresets,
                  "drift of every range from time 0, uniform up to this; time constant 300 s");
  b.optional_real("noise_growth", p.noise_growth, "1", kMultiple, kPresets,
                  "an echo at the end of its reach has 1 + this times the range noise");
}

void RealismParams::Surface::describe(config::Binder& b, Surface& p) {
  b.optional_real("unevenness", p.unevenness, "1", kMultiple, kPresets,
                  "of each material over metres, as a multiple of its usual one");
  b.optional_real("relief", p.relief, "1", kMultiple, kPresets,
                  "of each material over centimetres, as a multiple of its usual one");
}

void RealismParams::Gait::describe(config::Binder& b, Gait& p) {
  b.optional_real("heel", p.heel, "1", kMultiple, kPresets, "jolt of each step, as a multiple of the gait's usual one");
  b.optional_real("sway", p.sway, "1", {.min = 0.0, .max = 2.5}, kPresets,
                  "from side to side, as a multiple of the gait's usual one");
  b.optional_real("tremor", p.tremor, "1", kMultiple, kPresets, "of the hand at 8 to 12 Hz, as a multiple of 0.1 deg");
  b.optional_real("turns", p.turns, "1", kMultiple, kPresets,
                  "roll and pitch in each turn, as a multiple of 5 to 15 deg");
}

void RealismParams::Imu::describe(config::Binder& b, Imu& p) {
  b.optional_real("filter", p.filter, "1", kMultiple, kPresets,
                  "a sample is the mean of so many sample times before it; imu.delay is half of that at least");
  b.optional_real("temperature", p.temperature, "K", {.min = 0.0, .max = 60.0}, kPresets,
                  "the IMU warms by this, with a time constant of 300 s: its biases drift");
  b.optional_real("vibration", p.vibration, "m/s^2", {.min = 0.0, .max = 50.0}, kPresets,
                  "amplitude of the LiDAR's motor on each axis of the accelerometer, where its speed is published");
}

void RealismParams::describe(config::Binder& b, RealismParams& params) {
  b.choice("preset", params.preset, {{"none", RealismPreset::none}, {"realistic", RealismPreset::realistic}},
           "what absent keys are: none: 0. realistic: values of the literature");
  b.texts("parts", params.parts, RealismParams{}.parts, "which parts the preset fills");
  b.require(params.preset != RealismPreset::none || params.parts == RealismParams{}.parts, "parts",
            "names parts of a preset: give preset: realistic, too");
  b.group("mount", params.mount, "the sensor file is wrong");
  b.group("clock", params.clock, "stamps of the IMU");
  b.group("ranging", params.ranging, "errors of a range beside its white noise; without lidar.noise there are none");
  // The bodies of people are looked for within 0.3 deg of a beam.
  b.optional_real("footprint", params.footprint, "1", {.min = 0.0, .max = 2.0}, kPresets,
                  "every pulse has a footprint, as a multiple of the data sheet's, whatever lidar.mixed is; without "
                  "lidar.noise there is none");
  b.group("surface", params.surface, "roughness; a world of type mesh has its own");
  b.optional_real("glass", params.glass, "1", {.min = 0.0, .max = 1.0}, kPresets,
                  "share of the pulses for which a pane is clear: they pass it or are mirrored; 0: it is opaque");
  b.group("gait", params.gait, "the motion of a person; a drive and a trajectory that is followed have none");
  b.group("imu", params.imu, "the IMU beyond its preset");
}

Realism realism(const RealismParams& p) {
  Realism r = chosen(p);
  r.mount.angle = p.mount.angle.value_or(r.mount.angle);
  r.mount.offset = p.mount.offset.value_or(r.mount.offset);
  r.clock.drift = p.clock.drift.value_or(r.clock.drift);
  r.clock.jitter = p.clock.jitter.value_or(r.clock.jitter);
  r.ranging.offset = p.ranging.offset.value_or(r.ranging.offset);
  r.ranging.line = p.ranging.line.value_or(r.ranging.line);
  r.ranging.incidence = p.ranging.incidence.value_or(r.ranging.incidence);
  r.ranging.reflectivity = p.ranging.reflectivity.value_or(r.ranging.reflectivity);
  r.ranging.near = p.ranging.near.value_or(r.ranging.near);
  r.ranging.warm_up = p.ranging.warm_up.value_or(r.ranging.warm_up);
  r.ranging.noise_growth = p.ranging.noise_growth.value_or(r.ranging.noise_growth);
  r.footprint = p.footprint.value_or(r.footprint);
  r.surface.unevenness = p.surface.unevenness.value_or(r.surface.unevenness);
  r.surface.relief = p.surface.relief.value_or(r.surface.relief);
  r.glass = p.glass.value_or(r.glass);
  r.gait.heel = p.gait.heel.value_or(r.gait.heel);
  r.gait.sway = p.gait.sway.value_or(r.gait.sway);
  r.gait.tremor = p.gait.tremor.value_or(r.gait.tremor);
  r.gait.turns = p.gait.turns.value_or(r.gait.turns);
  r.imu.filter = p.imu.filter.value_or(r.imu.filter);
  r.imu.temperature = p.imu.temperature.value_or(r.imu.temperature);
  r.imu.vibration = p.imu.vibration.value_or(r.imu.vibration);
  return r;
}

}  // namespace aslio::simulator
