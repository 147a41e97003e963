#include "aslio/toolkit/point_matches.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace aslio {

void set_spectrum(Update& update, const Mat6& A) {
  constexpr double lever_arm = 5.0;  // [m]
  Vec6 scale;
  scale << Vec3::Constant(1.0 / lever_arm), Vec3::Ones();
  const Mat6 scaled = scale.asDiagonal() * A * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Mat6> solver(scaled);
  for (int i = 0; i < 6; ++i) update.spectrum[static_cast<std::size_t>(i)] = solver.eigenvalues()[i];
  update.weakest = solver.eigenvectors().col(0);
}

double windows_per(double time, const WindowPlan& plan) {
  constexpr double shortest = 1e-3;  // [s]
  return std::max(1.0, time / std::max(to_seconds(plan.end - plan.fresh_begin), shortest));
}

double windows_per_view(const WindowPlan& plan) { return windows_per(0.1, plan); }

bool unobservable_direction(const std::array<double, 6>& spectrum, double sigma, const WindowPlan& plan) {
  return sigma * sigma * spectrum[0] * windows_per_view(plan) < 1.0;
}

Mat6 bounded_covariance(const Mat6& information) {
  const Mat6 bounded = information + 1e-6 * Mat6::Identity();
  return bounded.ldlt().solve(Mat6::Identity());
}

void PointMatches::reserve(std::size_t points, const Residual& residual) {
  if (points <= body.capacity()) return;
  points *= 2;  // windows vary with what is in view: one that is twice as full needs no memory
  const auto k = static_cast<std::size_t>(residual.query().k);
  body.reserve(points);
  world.reserve(points);
  range.reserve(points);
  weight.reserve(points);
  surfaces.reserve(points);
  if (residual.counts_shared_matches()) tally.reserve(points);
  rows.reserve(points * static_cast<std::size_t>(residual.rows_per_match()));
  neighbours.count.reserve(points);
  neighbours.offsets.reserve(points * k);
  neighbours.squared.reserve(points * k);
}

void PointMatches::place(const Pose& T) {
  world.resize(body.size());
  for (std::size_t i = 0; i < body.size(); ++i) world[i] = T * body[i];
}

void PointMatches::associate(const Map& map, Residual& residual, const Vec3& viewpoint, std::uint32_t max_stamp,
                             std::uint8_t feature, double times) {
  match(map, residual, viewpoint, max_stamp, feature);
  if (residual.counts_shared_matches() && residual.surfaces_from_map()) tally.count(surfaces, times);
}

void PointMatches::match(const Map& map, Residual& residual, const Vec3& viewpoint, std::uint32_t max_stamp,
                         std::uint8_t feature) {
  surfaces.resize(body.size());
  MapQuery query = residual.query();
  query.max_stamp = max_stamp;
  query.feature = feature;
  query.viewpoint = viewpoint;
  if (residual.surfaces_from_map()) {
    map.surfaces(world, query, surfaces);
    return;
  }
  map.correspond(world, query, neighbours);
  residual.fit(world, neighbours, surfaces);
}

void PointMatches::evaluate(Residual& residual, double sigma) {
  rows.resize(body.size() * static_cast<std::size_t>(residual.rows_per_match()));
  residual.evaluate(world, range, surfaces, sigma, rows);
}

void PointMatches::load(const HistorySelection& past, const Pose& prior) {
  const Pose I_from_W = prior.inverse();
  const std::size_t n = past.points.size();
  body.resize(n);
  range.resize(n);
  weight.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    body[i] = I_from_W * past.points[i].p_W;
    range[i] = past.points[i].range;
    weight[i] = past.points[i].age_weight;
  }
}

MatchRecord record_of(std::span<const ResidualRow> rows, double& squares) {
  MatchRecord out;
  double last = 0;
  squares = 0;
  for (const ResidualRow& row : rows) {
    out.matched = out.matched || row.measures();
    out.accepted = out.accepted || row.takes_part();
  }
  for (const ResidualRow& row : rows) {
    if (!(out.accepted ? row.takes_part() : row.measures())) continue;
    squares += row.r * row.r;
    last = row.r;
  }
  // One row is signed; several are the components of a vector.
  if (out.matched) out.residual = static_cast<float>(rows.size() == 1 ? last : std::sqrt(squares));
  return out;
}

std::size_t record_matches(std::span<const ResidualRow> rows, std::size_t rows_per_match, std::vector<MatchRecord>& out,
                           double& rms) {
  out.assign(rows.size() / rows_per_match, MatchRecord{});
  double squares = 0;
  std::size_t accepted = 0;
  for (std::size_t i = 0; i < out.size(); ++i) {
    double own = 0;
    out[i] = record_of(rows.subspan(i * rows_per_match, rows_per_match), own);
    if (!out[i].accepted) continue;
    squares += own;
    ++accepted;
  }
  rms = accepted > 0 ? std::sqrt(squares / static_cast<double>(accepted)) : 0.0;
  return accepted;
}

std::size_t count_matches(std::span<const ResidualRow> rows, std::size_t rows_per_match, std::size_t taking_part,
                          double limit) {
  if (rows_per_match == 1) return taking_part;
  std::size_t count = 0;
  for (std::size_t first = 0; first + rows_per_match <= rows.size(); first += rows_per_match) {
    const auto match = rows.subspan(first, rows_per_match);
    const bool any = std::any_of(match.begin(), match.end(), [](const ResidualRow& row) { return row.takes_part(); });
    count += any && within(match, limit) ? 1 : 0;
  }
  return count;
}

}  // namespace aslio
