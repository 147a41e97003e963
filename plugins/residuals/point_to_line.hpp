#pragma once

#include "aslio/config/binder.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/stages/residual.hpp"

namespace aslio::plugins {

/// Distance of a point to the line through its k nearest neighbours, as the two components of p - centroid across the
/// line (docs/equations.md RES-4; LOAM). A line needs all k neighbours, and a scatter whose largest eigenvalue exceeds
/// `elongation` times the middle one. The robust weight is that of the distance.
class PointToLine final : public Residual {
 public:
  enum class Kernel : std::uint8_t { none, huber, cauchy };
  struct Params {
    std::int64_t k = 5;
    double max_distance = 1.0;
    double elongation = 3.0;
    double gate = 0.0;
    Kernel kernel = Kernel::huber;
    double kernel_width = 0.1;
  };
  static void describe(config::Binder& b, Params& p);
  PointToLine(const Params& params, const BuildContext& context);

  int rows_per_match() const override { return 2; }
  MapQuery query() const override;
  void fit(std::span<const Vec3> queries, const Neighbours& neighbours, std::span<Surface> out) override;
  void evaluate(std::span<const Vec3> world, std::span<const float> range, std::span<const Surface> surfaces,
                double sigma, std::span<ResidualRow> rows) override;

 private:
  Surface line_through(const Vec3& query, const Neighbours& neighbours, std::size_t i) const;
  double weight(double distance) const;

  Params params_;
  exec::Executor& exec_;
};

}  // namespace aslio::plugins
