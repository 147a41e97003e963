#pragma once
/// Histories: what are old points of the window worth? (docs/equations.md HIS-1..)

#include <cstdint>
#include <span>

#include "aslio/stages/points.hpp"
#include "aslio/stages/window.hpp"

namespace aslio {

struct Update;  // stages/estimator.hpp

/// A point of an earlier update still inside the window, at the world position its own update gave it.
struct HistoryPoint {
  Vec3 p_W = Vec3::Zero();
  TimeNs t = 0;
  float range = 0;             ///< |p_L| when measured [m]
  float residual = 0;          ///< |z| at its own update [m]; negative: none that counts
  std::uint32_t sequence = 0;  ///< the update that measured it
  float age_weight = 1;        ///< taper by age, multiplied into the weight
};

/// How the covariance treats re-used evidence.
enum class HistoryCovariance : std::uint8_t { joseph, new_only, all };

/// The points of earlier updates that may take part, and the rule for their neighbours.
struct HistorySelection {
  std::span<const HistoryPoint> points;
  std::uint32_t max_stamp = 0;  ///< neighbours must have been inserted at this update or before (self-match exclusion)
  HistoryCovariance covariance = HistoryCovariance::joseph;
};

/// Contract. select() gives the history of a window; commit() stores the fresh points of an accepted update, or
/// of the first window (each once); reset() forgets all, after a refused update and before that of one which begins the
/// map anew (Update::restart_map). weight() is asked by the estimator once per iteration with the numbers of accepted
/// residuals. Not thread-safe. No allocation after warm-up.
class HistoryPolicy : public Stage {
 public:
  static constexpr std::string_view family = "histories";
  /// Whether it ever selects any.
  virtual bool gives_points() const { return true; }
  virtual HistorySelection select(const Window& window) = 0;
  /// Factor on the information of each history residual, >= 0.
  virtual double weight(std::size_t fresh_residuals, std::size_t history_residuals) const = 0;
  /// Largest |z| [m] at which a history residual takes part, given its sigma [m].
  virtual double gate(double sigma) const = 0;
  virtual void commit(const Window& window, const Update& update) = 0;
  virtual void reset() = 0;
};

}  // namespace aslio
