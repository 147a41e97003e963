#include "estimators/sweep_index.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace aslio::plugins {

namespace {

constexpr std::int64_t kFarthest = std::int64_t{1} << 20;  // cells, of 1 m

std::uint64_t key_of(std::int64_t x, std::int64_t y, std::int64_t z) {
  return static_cast<std::uint64_t>(x + kFarthest) << 42 | static_cast<std::uint64_t>(y + kFarthest) << 21 |
         static_cast<std::uint64_t>(z + kFarthest);
}

/// Its neighbours within 64 cells have keys, too. False for NaN.
bool in_reach(const Vec3& p) { return p.cwiseAbs().maxCoeff() < static_cast<double>(kFarthest - 64) && p.allFinite(); }

std::int64_t cell(double x) { return static_cast<std::int64_t>(std::floor(x)); }

}  // namespace

void SweepIndex::build(std::span<const WorldPoint> points, std::uint8_t feature) {
  clear();
  if (entries_.capacity() < points.size()) {
    entries_.reserve(2 * points.size());
    keys_.reserve(2 * points.size());
    begins_.reserve(2 * points.size() + 1);
  }
  for (const WorldPoint& point : points) {
    if (point.feature != feature || !in_reach(point.p_W)) continue;
    const std::uint64_t key = key_of(cell(point.p_W.x()), cell(point.p_W.y()), cell(point.p_W.z()));
    entries_.push_back({point.p_W, key, static_cast<std::uint32_t>(entries_.size()), point.line});
  }
  std::sort(entries_.begin(), entries_.end(),
            [](const Entry& a, const Entry& b) { return a.key != b.key ? a.key < b.key : a.order < b.order; });
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    if (i > 0 && entries_[i].key == entries_[i - 1].key) continue;
    keys_.push_back(entries_[i].key);
    begins_.push_back(static_cast<std::uint32_t>(i));
  }
  begins_.push_back(static_cast<std::uint32_t>(entries_.size()));
}

bool SweepIndex::near_other_line(const Entry& a, const Entry& b) const {
  return a.line != b.line && std::abs(a.line - b.line) <= reach_.lines;
}

/// The nearest admitted point within reach, or null; of equal ones the first given.
template <class Admit>
const SweepIndex::Entry* SweepIndex::nearest(const Vec3& query, const Admit& admit) const {
  if (!in_reach(query)) return nullptr;
  const std::int64_t x = cell(query.x()), y = cell(query.y()), z = cell(query.z());
  const Entry* best = nullptr;
  double least = reach_.distance * reach_.distance;
  const auto scan = [&](std::int64_t dx, std::int64_t dy, std::int64_t dz) {
    const auto at = std::lower_bound(keys_.begin(), keys_.end(), key_of(x + dx, y + dy, z + dz));
    if (at == keys_.end() || *at != key_of(x + dx, y + dy, z + dz)) return;
    const auto c = static_cast<std::size_t>(at - keys_.begin());
    for (std::size_t i = begins_[c]; i < begins_[c + 1]; ++i) {
      const double squared = (entries_[i].p - query).squaredNorm();
      if (squared > least || !admit(entries_[i])) continue;
      if (best != nullptr && squared == least && entries_[i].order > best->order) continue;
      best = &entries_[i];
      least = squared;
    }
  };
  const auto shells = static_cast<std::int64_t>(std::ceil(reach_.distance));
  for (std::int64_t shell = 0; shell <= shells; ++shell) {
    const double beyond = static_cast<double>(std::max<std::int64_t>(0, shell - 1));
    if (beyond * beyond > least) break;
    for (std::int64_t dx = -shell; dx <= shell; ++dx) {
      for (std::int64_t dy = -shell; dy <= shell; ++dy) {
        const bool side = std::abs(dx) == shell || std::abs(dy) == shell;
        for (std::int64_t dz = -shell; dz <= shell; dz += side ? 1 : 2 * shell) scan(dx, dy, dz);
      }
    }
  }
  return best;
}

Surface SweepIndex::line(const Vec3& query) const {
  const Entry* a = nearest(query, [](const Entry&) { return true; });
  if (a == nullptr) return {};
  const Entry* b = nearest(query, [&](const Entry& e) { return near_other_line(*a, e); });
  if (b == nullptr) return {};
  const Vec3 along = b->p - a->p;
  if (along.norm() < 1e-3) return {};
  return {.normal = along.normalized(), .anchor = a->p, .valid = true};
}

Surface SweepIndex::plane(const Vec3& query) const {
  const Entry* a = nearest(query, [](const Entry&) { return true; });
  if (a == nullptr) return {};
  const Entry* b = nearest(query, [&](const Entry& e) { return &e != a && e.line == a->line; });
  const Entry* c = nearest(query, [&](const Entry& e) { return near_other_line(*a, e); });
  if (b == nullptr || c == nullptr) return {};
  const Vec3 u = b->p - a->p, v = c->p - a->p;
  const Vec3 normal = u.cross(v);
  // Below 6 deg between both directions the plane turns with the noise.
  if (!(normal.norm() > 0.1 * u.norm() * v.norm())) return {};
  return {.normal = normal.normalized(), .anchor = a->p, .valid = true};
}

}  // namespace aslio::plugins
