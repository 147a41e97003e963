#pragma once
/// `curvature_features`: points on edges and on planes, by the bend of a scan line at them (LOAM).

#include <cstdint>
#include <span>
#include <vector>

#include "aslio/stages/build_context.hpp"
#include "aslio/stages/sampler.hpp"
#include "aslio/toolkit/point_uses.hpp"

namespace aslio::plugins {

/// Scan lines are the points of one TimedPoint::line in the order of time: rings of a spinning sensor, the lines of a
/// Livox. Marks points feature_class::line or plane, the clearest of every sector besides, and takes the uses from all
/// others (docs/equations.md FEA-1, FEA-2; Zhang and Singh, LOAM, RSS 2014).
class CurvatureFeatures final : public Sampler {
 public:
  struct Params {
    std::int64_t neighbours = 5;
    std::int64_t sectors = 6;
    std::int64_t lines = 20;
    std::int64_t clearest_lines = 2;
    std::int64_t clearest_planes = 4;
    double line_threshold = 0.1;
    double plane_threshold = 0.1;
    double occlusion = 0.3;
    double adjacent_deg = 2.0;
    double parallel = 0.02;
    UseNames uses{"map", "match"};
  };
  static void describe(config::Binder& b, Params& p);
  CurvatureFeatures(const Params& params, const BuildContext& context);

  ActsOn acts_on() const override { return ActsOn::body; }
  bool gives_features() const override { return true; }
  void sample(SampleBatch& batch) override;

 private:
  struct Point {
    Eigen::Vector3f p_L;
    float range = 0;
    float curvature = 0;       ///< [m^2]
    bool measured = false;     ///< has neighbours on both sides
    bool unreliable = false;   ///< behind an edge, or on a surface along the beam
    bool near_picked = false;  ///< a clear point of the same kind is near
    std::uint8_t feature = 0;
  };

  void list_by_line(const SampleBatch& batch);
  void classify(const SampleBatch& batch, std::span<const std::uint32_t> line);
  void measure();
  void reject_unreliable();
  void pick(std::size_t begin, std::size_t end);
  void pick_lines();
  void pick_planes();
  void keep_off(std::size_t i);

  Params params_;
  std::size_t neighbours_;
  float cos_adjacent_;
  PointUses uses_;
  std::vector<std::uint32_t> begin_;    ///< [line], into ordered_
  std::vector<std::uint32_t> ordered_;  ///< points by line, then time
  std::vector<Point> points_;           ///< of one line
  std::vector<std::uint32_t> sector_;   ///< of points_, ascending in curvature
  std::vector<std::uint8_t> found_;     ///< [point of the batch]
};

}  // namespace aslio::plugins
