#include "samplers/curvature_features.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace aslio::plugins {

namespace {
constexpr std::size_t kLines = 256;
}

void CurvatureFeatures::describe(config::Binder& b, Params& p) {
  b.integer("neighbours", p.neighbours, "", {.min = 1, .max = 100},
            "points on each side along the scan line over which its bend is taken");
  b.integer("sectors", p.sectors, "", {.min = 1, .max = 1000},
            "equal parts of a scan line, each of which gives its own points");
  b.integer("lines", p.lines, "", {.min = 0, .max = 1e4}, "points on edges per sector at most");
  b.integer("clearest_lines", p.clearest_lines, "", {.min = 0, .max = 1e4},
            "of these, the sharpest ones, which a match with the last sweep takes");
  b.integer("clearest_planes", p.clearest_planes, "", {.min = 0, .max = 1e4},
            "the flattest points per sector, which a match with the last sweep takes");
  b.real("line_threshold", p.line_threshold, "m^2", {.min = 0}, "an edge bends more than this (FEA-1)");
  b.real("plane_threshold", p.plane_threshold, "m^2", {.min = 0}, "a plane bends less than this");
  b.real("occlusion", p.occlusion, "m", {.above = 0},
         "a larger jump of range between adjacent beams means an occluded surface behind: no feature at its border");
  b.real("adjacent_deg", p.adjacent_deg, "deg", {.above = 0, .max = 90}, "beams nearer than this are adjacent");
  b.real("parallel", p.parallel, "", {.above = 0},
         "a range that differs by a larger share from those on both sides is a surface along the beam, or a lone "
         "return: no feature");
  describe_uses(b, p.uses);
  b.require(p.clearest_lines <= p.lines, "clearest_lines", "must not exceed lines, of which they are a part");
}

CurvatureFeatures::CurvatureFeatures(const Params& params, const BuildContext&)
    : params_(params),
      neighbours_(static_cast<std::size_t>(params.neighbours)),
      cos_adjacent_(static_cast<float>(std::cos(params.adjacent_deg * std::numbers::pi / 180.0))),
      uses_(use_mask(params.uses)) {}

void CurvatureFeatures::list_by_line(const SampleBatch& batch) {
  begin_.assign(kLines + 1, 0);
  for (std::size_t i = 0; i < batch.raw.size(); ++i) {
    if ((batch.uses[i] & uses_) != 0) ++begin_[batch.raw[i].line + std::size_t{1}];
  }
  for (std::size_t line = 0; line < kLines; ++line) begin_[line + 1] += begin_[line];
  if (ordered_.capacity() < batch.raw.size()) ordered_.reserve(2 * batch.raw.size());
  ordered_.resize(begin_[kLines]);
  for (std::size_t i = 0; i < batch.raw.size(); ++i) {
    if ((batch.uses[i] & uses_) != 0) ordered_[begin_[batch.raw[i].line]++] = static_cast<std::uint32_t>(i);
  }
  for (std::size_t line = kLines; line > 0; --line) begin_[line] = begin_[line - 1];
  begin_[0] = 0;
}

/// eq. FEA-1
void CurvatureFeatures::measure() {
  const std::size_t s = neighbours_, n = points_.size();
  for (std::size_t i = s; i + s < n; ++i) {
    Eigen::Vector3f bend = Eigen::Vector3f::Zero();
    for (std::size_t j = i - s; j <= i + s; ++j) bend += points_[j].p_L - points_[i].p_L;
    points_[i].curvature = bend.squaredNorm();
    points_[i].measured = std::isfinite(points_[i].curvature);
  }
}

/// eq. FEA-2
void CurvatureFeatures::reject_unreliable() {
  const std::size_t s = neighbours_, n = points_.size();
  for (std::size_t i = 0; i + 1 < n; ++i) {
    const Point &a = points_[i], &b = points_[i + 1];
    if (a.p_L.dot(b.p_L) < cos_adjacent_ * a.range * b.range) continue;
    const float jump = b.range - a.range;
    if (std::abs(jump) <= static_cast<float>(params_.occlusion)) continue;
    // The farther one goes on behind the nearer: where it seems to end depends on where the sensor stands.
    const std::size_t first = jump > 0 ? i + 1 : i + 1 - std::min(s, i + 1);
    const std::size_t last = jump > 0 ? std::min(n, i + 1 + s) : i + 1;
    for (std::size_t j = first; j < last; ++j) points_[j].unreliable = true;
  }
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const float range = points_[i].range, most = static_cast<float>(params_.parallel) * range;
    if (std::abs(points_[i - 1].range - range) > most && std::abs(points_[i + 1].range - range) > most) {
      points_[i].unreliable = true;
    }
  }
}

void CurvatureFeatures::keep_off(std::size_t i) {
  const std::size_t first = i - std::min(i, neighbours_), last = std::min(points_.size(), i + neighbours_ + 1);
  for (std::size_t j = first; j < last; ++j) points_[j].near_picked = true;
}

void CurvatureFeatures::pick_lines() {
  std::int64_t picked = 0;
  for (auto at = sector_.rbegin(); at != sector_.rend() && picked < params_.lines; ++at) {
    Point& point = points_[*at];
    if (!(static_cast<double>(point.curvature) > params_.line_threshold)) break;
    if (point.near_picked || point.unreliable) continue;
    const bool clearest = picked++ < params_.clearest_lines;
    point.feature = static_cast<std::uint8_t>(feature_class::line | (clearest ? feature_class::clearest : 0));
    keep_off(*at);
  }
}

void CurvatureFeatures::pick_planes() {
  std::int64_t picked = 0;
  for (const std::uint32_t i : sector_) {
    Point& point = points_[i];
    if (!(static_cast<double>(point.curvature) < params_.plane_threshold)) break;
    if (point.feature != feature_class::none) continue;
    point.feature = feature_class::plane;
    if (picked >= params_.clearest_planes || point.near_picked || point.unreliable) continue;
    point.feature |= feature_class::clearest;
    ++picked;
    keep_off(i);
  }
}

void CurvatureFeatures::pick(std::size_t begin, std::size_t end) {
  sector_.clear();
  for (std::size_t i = begin; i < end; ++i) {
    if (points_[i].measured) sector_.push_back(static_cast<std::uint32_t>(i));
  }
  std::sort(sector_.begin(), sector_.end(), [&](std::uint32_t a, std::uint32_t b) {
    return points_[a].curvature != points_[b].curvature ? points_[a].curvature < points_[b].curvature : a < b;
  });
  pick_lines();
  pick_planes();
}

void CurvatureFeatures::classify(const SampleBatch& batch, std::span<const std::uint32_t> line) {
  const std::size_t n = line.size(), s = neighbours_;
  if (n < 2 * s + 1) return;
  points_.clear();
  for (const std::uint32_t i : line) {
    Point& point = points_.emplace_back();
    point.p_L = {batch.raw[i].x, batch.raw[i].y, batch.raw[i].z};
    point.range = point.p_L.norm();
  }
  measure();
  reject_unreliable();
  const auto sectors = static_cast<std::size_t>(params_.sectors);
  for (std::size_t k = 0; k < sectors; ++k) {
    pick(s + (n - 2 * s) * k / sectors, s + (n - 2 * s) * (k + 1) / sectors);
  }
  for (std::size_t i = 0; i < n; ++i) found_[line[i]] = points_[i].feature;
}

void CurvatureFeatures::sample(SampleBatch& batch) {
  list_by_line(batch);
  if (found_.capacity() < batch.raw.size()) {
    found_.reserve(2 * batch.raw.size());
    points_.reserve(2 * batch.raw.size());
    sector_.reserve(2 * batch.raw.size());
  }
  found_.assign(batch.raw.size(), feature_class::none);
  for (std::size_t line = 0; line < kLines; ++line) {
    classify(batch, std::span(ordered_).subspan(begin_[line], begin_[line + 1] - begin_[line]));
  }
  const auto cleared = static_cast<PointUses>(~uses_);
  for (std::size_t i = 0; i < batch.uses.size(); ++i) {
    if ((batch.uses[i] & uses_) == 0) continue;
    if (!batch.features.empty()) batch.features[i] = found_[i];
    if (found_[i] == feature_class::none) batch.uses[i] = static_cast<PointUses>(batch.uses[i] & cleared);
  }
}

}  // namespace aslio::plugins
