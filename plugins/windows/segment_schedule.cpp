#include "windows/segment_schedule.hpp"

#include <algorithm>
#include <cmath>

namespace aslio::plugins {

std::int64_t SegmentSchedule::wanted(double overlap) const {
  // 1e-9: so that an overlap of 0.8 with a step of 0.1 gives 3 and not, through rounding, 4.
  const double segments = std::ceil((1.0 - overlap) / seg_step_ - 1e-9) + 1.0;
  return static_cast<std::int64_t>(std::clamp(segments, static_cast<double>(n_min_), static_cast<double>(n_limit_)));
}

void SegmentSchedule::observe(std::optional<double> overlap, std::int64_t least) {
  echo_ = std::max<std::int64_t>(echo_ - 1, 0);
  const bool defined = overlap && std::isfinite(*overlap);
  least = std::clamp(least, n_min_, n_limit_);
  if (!defined && least <= n_) return;
  const std::int64_t asked = defined ? std::max(wanted(*overlap), least) : least;
  if (asked > n_) {
    arm(asked);
  } else if (echo_ == 0) {
    arm(recover_ == Recover::ramp ? std::max(asked, n_ - 1) : asked);
  }
}

bool SegmentSchedule::anticipate(std::optional<double> overlap) {
  if (!overlap || !std::isfinite(*overlap) || wanted(*overlap) <= n_) return false;
  arm(wanted(*overlap));
  return true;
}

void SegmentSchedule::limit(std::int64_t n) {
  n_limit_ = std::clamp(n, n_min_, n_max_);
  if (n_ <= n_limit_) return;
  n_ = n_limit_;
  echo_ = std::min(echo_, held());  // a limit is no new fall of the overlap: it prolongs no echo
}

void SegmentSchedule::restart() { arm(n_min_); }

void SegmentSchedule::arm(std::int64_t n) {
  n_ = n;
  echo_ = held();
}

std::int64_t SegmentSchedule::held() const { return holds_ && n_ > 2 ? n_ : 1; }

}  // namespace aslio::plugins
