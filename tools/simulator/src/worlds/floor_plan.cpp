#include "worlds/floor_plan.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace aslio::simulator::indoor {
namespace {

constexpr double kTouch = 1e-4;

double snapped(double v) { return std::round(v * 1000) / 1000; }

std::vector<double> distinct(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
  return values;
}

/// First and last + 1 of the cells between `edges` that have more than a touch in common with [low, high].
std::pair<int, int> cells_between(const std::vector<double>& edges, double low, double high) {
  const auto first = std::upper_bound(edges.begin(), edges.end(), low + kTouch) - edges.begin() - 1;
  const auto last = std::lower_bound(edges.begin(), edges.end(), high - kTouch) - edges.begin();
  return {static_cast<int>(first), static_cast<int>(last)};
}

}  // namespace

bool Rect::overlaps(const Rect& other) const {
  return low.x() < other.high.x() - kTouch && other.low.x() < high.x() - kTouch && low.y() < other.high.y() - kTouch &&
         other.low.y() < high.y() - kTouch;
}

bool Rect::contains(const Vec2& p) const {
  return p.x() > low.x() && p.x() < high.x() && p.y() > low.y() && p.y() < high.y();
}

void FloorPlan::add(const Space& space) {
  Space s = space;
  for (int k = 0; k < 2; ++k) {
    s.area.low[k] = snapped(space.area.low[k]);
    s.area.high[k] = snapped(space.area.high[k]);
  }
  if (s.area.size().minCoeff() > 0) spaces_.push_back(s);
}

bool FloorPlan::meets(const Rect& area) const {
  return std::any_of(spaces_.begin(), spaces_.end(), [&](const Space& s) { return s.area.overlaps(area); });
}

PlanGrid::PlanGrid(const FloorPlan& plan) {
  for (const Space& s : plan.spaces()) {
    x_.insert(x_.end(), {s.area.low.x(), s.area.high.x()});
    y_.insert(y_.end(), {s.area.low.y(), s.area.high.y()});
  }
  x_ = distinct(std::move(x_));
  y_ = distinct(std::move(y_));
  const std::size_t nx = x_.empty() ? 0 : x_.size() - 1, ny = y_.empty() ? 0 : y_.size() - 1;
  cells_.resize(nx * ny);
  for (const Space& s : plan.spaces()) {
    const auto [i0, i1] = cells_between(x_, s.area.low.x(), s.area.high.x());
    const auto [j0, j1] = cells_between(y_, s.area.low.y(), s.area.high.y());
    for (int j = j0; j < j1; ++j) {
      for (int i = i0; i < i1; ++i) {
        Cell& c = cells_[static_cast<std::size_t>(j) * nx + static_cast<std::size_t>(i)];
        c = c.solid() ? Cell{s.floor, s.ceiling} : Cell{std::min(c.floor, s.floor), std::max(c.ceiling, s.ceiling)};
      }
    }
  }
}

PlanGrid::Cell PlanGrid::cell(int i, int j) const {
  const int nx = static_cast<int>(x_.size()) - 1, ny = static_cast<int>(y_.size()) - 1;
  if (i < 0 || j < 0 || i >= nx || j >= ny) return {};
  return cells_[static_cast<std::size_t>(j) * static_cast<std::size_t>(nx) + static_cast<std::size_t>(i)];
}

bool PlanGrid::free(const Rect& area, double low, double high) const {
  const auto [i0, i1] = cells_between(x_, area.low.x(), area.high.x());
  const auto [j0, j1] = cells_between(y_, area.low.y(), area.high.y());
  for (int j = j0; j < j1; ++j) {
    for (int i = i0; i < i1; ++i) {
      const Cell c = cell(i, j);
      if (c.solid() || c.floor > low + kTouch || c.ceiling < high - kTouch) return false;
    }
  }
  return i1 > i0 && j1 > j0;
}

void PlanGrid::add_walls(int axis, std::vector<WallFace>& faces) const {
  const std::vector<double>&along = axis == 0 ? x_ : y_, &across = axis == 0 ? y_ : x_;
  const auto at = [&](int k, int line) { return axis == 0 ? cell(k, line) : cell(line, k); };
  const auto point = [&](double s, double t) { return axis == 0 ? Vec2(s, t) : Vec2(t, s); };
  std::vector<WallFace> open;
  for (int line = 0; line < static_cast<int>(across.size()); ++line) {
    const double t = across[static_cast<std::size_t>(line)];
    for (int k = 0; k + 1 < static_cast<int>(along.size()); ++k) {
      const Vec2 a = point(along[static_cast<std::size_t>(k)], t), b = point(along[static_cast<std::size_t>(k) + 1], t);
      std::vector<WallFace> here;
      const auto exposed = [&](const Cell& free, const Cell& other, double side) {
        if (free.solid()) return;
        const Vec2 normal = point(0, side);
        if (other.solid()) {
          here.push_back({a, b, normal, free.floor, free.ceiling});
          return;
        }
        if (free.floor < other.floor) here.push_back({a, b, normal, free.floor, std::min(other.floor, free.ceiling)});
        if (free.ceiling > other.ceiling)
          here.push_back({a, b, normal, std::max(other.ceiling, free.floor), free.ceiling});
      };
      const Cell below = at(k, line - 1), above = at(k, line);
      exposed(above, below, 1);
      exposed(below, above, -1);
      for (WallFace& face : here) {
        const auto same = std::find_if(open.begin(), open.end(), [&](const WallFace& o) {
          return o.b == face.a && o.normal == face.normal && o.low == face.low && o.high == face.high;
        });
        if (same != open.end()) {
          face.a = same->a;
          open.erase(same);
        }
      }
      faces.insert(faces.end(), open.begin(), open.end());
      open = std::move(here);
    }
    faces.insert(faces.end(), open.begin(), open.end());
    open.clear();
  }
}

std::vector<WallFace> PlanGrid::walls() const {
  std::vector<WallFace> faces;
  add_walls(0, faces);
  add_walls(1, faces);
  return faces;
}

void PlanGrid::add_slabs(MeshBuilder& builder, bool ceiling, std::uint8_t reflectivity) const {
  struct Slab {
    int begin = 0, end = 0, row = 0;
    double z = 0;
  };
  const auto height = [&](const Cell& c) { return ceiling ? c.ceiling : c.floor; };
  std::vector<Slab> open;
  const auto finish = [&](const Slab& s, int row) {
    const auto x = [&](int i) { return x_[static_cast<std::size_t>(i)]; };
    const auto y = [&](int j) { return y_[static_cast<std::size_t>(j)]; };
    builder.slab({x(s.begin), y(s.row)}, {x(s.end), y(row)}, s.z, reflectivity);
  };
  const int nx = static_cast<int>(x_.size()) - 1, ny = static_cast<int>(y_.size()) - 1;
  for (int j = 0; j < ny; ++j) {
    std::vector<Slab> row;
    for (int i = 0; i < nx; ++i) {
      const Cell c = cell(i, j);
      if (c.solid()) continue;
      if (!row.empty() && row.back().end == i && row.back().z == height(c)) {
        ++row.back().end;
      } else {
        row.push_back({i, i + 1, j, height(c)});
      }
    }
    for (Slab& s : row) {
      const auto same = std::find_if(open.begin(), open.end(),
                                     [&](const Slab& o) { return o.begin == s.begin && o.end == s.end && o.z == s.z; });
      if (same == open.end()) continue;
      s.row = same->row;
      open.erase(same);
    }
    for (const Slab& s : open) finish(s, j);
    open = std::move(row);
  }
  for (const Slab& s : open) finish(s, ny);
}

void PlanGrid::build(MeshBuilder& builder, const Surfaces& surfaces) const {
  for (const WallFace& face : walls()) builder.wall(face.a, face.b, face.low, face.high, surfaces.wall);
  add_slabs(builder, false, surfaces.floor);
  add_slabs(builder, true, surfaces.ceiling);
}

}  // namespace aslio::simulator::indoor
