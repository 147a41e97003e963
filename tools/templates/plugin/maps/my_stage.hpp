#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <vector>

#include "aslio/config/binder.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/stages/map.hpp"

namespace my_plugin {

/// What lies around a point? Here: cubes of space, each with a list of its points, no two nearer than `min_spacing`.
/// Neighbours are exact. The contract stands in aslio/stages/map.hpp.
class MyStage final : public aslio::Map {
 public:
  /// Defaults stand here and nowhere else.
  struct Params {
    double cube = 1.0;
    double min_spacing = 0.1;
    double radius = 100.0;
  };
  /// Names, units, ranges and meanings: for `aslio describe` and for the check of a configuration.
  static void describe(aslio::config::Binder& b, Params& p);

  MyStage(const Params& params, const aslio::BuildContext& context);

  void correspond(std::span<const aslio::Vec3> queries, const aslio::MapQuery& query,
                  aslio::Neighbours& out) const override;
  aslio::InsertCount insert(std::span<const aslio::WorldPoint> points, std::uint32_t stamp) override;
  void trim(const aslio::Vec3& centre_W) override;
  void clear() override;
  std::size_t size() const override { return size_; }
  std::size_t memory_bytes() const override;
  double radius() const override { return params_.radius; }
  void visit(const std::function<void(const aslio::Vec3&)>& visitor) const override;

 private:
  using Cube = std::array<std::int32_t, 3>;
  struct Stored {
    aslio::Vec3 p_W;
    std::uint64_t order;  ///< counts insertions
    std::uint32_t stamp;
  };
  /// Whether `p` lies in a cube; what is not finite or too far does not.
  bool cube_of(const aslio::Vec3& p, Cube& cube) const;
  void nearest(const aslio::Vec3& query, const aslio::MapQuery& ask, std::size_t row, aslio::Neighbours& out) const;

  Params params_;
  aslio::exec::Executor& exec_;
  std::map<Cube, std::vector<Stored>> cubes_;  // sorted, so that its order is the same everywhere
  std::size_t size_ = 0;
  std::uint64_t inserted_ = 0;
};

}  // namespace my_plugin
