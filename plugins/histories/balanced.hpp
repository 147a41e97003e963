#pragma once
/// `balanced`: old points of the window weigh together `rho` times what the fresh ones weigh, whatever their number,
/// and match only what was in the map before the window began. (HIS-2)

#include <optional>

#include "aslio/stages/build_context.hpp"
#include "histories/window_history.hpp"

namespace aslio::plugins {

class BalancedHistory final : public WindowHistory {
 public:
  struct Params {
    double rho = 0.25;
    double cap = 2.0;
    HistoryCovariance covariance = HistoryCovariance::joseph;
    std::optional<double> age_taper = std::nullopt;
    double gate = 3.0;
    double max_residual = 0.1;
    Refused refused = Refused::enter;
    bool self_match_exclusion = true;
  };
  static void describe(config::Binder& b, Params& p);

  BalancedHistory(const Params& params, const BuildContext& context);

  /// min(1, rho N_fresh / N_history): the history as a whole weighs rho times the fresh points.
  double weight(std::size_t fresh_residuals, std::size_t history_residuals) const override;

 private:
  double rho_;
};

}  // namespace aslio::plugins
