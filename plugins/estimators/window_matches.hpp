#pragma once

#include <span>
#include <vector>

#include "aslio/core/types.hpp"
#include "aslio/exec/executor.hpp"
#include "aslio/toolkit/deskewed_scan.hpp"
#include "aslio/toolkit/information_update.hpp"
#include "aslio/toolkit/point_matches.hpp"

namespace aslio::plugins {

/// Points of a window, fresh or of its history, over the iterations: what each sees of the error of the window's end,
/// and the sums of their rows (docs/equations.md IESKF-1, DSK-3).
struct WindowMatches : PointMatches {
  std::vector<double> lag;  ///< time before the end of the window [s]; empty: rows do not depend on it
  /// Per match, 1: a gate has left it out since `left_out` was set to zeros, so that it takes no part; empty: the gates
  /// decide at every evaluation.
  std::vector<std::uint8_t> left_out;
  std::vector<double> share;  ///< of the pose error of the end that a point sees; empty: 1

  /// Room for `n` points and the sums of their chunks.
  void reserve(std::size_t n, const Residual& residual);
  using PointMatches::load;
  /// The points of `frame` that are matched, at the end of its window. `lag` and `share` become empty.
  void load(const DeskewedScan& frame);
  /// Rows of all points at the pose of `at`, and their sums over the points that lie within `gate` [m] of their
  /// surface. The same bits for any number of threads.
  WindowInformation sum_up(Residual& residual, double sigma, const NavState& at, double gate, exec::Executor& exec);
  /// Matches of the last sum, of whose rows `taking_part` took part. `gate` [m] as there.
  std::size_t matches(std::size_t rows_per_match, std::size_t taking_part, double gate) const;
  /// f(i, row, information) for the rows of the last sum that took part, in order: of point i, with its weight. `gate`
  /// [m] as there.
  template <class F>
  void each_row(std::size_t rows_per_match, double gate, F&& f) const {
    for (std::size_t i = 0; i < body.size(); ++i) {
      const auto match = std::span<const ResidualRow>(rows).subspan(i * rows_per_match, rows_per_match);
      if ((!left_out.empty() && left_out[i] != 0) || !within(match, gate * gate)) continue;
      for (const ResidualRow& z : match) {
        if (z.takes_part()) f(i, z, (weight.empty() ? 1.0 : weight[i]) * z.information);
      }
    }
  }

 private:
  std::vector<WindowInformation> partials_;
};

}  // namespace aslio::plugins
