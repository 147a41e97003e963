#pragma once

#include <optional>

#include "aslio/config/binder.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/stages/residual.hpp"

namespace aslio::plugins {

/// Distance of a point to the plane through its k nearest neighbours, or to the plane the map keeps there, r = n . (p -
/// centroid) (docs/equations.md RES-1; AS-LIO (11)). A plane needs all k neighbours, or k_min of them where that is
/// set, none farther than plane_threshold from it, and neighbours that spread in two directions. The gate is
/// FAST-LIO2's: 1 - 0.9 |r| / sqrt(range) > 0.9, which is range > 81 r^2; `max_residual` is the plain limit of CT-ICP
/// and SR-LIO. With `plane_sigma`, all matches of one plane of the map share its error (RES-5).
class PointToPlane final : public Residual {
 public:
  enum class Planes : std::uint8_t { neighbours, map };
  enum class Weighting : std::uint8_t { none, planarity };
  enum class Kernel : std::uint8_t { none, huber, cauchy };
  struct Params {
    Planes planes = Planes::neighbours;
    std::int64_t k = 5;
    std::int64_t k_min = 0;
    double max_distance = 1.0;
    double plane_threshold = 0.1;
    std::optional<double> planarity = std::nullopt;
    double min_spread = 0.1;
    double gate = 81.0;
    std::optional<double> max_residual = std::nullopt;
    Weighting weighting = Weighting::none;
    Kernel kernel = Kernel::none;
    double kernel_width = 0.1;
    double plane_sigma = 0.0;
  };
  static void describe(config::Binder& b, Params& p);
  PointToPlane(const Params& params, const BuildContext& context);

  int rows_per_match() const override { return 1; }
  MapQuery query() const override;
  bool surfaces_from_map() const override { return params_.planes == Planes::map; }
  bool counts_shared_matches() const override { return surfaces_from_map() && params_.plane_sigma > 0.0; }
  void set_noise_scale(double scale) override;
  void fit(std::span<const Vec3> queries, const Neighbours& neighbours, std::span<Surface> out) override;
  void evaluate(std::span<const Vec3> world, std::span<const float> range, std::span<const Surface> surfaces,
                double sigma, std::span<ResidualRow> rows) override;

  /// The row of one match. Pre: the surface is valid. `range`: |p_L| [m].
  ResidualRow row_of(const Vec3& world, float range, const Surface& surface, double sigma) const;

 private:
  bool fits(const Neighbours& neighbours, std::size_t query, std::size_t count) const;
  void fit_batch(std::span<const Vec3> queries, const Neighbours& neighbours, std::size_t begin, std::size_t end,
                 std::size_t count, std::span<Surface> out) const;
  double weight(double r) const;
  inline ResidualRow row(const Vec3& world, float range, const Surface& surface, double variance) const;

  Params params_;
  double kernel_width_;  ///< for the noise there is [m]
  exec::Executor& exec_;
};

}  // namespace aslio::plugins
