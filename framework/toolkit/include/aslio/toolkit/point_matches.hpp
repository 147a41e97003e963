#pragma once
/// Points of one class (fresh or history) and what they match in the map, over the iterations of a registration.

#include <algorithm>
#include <limits>
#include <span>
#include <vector>

#include "aslio/stages/estimator.hpp"
#include "aslio/toolkit/match_tally.hpp"

namespace aslio {

/// Points per chunk of a reduction over matches. It decides how sums are rounded.
inline constexpr std::size_t kGrain = 512;

/// Fills `spectrum` and `weakest` of an update: eigenvalues of the pose information A (theta, p), ascending, a rotation
/// counted at a lever arm of 5 m, so that all are 1/m^2, and the eigenvector of the least. eq. IESKF-7.
void set_spectrum(Update& update, const Mat6& A);

/// How many windows as long as this one `time` [s] holds, at least 1. eqs. IESKF-7, RES-5.
double windows_per(double time, const WindowPlan& plan);
/// The same for 0.1 s, a view.
double windows_per_view(const WindowPlan& plan);

/// Whether the weakest direction is known worse than `sigma` [m] by all such windows of 0.1 s together. `plan`: of the
/// window. eq. IESKF-7.
bool unobservable_direction(const std::array<double, 6>& spectrum, double sigma, const WindowPlan& plan);

/// Covariance of a pose (rotation, position) of which `information` is known: no worse than 1e3 (rad, m) where nothing
/// was seen of a direction.
Mat6 bounded_covariance(const Mat6& information);

/// What became of one match, given its rows, and its |r|^2 [m^2]: of the rows that take part, or of all that measure
/// where none does.
MatchRecord record_of(std::span<const ResidualRow> rows, double& squares);

/// What became of every match, given its rows of the last evaluation, and the root mean square of |r| over those with a
/// row that takes part [m]. Returns how many they are. Pre: rows_per_match rows of each, in order.
std::size_t record_matches(std::span<const ResidualRow> rows, std::size_t rows_per_match, std::vector<MatchRecord>& out,
                           double& rms);

/// Whether a match, given its rows, passes a gate: as a whole, when r^2 is beyond `limit` [m^2] in no row that has
/// information. What is not a number passes, and the update reports it.
inline bool within(std::span<const ResidualRow> rows, double limit) {
  return std::all_of(rows.begin(), rows.end(),
                     [limit](const ResidualRow& z) { return !z.takes_part() || !(z.r * z.r > limit); });
}

/// Matches of which a row takes part and that pass the gate `limit` [m^2] (within()), given their rows. `taking_part`:
/// rows that do. A residual may leave out some rows of a match (RES-6), so that this is no quotient.
std::size_t count_matches(std::span<const ResidualRow> rows, std::size_t rows_per_match, std::size_t taking_part,
                          double limit = std::numeric_limits<double>::infinity());

struct PointMatches {
  std::vector<Vec3> body, world;  ///< at the end of the window; where the iterate places them
  std::vector<float> range;       ///< |p_L| [m]
  std::vector<double> weight;     ///< factor on the information of each point; empty: 1
  Neighbours neighbours;
  std::vector<Surface> surfaces;
  MatchTally tally;
  std::vector<ResidualRow> rows;  ///< Residual::rows_per_match() for each point

  /// Room for `points`; no allocation while they do not double.
  void reserve(std::size_t points, const Residual& residual);
  /// What the points match at `world`, seen from `viewpoint` (W); those of one surface of the map are counted, each
  /// `times` (RES-5).
  void associate(const Map& map, Residual& residual, const Vec3& viewpoint, std::uint32_t max_stamp,
                 std::uint8_t feature = feature_class::none, double times = 1.0);
  /// The same, not counted: for points that are registered together with others.
  void match(const Map& map, Residual& residual, const Vec3& viewpoint, std::uint32_t max_stamp,
             std::uint8_t feature = feature_class::none);
  /// Rows at `world`.
  void evaluate(Residual& residual, double sigma);
  /// World points of the frame at pose `T`.
  void place(const Pose& T);
  /// The points of a history, seen from `prior`; they keep their place in it (eq. HIS-1).
  void load(const HistorySelection& past, const Pose& prior);
  /// record_matches() of the last rows.
  std::size_t record(std::size_t rows_per_match, std::vector<MatchRecord>& out, double& rms) const {
    return record_matches(rows, rows_per_match, out, rms);
  }
};

}  // namespace aslio
