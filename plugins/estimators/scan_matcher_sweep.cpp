// The first step of the scan matcher: the clearest points against the last sweep.
#include <fmt/format.h>

#include "aslio/core/cpu_clock.hpp"
#include "aslio/core/errors.hpp"
#include "estimators/scan_matcher.hpp"

namespace aslio::plugins {

namespace {

std::unique_ptr<Residual> fitted(const config::Nested<Residual>& nested, const char* key, const BuildContext& context) {
  auto residual = nested.make(context);
  if (!residual->surfaces_from_map()) return residual;
  throw ConfigError(fmt::format(
      "estimator scan_matcher: {}: '{}' takes surfaces from the map: set planes: neighbours, or another residual", key,
      nested.type()));
}

}  // namespace

ScanMatcher::ScanMatcher(const Params& params, const BuildContext& context)
    : params_(params),
      exec_(context.exec),
      imu_(params.imu, context),
      lines_(fitted(params.lines, "lines", context), feature_class::line,
             {params.sweep_distance, static_cast<int>(params.sweep_lines)}),
      planes_(fitted(params.planes, "planes", context), feature_class::plane,
              {params.sweep_distance, static_cast<int>(params.sweep_lines)}),
      frame_(context.sensor) {
  trajectory_.reserve(64);
}

void ScanMatcher::describe(config::Binder& b, Params& p) {
  using Noise = ImuNoisePreset::Kind;
  b.choice("prediction", p.prediction, {{"constant_velocity", Prediction::constant_velocity}, {"imu", Prediction::imu}},
           "where the first guess comes from: the motion goes on as before, and no IMU data is read; or the IMU");
  b.integer("sweep_searches", p.sweep_searches, "", {.min = 0, .max = 100},
            "searches of the clearest points in the last sweep (0: the map alone)");
  b.integer("map_searches", p.map_searches, "", {.min = 1, .max = 100}, "searches of all points in the map");
  b.integer("max_steps", p.max_steps, "", {.min = 1, .max = 100}, "Gauss-Newton steps per search at most");
  b.integer("map_every", p.map_every, "", {.min = 1, .max = 1000},
            "windows of which one is matched with the map, and enters it; the others follow the last sweep alone");
  b.real("converged_m", p.converged_m, "m", {.above = 0, .max = 1}, "a step has converged below this motion");
  b.real("converged_deg", p.converged_deg, "deg", {.above = 0, .max = 10}, "and below this turn");
  b.real("sigma", p.sigma, "m", {.above = 0, .max = 1},
         "standard deviation of one row, as a residual is asked for it; the pose does not depend on it");
  b.integer("min_matches", p.min_matches, "", {.min = 3, .max = 1e6}, "fewer matches: the step is not taken");
  b.real("degenerate_eigenvalue", p.degenerate_eigenvalue, "", {.min = 0},
         "directions whose eigenvalue of J^T W J (rad, m; W without 1 / sigma^2) is smaller keep what they were before "
         "the map");
  b.real("sweep_distance", p.sweep_distance, "m", {.above = 0, .max = 30},
         "a point of the last sweep farther than this is no match");
  b.integer("sweep_lines", p.sweep_lines, "", {.min = 1, .max = 255},
            "how many scan lines away the other points of a line or plane of the last sweep may be");
  b.choice("noise", p.imu.noise.kind,
           {{"fastlio", Noise::fastlio}, {"physical", Noise::physical}, {"rate_scaled", Noise::rate_scaled}},
           "prediction: imu: IMU noise, as of ieskf");
  b.require(p.map_every == 1 || p.sweep_searches > 0, "map_every",
            "must be 1 with sweep_searches: 0, or nothing is matched in between");
  b.stage("motion", p.imu.motion, "prediction: imu: pose and covariance between updates");
  b.stage("lines", p.lines, "what a match of a point on an edge measures");
  b.stage("planes", p.planes, "what a match of a point on a plane measures");
}

void ScanMatcher::list_clearest(Kind& kind) {
  PointMatches& clearest = kind.clearest;
  clearest.reserve(kind.index.size(), *kind.residual);
  clearest.body.clear();
  clearest.range.clear();
  for (const std::uint32_t i : kind.index) {
    if ((frame_.match_feature()[i] & feature_class::clearest) == 0) continue;
    clearest.body.push_back(frame_.match_body()[i]);
    clearest.range.push_back(frame_.match_range()[i]);
  }
}

/// eq. SWP-1
void ScanMatcher::associate_clearest(Kind& kind) {
  constexpr std::size_t points_per_chunk = 64;
  PointMatches& clearest = kind.clearest;
  clearest.surfaces.resize(clearest.body.size());
  exec_.for_ranges(clearest.body.size(), points_per_chunk, [&](std::size_t begin, std::size_t end, std::size_t) {
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3& at = clearest.world[i];
      clearest.surfaces[i] = kind.feature == feature_class::line ? kind.last_sweep.line(at) : kind.last_sweep.plane(at);
    }
  });
}

/// False: the prediction stays.
bool ScanMatcher::match_last_sweep() {
  if (params_.sweep_searches == 0) return false;
  const CpuTimer timer(result_.times.solve);
  for (Kind* kind : {&lines_, &planes_}) list_clearest(*kind);
  Descent at{.end = prior_.pose()};
  for (int search = 0; search < params_.sweep_searches; ++search) {
    for (Kind* kind : {&lines_, &planes_}) {
      kind->clearest.place(at.end);
      associate_clearest(*kind);
    }
    if (!descend(&Kind::clearest, search == 0, at)) return drop(at);
  }
  take(at);
  return true;
}

}  // namespace aslio::plugins
