#include "histories/balanced.hpp"

#include <algorithm>
#include <cmath>

#include "aslio/stages/estimator.hpp"

namespace aslio::plugins {

void BalancedHistory::describe(config::Binder& b, Params& p) {
  b.real("rho", p.rho, "", {.min = 0.0, .max = 1000.0},
         "weight of all history residuals together, relative to all fresh ones; 0 leaves the history out");
  b.real("cap", p.cap, "", {.above = 0.0, .max = 1000.0}, "most history points per fresh point");
  b.choice("covariance", p.covariance,
           {{"joseph", HistoryCovariance::joseph},
            {"new_only", HistoryCovariance::new_only},
            {"all", HistoryCovariance::all}},
           "what the covariance counts: fresh evidence through the actual gain, fresh evidence alone, or everything "
           "(over-confident)");
  b.optional_real("age_taper", p.age_taper, "s", {.above = 0.0, .max = 1000.0}, "no taper",
                  "time in which the weight of a point falls by a factor e");
  b.real("gate", p.gate, "sigma", {.above = 0.0, .max = 1000.0}, "largest residual of a history point that takes part");
  b.real("max_residual", p.max_residual, "m", {.above = 0.0, .max = 1000.0},
         "largest residual at its own update with which a point enters the history");
}

BalancedHistory::BalancedHistory(const Params& params, const BuildContext&) : params_(params) {}

HistorySelection BalancedHistory::select(const Window& window) {
  const WindowPlan& plan = window.plan;
  forget(plan.history_begin);
  // Also of a window that will be refused: its points may enter the map all the same.
  ends_.push_back({window.sequence, plan.end});
  HistorySelection selection{.points = {}, .max_stamp = max_stamp_, .covariance = params_.covariance};
  if (params_.rho == 0.0 || head_ == points_.size()) return selection;

  // Evenly spread over what is there: thinning by residual would favour what already agreed with the map.
  const std::size_t offered = points_.size() - head_;
  const std::size_t kept = std::min(offered, most(window));
  selected_.clear();
  for (std::size_t i = 0; i < kept; ++i) {
    HistoryPoint point = points_[head_ + i * offered / kept];
    if (point.t <= plan.history_begin || point.t > plan.fresh_begin) continue;
    if (params_.age_taper) {
      point.age_weight = static_cast<float>(std::exp(-to_seconds(plan.end - point.t) / *params_.age_taper));
    }
    selected_.push_back(point);
  }
  selection.points = selected_;
  return selection;
}

std::size_t BalancedHistory::most(const Window& window) const {
  // How many fresh points sampling will leave is known only after de-skew; the share it left last time stands in.
  const double fresh = matched_per_fresh_ * static_cast<double>(window.fresh.size());
  return static_cast<std::size_t>(params_.cap * fresh);
}

double BalancedHistory::weight(std::size_t fresh_residuals, std::size_t history_residuals) const {
  if (history_residuals == 0) return 0.0;
  const double ratio = static_cast<double>(fresh_residuals) / static_cast<double>(history_residuals);
  return std::min(1.0, params_.rho * ratio);
}

void BalancedHistory::commit(const Window& window, const Update& update) {
  const auto points = update.points(Tap::match);
  for (std::size_t i = 0; i < points.size(); ++i) {
    HistoryPoint point{.p_W = points[i].p_W, .t = points[i].t, .range = points[i].range};
    const bool matched = i < update.matches.size() && update.matches[i].accepted;
    point.residual = matched ? std::abs(update.matches[i].residual) : -1.0f;
    point.sequence = window.sequence;
    if (point.residual <= static_cast<float>(params_.max_residual)) points_.push_back(point);
  }
  if (!window.fresh.empty()) {
    matched_per_fresh_ = static_cast<double>(points.size()) / static_cast<double>(window.fresh.size());
  }
}

void BalancedHistory::reset() {
  // What earlier updates put into the map stays there, so their ends are not forgotten.
  points_.clear();
  head_ = 0;
}

void BalancedHistory::forget(TimeNs until) {
  while (head_ < points_.size() && points_[head_].t <= until) ++head_;
  if (head_ > points_.size() / 2) {
    points_.erase(points_.begin(), points_.begin() + static_cast<std::ptrdiff_t>(head_));
    head_ = 0;
  }
  std::size_t older = 0;
  while (older < ends_.size() && ends_[older].t <= until) max_stamp_ = ends_[older++].sequence;
  ends_.erase(ends_.begin(), ends_.begin() + static_cast<std::ptrdiff_t>(older));
}

}  // namespace aslio::plugins
