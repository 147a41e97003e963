#include "maps/bundle_planes.hpp"

#include "maps/plane_shape.hpp"

namespace aslio::plugins {

namespace {

BundleWindow::Params window_params(const BundlePlanes::Params& params) {
  BundleWindow::Params out = params.window;
  out.thickness = params.voxels.thickness;
  return out;
}

/// Mean place of the sensor; of points without a view, their own.
Vec3 seen_from(std::span<const WorldPoint> points) {
  Vec3 sum = Vec3::Zero();
  double count = 0;
  for (const WorldPoint& point : points) {
    const Vec3 place = point.p_W - static_cast<double>(point.range) * point.view.vector().cast<double>();
    if (!place.allFinite()) continue;
    sum += place;
    count += 1;
  }
  return count > 0 ? Vec3(sum / count) : Vec3::Zero();
}

}  // namespace

void BundlePlanes::describe(config::Binder& b, Params& p) {
  BundleVoxels::Params& v = p.voxels;
  BundleWindow::Params& w = p.window;
  b.real("voxel", v.voxel, "m", {.min = 0.05, .max = 10.0}, "edge of a voxel; its eighths are the finer level");
  b.integer("min_points", v.min_points, "", {.min = 4, .max = 10000}, "points a plane needs");
  b.integer("max_points", v.max_points, "", {.min = 4, .max = 1000000}, "settled points after which a voxel is closed");
  b.integer("keyframe_points", v.keyframe_points, "", {.min = 1, .max = 100000}, "points a voxel takes of a keyframe");
  b.real("thickness", v.thickness, "m", {.above = 0.0, .max = 1.0},
         "maximum standard deviation of the points across their plane");
  b.real("doubt", v.doubt, "", {.min = 0.0, .max = 1e6},
         "matches of a plane that share its error: the more, the less a plane of few points counts, or one at its edge "
         "(0: all alike)");
  b.real("radius", v.radius, "m", {.above = 0.0}, "voxels farther than this from the sensor are forgotten");
  b.flag("faces", v.faces, "separate the points by the side of a wall they are seen from");
  b.integer("grids", p.grids, "", {.min = 1, .max = 8},
            "grids of voxels, each moved by an equal part of a voxel. Time and memory grow with their number");
  b.real("keyframe", w.keyframe, "s", {.min = 0.01, .max = 10.0}, "points of this time move together");
  b.real("lag", w.lag, "s", {.min = 0.01, .max = 100.0}, "what is older has settled");
  b.integer("iterations", w.iterations, "", {.min = 0, .max = 100},
            "steps of an adjustment, one per keyframe (0: nothing moves)");
  b.real("sigma", w.sigma, "m", {.above = 0.0, .max = 1.0}, "standard deviation of a point across its plane");
  b.real("plane_sigma", w.plane_sigma, "m", {.min = 0.0, .max = 1.0},
         "the same of what all points of a keyframe on one plane share");
  b.real("kernel", w.kernel, "m", {.above = 0.0, .max = 1.0},
         "distance from a plane at which the points of a keyframe count half");
  b.real("drift_deg", w.drift_deg, "deg/sqrt(s)", {.above = 0.0, .max = 90.0},
         "how far the attitude drifts between keyframes");
  b.real("drift", w.drift, "m/sqrt(s)", {.above = 0.0, .max = 10.0}, "the same of the position");
  b.integer("max_planes", w.max_planes, "", {.min = 1, .max = 1000000},
            "planes of an adjustment; of more, it takes every n-th");
  b.require(v.min_points <= v.max_points, "min_points", "must not exceed max_points");
  b.require(w.lag <= 64 * w.keyframe, "lag", "must not exceed 64 keyframes: time grows with their third power");
}

BundlePlanes::BundlePlanes(const Params& params, const BuildContext& context)
    : grids_(params.grids, params.voxels, context), window_(window_params(params)), radius_(params.voxels.radius) {}

void BundlePlanes::correspond(std::span<const Vec3> queries, const MapQuery& query, Neighbours& out) const {
  find_no_neighbours(queries, query, out);
}

InsertCount BundlePlanes::insert(std::span<const WorldPoint> points, std::uint32_t stamp) {
  if (points.empty()) return {};
  if (window_.ends(points.front().t)) {
    window_.revise(grids_, stamp);
    window_.begin(points.front().t, seen_from(points));
  }
  return grids_.insert(points, stamp, window_.newest());
}

void BundlePlanes::set_noise_scale(double scale) {
  grids_.set_noise_scale(scale);
  window_.set_noise_scale(scale);
}

void BundlePlanes::clear() {
  grids_.clear();
  window_.clear();
}

}  // namespace aslio::plugins
