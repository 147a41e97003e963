#pragma once
/// A stream over sorted vectors, of which an adjustable part has arrived, and a loop that drives a window strategy.

#include <algorithm>
#include <functional>
#include <span>
#include <vector>

#include "aslio/stages/window.hpp"

namespace aslio::test {

inline constexpr TimeNs kMs = 1'000'000;

class FakeStream final : public StreamView {
 public:
  FakeStream(std::vector<TimedPoint> points, std::vector<ImuSample> imu)
      : points_(std::move(points)), imu_(std::move(imu)) {}

  void arrive_points(std::size_t count) { points_arrived_ = std::min(points_arrived_ + count, points_.size()); }
  void arrive_imu(std::size_t count) { imu_arrived_ = std::min(imu_arrived_ + count, imu_.size()); }
  void arrive_until(TimeNs t) {
    while (points_arrived_ < points_.size() && points_[points_arrived_].t <= t) ++points_arrived_;
    while (imu_arrived_ < imu_.size() && imu_[imu_arrived_].t <= t) ++imu_arrived_;
  }
  void finish() {
    points_arrived_ = points_.size();
    imu_arrived_ = imu_.size();
    finished_ = true;
  }
  const std::vector<TimedPoint>& all_points() const { return points_; }
  const std::vector<ImuSample>& all_imu() const { return imu_; }
  bool points_complete() const { return points_arrived_ == points_.size(); }
  bool imu_complete() const { return imu_arrived_ == imu_.size(); }

  // The last firing may not be complete, so the stream is certain only up to just before it.
  TimeNs points_until() const override {
    return finished_ ? kTimeMax : points_arrived_ == 0 ? kTimeMin : last_point() - 1;
  }
  TimeNs imu_until() const override { return finished_ ? kTimeMax : last_imu(); }
  TimeNs last_point() const override { return points_arrived_ == 0 ? kTimeMin : points_[points_arrived_ - 1].t; }
  TimeNs last_imu() const override { return imu_arrived_ == 0 ? kTimeMin : imu_[imu_arrived_ - 1].t; }
  std::span<const TimedPoint> points(TimeNs begin, TimeNs end) const override {
    return between(std::span(points_).first(points_arrived_), begin, end);
  }
  std::span<const ImuSample> imu(TimeNs begin, TimeNs end) const override {
    return between(std::span(imu_).first(imu_arrived_), begin, end);
  }
  std::optional<TimeNs> sweep_end_after(TimeNs t) const override {
    const auto seen = std::span(points_).first(points_arrived_);
    for (std::size_t i = 0; i < seen.size(); ++i) {
      const bool last_of_sweep = i + 1 == seen.size() ? finished_ : seen[i + 1].sweep_id != seen[i].sweep_id;
      if (last_of_sweep && seen[i].t > t) return seen[i].t;
    }
    return std::nullopt;
  }

 private:
  template <class T>
  static std::span<const T> between(std::span<const T> all, TimeNs begin, TimeNs end) {
    const auto after = [](TimeNs t, const T& item) { return t < item.t; };
    const auto first = std::upper_bound(all.begin(), all.end(), begin, after);
    return {first, std::upper_bound(first, all.end(), std::max(begin, end), after)};
  }

  std::vector<TimedPoint> points_;
  std::vector<ImuSample> imu_;
  std::size_t points_arrived_ = 0;
  std::size_t imu_arrived_ = 0;
  bool finished_ = false;
};

/// Points 10 m away at a constant rate in (begin, end], `per_firing` of them at a time.
inline void add_points(std::vector<TimedPoint>& points, TimeNs begin, TimeNs end, TimeNs period, int per_firing = 1,
                       TimeNs sweep = 100 * kMs) {
  for (TimeNs t = begin + period; t <= end; t += period) {
    for (int line = 0; line < per_firing; ++line) {
      TimedPoint p;
      p.x = 10;
      p.t = t;
      p.sweep_id = static_cast<std::uint32_t>((t - 1) / sweep);
      p.index = static_cast<std::uint32_t>(points.size());
      p.line = static_cast<std::uint8_t>(line);
      points.push_back(p);
    }
  }
}

inline std::vector<ImuSample> imu_samples(TimeNs begin, TimeNs end, TimeNs period = 5 * kMs) {
  std::vector<ImuSample> samples;
  for (TimeNs t = begin; t <= end; t += period) samples.push_back({.t = t});
  return samples;
}

/// A probe that says what a function of time says.
class FakeProbe final : public OverlapProbe {
 public:
  explicit FakeProbe(std::function<std::optional<double>(TimeNs)> overlap) : overlap_(std::move(overlap)) {}
  OverlapScore overlap(TimeNs t) override {
    asked.push_back(t);
    return {.value = overlap_(t)};
  }
  std::vector<TimeNs> asked;

 private:
  std::function<std::optional<double>(TimeNs)> overlap_;
};

inline FakeProbe blind_probe() {
  return FakeProbe([](TimeNs) { return std::optional<double>(); });
}

/// Plays the pipeline: asks for windows as data arrives and answers each with an overlap.
class WindowLoop {
 public:
  using Overlap = std::function<std::optional<double>(const WindowPlan&)>;

  WindowLoop(WindowStrategy& strategy, OverlapProbe& probe, TimeNs start, Overlap overlap)
      : strategy_(strategy), probe_(probe), overlap_(std::move(overlap)) {
    feedback_.t = start;
  }
  /// Takes every window the stream allows by now, at most `most`; returns how many.
  std::size_t run(const StreamView& stream, std::size_t most = 100'000) {
    std::size_t count = 0;
    while (count < most) {
      const auto plan = strategy_.next(stream, feedback_, probe_);
      if (!plan) break;
      ++count;
      plans.push_back(*plan);
      feedback_.t = plan->end;
      if (feedback_.first_insertion == kTimeMax) feedback_.first_insertion = plan->end;
      feedback_.overlap.value = overlap_(*plan);
    }
    return count;
  }
  /// Of the last window, to be changed between runs.
  Feedback& feedback() { return feedback_; }
  std::vector<WindowPlan> plans;

 private:
  WindowStrategy& strategy_;
  OverlapProbe& probe_;
  Overlap overlap_;
  Feedback feedback_;
};

}  // namespace aslio::test
