#pragma once

#include <map>
#include <vector>

#include "aslio/stages/map.hpp"

namespace aslio::test {

/// Remembers what it was given and takes every second of it.
class RecordingMap final : public Map {
 public:
  void correspond(std::span<const Vec3> queries, const MapQuery& query, Neighbours& out) const override {
    out.resize(queries.size(), query.k);
    std::fill(out.count.begin(), out.count.end(), std::uint8_t{0});
  }
  InsertCount insert(std::span<const WorldPoint> points, std::uint32_t stamp) override {
    for (const WorldPoint& p : points) {
      stamps.emplace(p.t, stamp);
      given.push_back(p);
    }
    return {.offered = points.size(), .inserted = points.size() / 2};
  }
  void trim(const Vec3&) override {}
  void clear() override { stamps.clear(), given.clear(); }
  std::size_t size() const override { return stamps.size(); }
  std::size_t memory_bytes() const override { return 0; }
  double radius() const override { return 0; }
  void visit(const std::function<void(const Vec3&)>&) const override {}

  std::multimap<TimeNs, std::uint32_t> stamps;  ///< by time of the point
  std::vector<WorldPoint> given;                ///< in the order given
};

}  // namespace aslio::test
