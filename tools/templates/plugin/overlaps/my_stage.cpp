#include "my_stage.hpp"

#include <algorithm>
#include <cmath>

#include "aslio/plugin/entry.hpp"

namespace my_plugin {

using namespace aslio;

void MyStage::describe(config::Binder& b, Params& p) {
  b.real("voxel", p.voxel, "m", {.min = 0.01, .max = 10.0}, "edge of a voxel");
  b.real("delay", p.delay, "s", {.min = 0.0, .max = 10.0}, "how long ago a voxel must have been seen to count");
  b.integer("min_points", p.min_points, "", {.min = 10, .max = 1e6}, "fewer points have no overlap");
}

MyStage::MyStage(const Params& params, const BuildContext& context)
    : voxel_(params.voxel), delay_(to_ns(params.delay)), min_points_(static_cast<std::uint32_t>(params.min_points)) {
  (void)context;
}

bool MyStage::voxel_of(const Vec3& p, Voxel& voxel) const {
  const Vec3 scaled = p / voxel_;
  if (!scaled.allFinite() || scaled.cwiseAbs().maxCoeff() > (1 << 20)) return false;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    voxel[axis] = static_cast<std::int32_t>(std::floor(scaled[static_cast<Eigen::Index>(axis)]));
  }
  return true;
}

OverlapScore MyStage::evaluate(std::span<const WorldPoint> points, TimeNs t) {
  OverlapScore score;
  if (known_since_.empty()) return score;
  // As the occupancy stood `delay` before the middle of the points' time, so that the window's length does not matter.
  const TimeNs then = last_extend_ + (t - last_extend_) / 2 - delay_;
  Voxel voxel;
  for (const WorldPoint& point : points) {
    if (!voxel_of(point.p_W, voxel)) continue;
    ++score.points;
    const auto known = known_since_.find(voxel);
    if (known != known_since_.end() && known->second <= then) ++score.layers[0];
  }
  const bool anything =
      std::any_of(known_since_.begin(), known_since_.end(), [&](const auto& known) { return known.second <= then; });
  if (!anything || score.points < min_points_) return {.value = {}, .layers = {}, .points = score.points};
  score.value = static_cast<double>(score.layers[0]) / score.points;
  return score;
}

void MyStage::extend(std::span<const WorldPoint> points, TimeNs t) {
  last_extend_ = t;
  Voxel voxel;
  for (const WorldPoint& point : points) {
    if (voxel_of(point.p_W, voxel)) known_since_.emplace(voxel, t);  // one that is known keeps its time
  }
}

void MyStage::trim(const Vec3& centre_W, double radius) {
  std::erase_if(known_since_, [&](const auto& known) {
    const auto& [x, y, z] = known.first;
    return (voxel_ * Vec3(x + 0.5, y + 0.5, z + 0.5) - centre_W).norm() > radius + voxel_;
  });
}

void MyStage::clear() {
  known_since_.clear();
  last_extend_ = kTimeMin;
}

std::size_t MyStage::memory_bytes() const {
  constexpr std::size_t links = 4 * sizeof(void*);
  return known_since_.size() * (sizeof(*known_since_.begin()) + links);
}

namespace {

void register_types(plugin::Catalog& catalog) {
  plugin::Registry<OverlapMetric>(catalog).add<MyStage>("my_stage", "Share of the points whose voxel was seen before.");
}

}  // namespace

}  // namespace my_plugin

ASLIO_PLUGIN(my_plugin::register_types)
