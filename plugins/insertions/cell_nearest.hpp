#pragma once

#include "aslio/config/binder.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/stages/insertion.hpp"

namespace aslio::plugins {

/// `cell_nearest`: a fresh point enters at its own update unless one of the k nearest points of its kind (lines; all
/// others) in the map is nearer than itself to the centre of its cell (eq. INS-2; FAST-LIO2). The points of one update
/// do not see each other: a map that keeps one point per cell (`ikd_tree` with a leaf) sorts them out. Neighbours are
/// searched at the posterior; FAST-LIO2 takes the lists of its last association, which differ by the last step of the
/// iteration.
class InsertCellNearest final : public Insertion {
 public:
  struct Params {
    double cell = 0.5;
    std::int64_t k = 5;
  };
  static void describe(config::Binder& b, Params& p);

  InsertCellNearest(const Params& params, const BuildContext&) : params_(params) {}

  bool needs_nearest_points() const override { return true; }
  InsertCount apply(const Window& window, const Update& update, Map& map) override;

 private:
  std::size_t insert(std::span<const WorldPoint> points, std::uint8_t kind, std::uint32_t stamp, Map& map);
  bool nearer_to_centre(std::size_t query) const;

  Params params_;
  std::vector<WorldPoint> own_;
  std::vector<Vec3> queries_;
  Neighbours nearest_;
  std::vector<WorldPoint> chosen_;
};

}  // namespace aslio::plugins
