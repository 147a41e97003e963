#pragma once

#include "aslio/config/binder.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/stages/map.hpp"

namespace aslio::plugins {

/// Two maps of points: one of lines, one of planes and all else (LOAM). A point goes, and a query is put, where its
/// feature class belongs; each map thins, searches and forgets by its own rules. radius() is the larger one.
class FeatureMaps final : public Map {
 public:
  struct Params {
    config::Nested<Map> lines{"voxel_hash"};
    config::Nested<Map> planes{"voxel_hash"};
  };
  static void describe(config::Binder& b, Params& p);
  /// Throws ConfigError for a map of surfaces.
  FeatureMaps(const Params& params, const BuildContext& context);

  void correspond(std::span<const Vec3> queries, const MapQuery& query, Neighbours& out) const override;
  InsertCount insert(std::span<const WorldPoint> points, std::uint32_t stamp) override;
  void trim(const Vec3& centre_W) override;
  void clear() override;
  std::size_t size() const override { return lines_->size() + planes_->size(); }
  std::size_t memory_bytes() const override;
  double radius() const override;
  /// Lines, then planes, each in the order of its map.
  void visit(const std::function<void(const Vec3&)>& visitor) const override;

 private:
  std::unique_ptr<Map> lines_, planes_;
  std::vector<WorldPoint> own_lines_, own_planes_;  ///< of one insertion
};

}  // namespace aslio::plugins
