#include "my_stage.hpp"

#include <algorithm>
#include <cmath>

#include "aslio/plugin/entry.hpp"

namespace my_plugin {

using namespace aslio;

void MyStage::describe(config::Binder& b, Params& p) {
  b.real("share", p.share, "", {.min = 0.0, .max = 1.0}, "information of an old point, as a share of a fresh one's");
  b.real("gate", p.gate, "", {.above = 0.0}, "an old point takes part while its residual is below gate * sigma");
  b.integer("max_points", p.max_points, "", {.min = 1, .max = 1e6}, "points kept at most, the latest");
}

MyStage::MyStage(const Params& params, const BuildContext& context)
    : share_(params.share), gate_(params.gate), max_points_(static_cast<std::size_t>(params.max_points)) {
  (void)context;
  points_.reserve(2 * max_points_);
}

HistorySelection MyStage::select(const Window& window) {
  const TimeNs begin = window.plan.history_begin;
  std::erase_if(points_, [&](const HistoryPoint& point) { return point.t <= begin; });
  // A point must not match the map points that it, or one measured with it, became: only updates that ended before the
  // window begins are admissible.
  ends_.push_back({window.plan.end, window.sequence});
  while (ends_.front().t <= begin) {
    admissible_ = ends_.front().sequence;
    ends_.erase(ends_.begin());
  }
  return {.points = points_, .max_stamp = admissible_, .covariance = HistoryCovariance::joseph};
}

double MyStage::weight(std::size_t fresh_residuals, std::size_t history_residuals) const {
  (void)fresh_residuals;
  return history_residuals == 0 ? 0.0 : share_;
}

void MyStage::commit(const Window& window, const Update& update) {
  const std::span<const WorldPoint> points = update.points(PointUse::match);
  const std::size_t fresh = std::min(points.size(), max_points_);
  for (std::size_t i = points.size() - fresh; i < points.size(); ++i) {
    const bool matched = i < update.matches.size() && update.matches[i].accepted;
    if (!matched) continue;
    points_.push_back({.p_W = points[i].p_W,
                       .t = points[i].t,
                       .range = points[i].range,
                       .residual = std::abs(update.matches[i].residual),
                       .sequence = window.sequence});
  }
  if (points_.size() > max_points_) {
    points_.erase(points_.begin(), points_.end() - static_cast<std::ptrdiff_t>(max_points_));
  }
}

namespace {

void register_types(plugin::Catalog& catalog) {
  plugin::Registry<HistoryPolicy>(catalog).add<MyStage>("my_stage", "Matched old points at one share of a fresh one.");
}

}  // namespace

}  // namespace my_plugin

ASLIO_PLUGIN(my_plugin::register_types)
