#pragma once

#include "aslio/config/binder.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/stages/residual.hpp"

namespace aslio::plugins {

/// Vector from the nearest point of the map, r = p - q, one row per axis (docs/equations.md RES-2). The robust weight
/// is that of its length; `sigma` sets the gate and the width of the kernel, so an estimator that learns it adapts
/// both (KISS-ICP).
class PointToPoint final : public Residual {
 public:
  enum class Kernel : std::uint8_t { none, geman_mcclure };
  struct Params {
    double max_distance = 1.5;
    double gate = 3.0;
    Kernel kernel = Kernel::geman_mcclure;
  };
  static void describe(config::Binder& b, Params& p);
  PointToPoint(const Params& params, const BuildContext& context);

  int rows_per_match() const override { return 3; }
  MapQuery query() const override { return {.k = 1, .max_distance = params_.max_distance}; }
  void fit(std::span<const Vec3> queries, const Neighbours& neighbours, std::span<Surface> out) override;
  void evaluate(std::span<const Vec3> world, std::span<const float> range, std::span<const Surface> surfaces,
                double sigma, std::span<ResidualRow> rows) override;

  /// The surface of query `i` of a batch; not valid where nothing was found.
  void fit_one(const Vec3& query, const Neighbours& neighbours, std::size_t i, Surface& out) const;
  /// The three rows of one match, times the quality of its surface. Pre: the surface is valid.
  void rows_of(const Vec3& world, const Surface& surface, double sigma, std::span<ResidualRow> rows) const;

 private:
  Params params_;
  exec::Executor& exec_;
};

}  // namespace aslio::plugins
