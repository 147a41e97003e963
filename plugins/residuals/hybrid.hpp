#pragma once

#include "aslio/config/binder.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/stages/residual.hpp"
#include "residuals/point_to_plane.hpp"
#include "residuals/point_to_point.hpp"

namespace aslio::plugins {

/// Point to plane where the neighbours of a point are planar, point to point elsewhere (docs/equations.md RES-6;
/// GenZ-ICP, arXiv 2411.06766). With `weighting: share`, planes weigh alpha and points 1 - alpha, alpha the share of
/// planes among the matches of one association. A match has three rows: of a plane the first is RES-1 and the others
/// are zero, of a point they are RES-2. A point has a standard deviation of its own, `point_sigma`, because the nearest
/// point of a map lies as far off as its points are apart.
class Hybrid final : public Residual {
 public:
  enum class Weighting : std::uint8_t { none, share };
  struct Params {
    std::int64_t k = 5;
    double max_distance = 1.0;
    double plane_threshold = 0.1;
    std::optional<double> planarity = std::nullopt;
    double min_spread = 0.1;
    double gate = 81.0;
    double point_sigma = 0.15;
    double point_gate = 3.0;
    PointToPoint::Kernel point_kernel = PointToPoint::Kernel::geman_mcclure;
    Weighting weighting = Weighting::share;
  };
  static void describe(config::Binder& b, Params& p);
  Hybrid(const Params& params, const BuildContext& context);

  int rows_per_match() const override { return 3; }
  MapQuery query() const override { return planes_.query(); }
  void set_noise_scale(double scale) override { planes_.set_noise_scale(scale); }
  void fit(std::span<const Vec3> queries, const Neighbours& neighbours, std::span<Surface> out) override;
  void evaluate(std::span<const Vec3> world, std::span<const float> range, std::span<const Surface> surfaces,
                double sigma, std::span<ResidualRow> rows) override;

 private:
  double point_sigma_;
  Weighting weighting_;
  PointToPlane planes_;
  PointToPoint points_;
  exec::Executor& exec_;
};

}  // namespace aslio::plugins
