#include "histories/window_history.hpp"

#include <algorithm>
#include <cmath>

#include "aslio/stages/estimator.hpp"

namespace aslio::plugins {

void describe_self_match_exclusion(config::Binder& b, bool& value) {
  b.flag("self_match_exclusion", value,
         "history points match only what entered the map before the window began, so neither themselves nor their "
         "neighbours in time");
}

void describe_covariance(config::Binder& b, HistoryCovariance& value) {
  b.choice("covariance", value,
           {{"joseph", HistoryCovariance::joseph},
            {"new_only", HistoryCovariance::new_only},
            {"all", HistoryCovariance::all}},
           "what the covariance counts: fresh evidence through the actual gain, fresh evidence alone, or everything "
           "(over-confident). Estimators without a filter (ct_icp, icp) ignore it");
}

void describe_age_taper(config::Binder& b, std::optional<double>& value) {
  b.optional_real("age_taper", value, "s", {.above = 0.0, .max = 1000.0}, "no taper",
                  "time in which the weight of a point falls by a factor e");
}

void describe_refused(config::Binder& b, Refused& value) {
  b.choice("refused", value, {{"enter", Refused::enter}, {"by_residual", Refused::by_residual}},
           "points whose match a gate refused at their own update. enter: as if they had found no surface; "
           "by_residual: by max_residual as all others (without it: all enter)");
}

void Reuse::describe(config::Binder& b, Reuse& p) {
  describe_self_match_exclusion(b, p.self_match_exclusion);
  describe_covariance(b, p.covariance);
  b.optional_real("cap", p.cap, "", {.min = 0.0, .max = 1000.0}, "no cap", kCapDoc);
  describe_age_taper(b, p.age_taper);
  b.optional_real("gate", p.gate, "sigma", {.above = 0.0, .max = 1000.0}, "no gate", kGateDoc);
  b.optional_real("max_residual", p.max_residual, "m", {.above = 0.0, .max = 1000.0}, "any", kMaxResidualDoc);
  describe_refused(b, p.refused);
  b.flag("redeskew", p.redeskew,
         "old points follow the newest posterior: between two updates the IMU moves them, not the correction");
}

HistorySelection WindowHistory::select(const Window& window) {
  const WindowPlan& plan = window.plan;
  forget(plan.history_begin);
  // Also of a window that will be refused: its points may enter the map all the same.
  ends_.push_back({window.sequence, plan.end});
  HistorySelection selection{.points = {}, .max_stamp = 0xffffffff, .covariance = reuse_.covariance};
  if (reuse_.self_match_exclusion) selection.max_stamp = max_stamp_;

  // Evenly spread over what is there: thinning by residual would favour what already agreed with the map.
  const std::size_t offered = points_.size() - head_;
  const std::size_t kept = most(window, offered);
  selected_.clear();
  if (reuse_.redeskew) follow_imu();
  auto link = links_.begin();
  for (std::size_t i = 0; i < kept; ++i) {
    HistoryPoint point = points_[head_ + i * offered / kept];
    if (point.t <= plan.history_begin || point.t > plan.fresh_begin) continue;
    if (reuse_.age_taper) {
      point.age_weight = static_cast<float>(std::exp(-to_seconds(plan.end - point.t) / *reuse_.age_taper));
    }
    if (reuse_.redeskew) {
      link = std::find_if(link, links_.end(), [&](const Link& l) { return l.sequence >= point.sequence; });
      if (link != links_.end() && link->sequence == point.sequence) point.p_W = link->move * point.p_W;
    }
    selected_.push_back(point);
  }
  selection.points = selected_;
  return selection;
}

std::size_t WindowHistory::most(const Window& window, std::size_t offered) const {
  if (!reuse_.cap) return offered;
  // How many fresh points sampling will leave is known only after de-skew; the share it left last time stands in. Where
  // a sampler changes its share (SMP-1), one window has that many times more or fewer old points than the cap.
  const double fresh = matched_per_fresh_ * static_cast<double>(window.fresh.size());
  return std::min(offered, static_cast<std::size_t>(*reuse_.cap * fresh));
}

void WindowHistory::link(const Window& window, const Update& update) {
  Link link;
  link.sequence = window.sequence;
  link.end = window.plan.end;
  link.posterior = update.state.pose();
  if (!links_.empty()) link.predicted_begin = update.prior.pose().inverse() * links_.back().posterior;
  links_.push_back(link);
}

// eq. HIS-5, from the newest update backwards.
void WindowHistory::follow_imu() {
  if (links_.empty()) return;
  Pose end = links_.back().posterior;
  links_.back().move = Pose{};
  for (std::size_t k = links_.size() - 1; k-- > 0;) {
    end = end * links_[k + 1].predicted_begin;
    links_[k].move = end * links_[k].posterior.inverse();
  }
}

void WindowHistory::commit(const Window& window, const Update& update) {
  if (reuse_.redeskew) link(window, update);
  const auto points = update.points(PointUse::match);
  for (std::size_t i = 0; i < points.size(); ++i) {
    HistoryPoint point{.p_W = points[i].p_W, .t = points[i].t, .range = points[i].range};
    point.residual = i < update.matches.size() ? residual_of(update.matches[i]) : -1.0f;
    point.sequence = window.sequence;
    if (reuse_.max_residual && !(point.residual <= static_cast<float>(*reuse_.max_residual))) continue;
    points_.push_back(point);
  }
  if (!window.fresh.empty()) {
    matched_per_fresh_ = static_cast<double>(points.size()) / static_cast<double>(window.fresh.size());
  }
}

float WindowHistory::residual_of(const MatchRecord& match) const {
  const bool counts = reuse_.refused == Refused::by_residual ? match.matched || match.accepted : match.accepted;
  return counts ? std::abs(match.residual) : -1.0f;
}

void WindowHistory::reset() {
  // What earlier updates put into the map stays there, so their ends are not forgotten.
  points_.clear();
  links_.clear();
  head_ = 0;
}

void WindowHistory::forget(TimeNs until) {
  while (head_ < points_.size() && points_[head_].t <= until) ++head_;
  if (head_ > points_.size() / 2) {
    points_.erase(points_.begin(), points_.begin() + static_cast<std::ptrdiff_t>(head_));
    head_ = 0;
  }
  const auto inside = std::find_if(links_.begin(), links_.end(), [&](const Link& l) { return l.end > until; });
  links_.erase(links_.begin(), inside);
  std::size_t older = 0;
  while (older < ends_.size() && ends_[older].t <= until) max_stamp_ = ends_[older++].sequence;
  ends_.erase(ends_.begin(), ends_.begin() + static_cast<std::ptrdiff_t>(older));
}

}  // namespace aslio::plugins
