#include "aslio/stream/arrival.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "aslio/core/errors.hpp"

namespace aslio::stream {
namespace {

constexpr int kConfirmations = 3;

bool valid(const TimedPoint& p) {
  // Written so that a NaN fails.
  return std::abs(p.x) < kMaxCoordinate && std::abs(p.y) < kMaxCoordinate && std::abs(p.z) < kMaxCoordinate &&
         sane_stamp(p.t);
}

/// Drops points that a step of more than kMaxStepBack separates from the middle point. Pre: time order.
std::size_t drop_strays(std::vector<TimedPoint>& points) {
  if (points.empty() || points.back().t - points.front().t <= kMaxStepBack) return 0;
  const auto apart = [](const TimedPoint& a, const TimedPoint& b) { return b.t - a.t > kMaxStepBack; };
  const auto middle = points.begin() + static_cast<std::ptrdiff_t>(points.size() / 2);
  const auto end = std::adjacent_find(middle, points.end(), apart);
  auto begin = middle;
  while (begin != points.begin() && !apart(*(begin - 1), *begin)) --begin;
  const std::size_t before = points.size();
  if (end != points.end()) points.erase(end + 1, points.end());
  points.erase(points.begin(), begin);
  return before - points.size();
}

}  // namespace

bool JumpGuard::agrees_with_held(TimeNs begin, TimeNs end) const {
  return held_ > 0 && end >= held_end_ - kMaxStepBack && begin <= held_end_ + kMaxStepAhead;
}

bool JumpGuard::confirms(TimeNs begin, TimeNs end) {
  if (held_ + 1 < kConfirmations || !agrees_with_held(begin, end)) return false;
  held_ = 0;
  return true;
}

bool JumpGuard::implausible(TimeNs begin, TimeNs end, TimeNs last) const {
  const bool back = end < last - kMaxStepBack;
  const bool ahead = begin > last + kMaxStepAhead;
  return back || (ahead && !agrees_with_held(begin, end));
}

JumpGuard::Verdict JumpGuard::judge(TimeNs begin, TimeNs end, TimeNs last, bool sole) {
  if (!implausible(begin, end, last)) {
    in_a_row_ = 0;
    const bool usual = begin <= last + kMaxStepBack;
    const bool agrees = !usual && agrees_with_held(begin, end);
    held_ = usual ? 0 : agrees ? held_ + 1 : 1;
    held_end_ = agrees ? std::max(held_end_, end) : end;
    return usual ? Verdict::take : agrees ? Verdict::hold_too : Verdict::hold;
  }
  if (in_a_row_ > 0 && begin == rejected_) return Verdict::ignore;  // a copy says nothing new
  const bool continues = in_a_row_ > 0 && begin > rejected_ && begin - rejected_ <= kMaxStepBack;
  in_a_row_ = continues ? in_a_row_ + 1 : 1;
  rejected_ = begin;
  if (in_a_row_ == 1) first_rejected_ = begin;
  if (in_a_row_ == kConfirmations) third_rejected_ = begin;
  if (in_a_row_ < kConfirmations) return Verdict::ignore;
  if (!sole) return Verdict::jumped;
  in_a_row_ = 0;
  held_ = 0;
  return Verdict::begin;
}

void JumpGuard::fail(TimeNs last) const {
  const bool back = third_rejected_ < last;
  const double jump = to_seconds(back ? last - third_rejected_ : third_rejected_ - last);
  throw DataError(
      fmt::format("{} clock jumped {} by {:.1f} s at {}.{:09} s ({} stamps in a row agree); split the recording there",
                  what_, back ? "back" : "ahead", jump, last / kSecond, std::abs(last % kSecond), kConfirmations));
}

void JumpGuard::forget() {
  held_ = 0;
  in_a_row_ = 0;
}

void StepMedian::add(TimeNs step) {
  steps_[next_] = step;
  next_ = (next_ + 1) % steps_.size();
  count_ = std::min(count_ + 1, steps_.size());
  auto sorted = steps_;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(count_ / 2);
  std::nth_element(sorted.begin(), middle, sorted.begin() + static_cast<std::ptrdiff_t>(count_));
  median_ = *middle;
}

PacketFindings PacketSorter::sort(std::vector<TimedPoint>& points, TimeNs newest) {
  PacketFindings findings;
  TimeNs latest = newest;
  bool in_order = true;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const TimedPoint& p = points[i];
    if (!valid(p)) continue;
    in_order = in_order && (kept == 0 || p.t >= points[kept - 1].t);
    findings.reordered += p.t < latest;
    latest = std::max(latest, p.t);
    if (kept != i) points[kept] = p;
    ++kept;
  }
  findings.invalid = points.size() - kept;
  points.resize(kept);
  if (!in_order) sort_by_time(points);
  findings.stray = drop_strays(points);
  return findings;
}

void PacketSorter::sort_by_time(std::vector<TimedPoint>& points) {
  const auto earlier = [](const TimedPoint& a, const TimedPoint& b) { return a.t < b.t; };
  const auto [first, last] = std::minmax_element(points.begin(), points.end(), earlier);
  // Unsigned differences: defined for any two stamps, and at most 64 bits.
  const auto origin = static_cast<std::uint64_t>(first->t);
  const std::uint64_t span = static_cast<std::uint64_t>(last->t) - origin;
  keys_.resize(points.size());
  keys_scratch_.resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    keys_[i] = {static_cast<std::uint64_t>(points[i].t) - origin, static_cast<std::uint32_t>(i)};

  constexpr unsigned kBits = 11, kBuckets = 1U << kBits;
  for (unsigned shift = 0; shift < 64 && (span >> shift) > 0; shift += kBits) {
    std::array<std::uint32_t, kBuckets> start{};
    for (const Key& key : keys_) ++start[(key.t >> shift) % kBuckets];
    std::uint32_t sum = 0;
    for (std::uint32_t& s : start) {
      const std::uint32_t in_bucket = s;
      s = sum;
      sum += in_bucket;
    }
    for (const Key& key : keys_) keys_scratch_[start[(key.t >> shift) % kBuckets]++] = key;
    keys_.swap(keys_scratch_);
  }
  sorted_.resize(points.size());
  for (std::size_t i = 0; i < keys_.size(); ++i) sorted_[i] = points[keys_[i].position];
  points.swap(sorted_);
}

}  // namespace aslio::stream
