#include "estimators/cube_means.hpp"

#include <algorithm>
#include <tuple>

namespace aslio::plugins {

// eq. PTW-7.
std::span<const TimedPoint> CubeMeans::of(std::span<const TimedPoint> points, std::span<const PointUses> uses) {
  if (members_.capacity() < points.size()) {
    members_.reserve(2 * points.size());
    means_.reserve(2 * points.size());
  }
  members_.clear();
  means_.clear();
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (uses[i] == 0) continue;
    const auto cell = cell_of(Vec3(points[i].x, points[i].y, points[i].z), inverse_edge_);
    if (cell) members_.push_back({pack(*cell), static_cast<std::uint32_t>(i)});
  }
  std::sort(members_.begin(), members_.end(),
            [](const Member& a, const Member& b) { return std::tie(a.cube, a.point) < std::tie(b.cube, b.point); });
  for (auto begin = members_.begin(); begin != members_.end();) {
    const auto end =
        std::find_if(begin, members_.end(), [begin](const Member& member) { return member.cube != begin->cube; });
    means_.push_back(mean(points, {begin, end}));
    begin = end;
  }
  std::sort(means_.begin(), means_.end(),
            [](const TimedPoint& a, const TimedPoint& b) { return std::tie(a.t, a.index) < std::tie(b.t, b.index); });
  return means_;
}

TimedPoint CubeMeans::mean(std::span<const TimedPoint> points, std::span<const Member> cube) const {
  TimedPoint out = points[cube.front().point];
  Vec3 sum = Vec3::Zero();
  TimeNs late = 0;  // after the first: a sum of stamps would not fit
  for (const Member& member : cube) {
    const TimedPoint& p = points[member.point];
    sum += Vec3(p.x, p.y, p.z);
    late += p.t - out.t;
  }
  const Eigen::Vector3f centre = (sum / static_cast<double>(cube.size())).cast<float>();
  out.x = centre.x();
  out.y = centre.y();
  out.z = centre.z();
  out.t += late / static_cast<TimeNs>(cube.size());
  return out;
}

}  // namespace aslio::plugins
