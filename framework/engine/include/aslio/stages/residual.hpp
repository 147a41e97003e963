#pragma once
/// Residuals: what does a match measure, and with which noise? They speak of world points only; the estimator chains
/// J_world with its trajectory model (d p_W / d xi).

#include <cstdint>
#include <span>

#include "aslio/stages/map.hpp"

namespace aslio {

/// One scalar row: r = h(p_W) [m], J = dr/dp_W, information 1/R [1/m^2] (0: the row takes no part).
struct ResidualRow {
  double r = 0;
  Vec3 J = Vec3::Zero();
  double information = 0;

  /// NaN takes part: what it makes of an update is not finite, which is said; to leave the row out would hide it.
  bool takes_part() const { return !(information <= 0.0); }
  /// There is a surface, whether or not a gate lets it take part.
  bool measures() const { return !J.isZero(0.0); }
};

/// Contract. fit() turns the neighbours of each query into a surface; it is called once per association. A residual
/// may take the surfaces of the map instead. evaluate() is
/// called at every iteration with the current world points; it writes rows_per_match() rows for each match and applies
/// gates and robust weights: what a gate leaves out keeps r and J with no information, what has no surface or no finite
/// residual is all zero. `range[i]` is |p_L| [m]. Deterministic; may use its executor; no allocation.
class Residual : public Stage {
 public:
  static constexpr std::string_view family = "residuals";
  virtual int rows_per_match() const = 0;
  /// What to ask the map for.
  virtual MapQuery query() const = 0;
  /// Whether the surfaces are those the map keeps (Map::surfaces()) rather than fitted to neighbours: then fit() is not
  /// called.
  virtual bool surfaces_from_map() const { return false; }
  /// Whether the noise of a row depends on Surface::shared_matches, which an estimator may count once per association;
  /// left as they are, every match stands alone.
  virtual bool counts_shared_matches() const { return false; }
  /// Lengths that are about the noise of points (width of a kernel) count so many times what the parameters say; > 0.
  /// The sigma of evaluate() is for the caller to scale.
  virtual void set_noise_scale(double scale) { (void)scale; }
  virtual void fit(std::span<const Vec3> queries, const Neighbours& neighbours, std::span<Surface> out) = 0;
  virtual void evaluate(std::span<const Vec3> world, std::span<const float> range, std::span<const Surface> surfaces,
                        double sigma, std::span<ResidualRow> rows) = 0;
};

}  // namespace aslio
