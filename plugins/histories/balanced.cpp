#include "histories/balanced.hpp"

#include <algorithm>

namespace aslio::plugins {

namespace {

Reuse rules(const BalancedHistory::Params& p) {
  return {.self_match_exclusion = p.self_match_exclusion,
          .covariance = p.covariance,
          .cap = p.rho == 0.0 ? 0.0 : p.cap,  // what weighs nothing need not be matched
          .age_taper = p.age_taper,
          .gate = p.gate,
          .max_residual = p.max_residual,
          .refused = p.refused};
}

}  // namespace

void BalancedHistory::describe(config::Binder& b, Params& p) {
  b.real("rho", p.rho, "", {.min = 0.0, .max = 1000.0},
         "weight of all history residuals together, relative to all fresh ones; 0 leaves the history out");
  b.real("cap", p.cap, "", {.above = 0.0, .max = 1000.0}, kCapDoc);
  describe_covariance(b, p.covariance);
  describe_age_taper(b, p.age_taper);
  b.real("gate", p.gate, "sigma", {.above = 0.0, .max = 1000.0}, kGateDoc);
  b.real("max_residual", p.max_residual, "m", {.above = 0.0, .max = 1000.0}, kMaxResidualDoc);
  describe_refused(b, p.refused);
  describe_self_match_exclusion(b, p.self_match_exclusion);
}

BalancedHistory::BalancedHistory(const Params& params, const BuildContext&)
    : WindowHistory(rules(params)), rho_(params.rho) {}

double BalancedHistory::weight(std::size_t fresh_residuals, std::size_t history_residuals) const {
  if (history_residuals == 0) return 0.0;
  const double ratio = static_cast<double>(fresh_residuals) / static_cast<double>(history_residuals);
  return std::min(1.0, rho_ * ratio);
}

}  // namespace aslio::plugins
