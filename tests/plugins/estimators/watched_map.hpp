#pragma once

#include <optional>
#include <vector>

#include "aslio/stages/map.hpp"

namespace aslio::test {

/// Passes everything on; counts the searches for points, and remembers from where they were seen.
class WatchedMap final : public Map {
 public:
  explicit WatchedMap(Map& map) : map_(map) {}
  MapContent content() const override { return map_.content(); }
  void correspond(std::span<const Vec3> queries, const MapQuery& query, Neighbours& out) const override {
    watch(queries, query);
    map_.correspond(queries, query, out);
  }
  void surfaces(std::span<const Vec3> queries, const MapQuery& query, std::span<Surface> out) const override {
    watch(queries, query);
    map_.surfaces(queries, query, out);
  }
  InsertCount insert(std::span<const WorldPoint> points, std::uint32_t stamp) override {
    return map_.insert(points, stamp);
  }
  void trim(const Vec3& centre_W) override { map_.trim(centre_W); }
  void clear() override { map_.clear(); }
  std::size_t size() const override { return map_.size(); }
  std::size_t memory_bytes() const override { return map_.memory_bytes(); }
  double radius() const override { return map_.radius(); }
  void visit(const std::function<void(const Vec3&)>& visitor) const override { map_.visit(visitor); }

  mutable int searches = 0;
  mutable std::vector<std::optional<Vec3>> viewpoints;  ///< of every search

 private:
  void watch(std::span<const Vec3> queries, const MapQuery& query) const {
    if (queries.empty()) return;
    ++searches;
    viewpoints.push_back(query.viewpoint);
  }

  Map& map_;
};

}  // namespace aslio::test
