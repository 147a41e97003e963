#include "estimators/window_matches.hpp"

#include <algorithm>

#include "aslio/toolkit/information_lanes.hpp"

namespace aslio::plugins {

void WindowMatches::reserve(std::size_t n, const Residual& residual) {
  PointMatches::reserve(n, residual);
  lag.reserve(body.capacity());
  share.reserve(body.capacity());
  left_out.reserve(body.capacity());
  partials_.reserve(exec::Executor::chunk_count(body.capacity(), kGrain));
}

void WindowMatches::load(const DeskewedScan& frame) {
  body.assign(frame.match_body().begin(), frame.match_body().end());
  range.assign(frame.match_range().begin(), frame.match_range().end());
  lag.clear();
  share.clear();
  left_out.clear();
}

WindowInformation WindowMatches::sum_up(Residual& residual, double sigma, const NavState& at, double gate,
                                        exec::Executor& exec) {
  const double squared = gate * gate;
  evaluate(residual, sigma);
  partials_.resize(exec::Executor::chunk_count(body.size(), kGrain));
  const auto rows_per_match = static_cast<std::size_t>(residual.rows_per_match());
  const Mat3 Rt = at.R.transpose();
  const auto sum_of = [&](std::size_t begin, std::size_t end) {
    WindowInformation sum;
    InformationLanes lanes(Rt);
    for (std::size_t i = begin; i < end; ++i) {
      const auto match = std::span<const ResidualRow>(rows).subspan(i * rows_per_match, rows_per_match);
      if (!left_out.empty()) {
        if (std::none_of(match.begin(), match.end(), [](const auto& row) { return row.takes_part(); })) left_out[i] = 1;
        if (left_out[i] != 0) continue;
      }
      if (!within(match, squared)) continue;
      for (const ResidualRow& z : match) {
        if (!z.takes_part()) continue;
        const double information = (weight.empty() ? 1.0 : weight[i]) * z.information;
        if (lag.empty()) {
          lanes.add(body[i], z.J, z.r, information, share.empty() ? 1.0 : share[i]);  // eq. IESKF-1
        } else {
          sum.add_late(body[i], Rt, z.J, z.r, information, lag[i]);
        }
      }
    }
    static_cast<PoseInformation&>(sum) += lanes.total();
    return sum;
  };
  return exec.reduce(body.size(), kGrain, WindowInformation{}, std::span<WindowInformation>(partials_), sum_of,
                     [](WindowInformation& total, const WindowInformation& part) { total += part; });
}

std::size_t WindowMatches::matches(std::size_t rows_per_match, std::size_t taking_part, double gate) const {
  if (rows_per_match == 1 || left_out.empty()) return count_matches(rows, rows_per_match, taking_part, gate * gate);
  std::size_t count = 0;
  for (std::size_t i = 0; i < left_out.size(); ++i) {
    const auto match = std::span<const ResidualRow>(rows).subspan(i * rows_per_match, rows_per_match);
    count += left_out[i] == 0 && within(match, gate * gate) ? 1 : 0;
  }
  return count;
}

}  // namespace aslio::plugins
