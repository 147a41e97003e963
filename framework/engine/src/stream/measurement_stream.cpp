#include "aslio/stream/measurement_stream.hpp"

#include <algorithm>

namespace aslio::stream {
namespace {

constexpr TimeNs kGapPeriods = 5;

ImuSample interpolated(const ImuSample& a, const ImuSample& b, TimeNs t) {
  const double u = static_cast<double>(t - a.t) / static_cast<double>(b.t - a.t);
  return {t, a.gyro + u * (b.gyro - a.gyro), a.acc + u * (b.acc - a.acc),
          static_cast<std::uint8_t>(a.faults | b.faults)};
}

/// Written so that a NaN fails.
bool possible(const ImuSample& s) {
  return s.gyro.cwiseAbs().maxCoeff() < kMaxRate && s.acc.cwiseAbs().maxCoeff() < kMaxForce && s.gyro.allFinite() &&
         s.acc.allFinite() && sane_stamp(s.t);
}

}  // namespace

void MeasurementStream::push(LidarPacket&& packet) {
  ++counters_.packets;
  counters_.points_invalid += packet.dropped_invalid;
  counters_.points_beyond_lines += packet.beyond_lines;
  std::vector<TimedPoint>& points = packet.points;
  const std::size_t size = points.size();
  const PacketFindings findings =
      sorter_.sort(points, packets_.newest() == kTimeMin ? kTimeMin : packets_.newest() - clock_shift_);
  counters_.points_invalid += findings.invalid;
  counters_.points_stray += findings.stray;
  if (points.empty()) {
    ++counters_.empty_packets;
    return;
  }
  if (clock_shift_ != 0) {
    packet.stamp += clock_shift_;
    for (TimedPoint& p : points) p.t += clock_shift_;
  }
  const PacketKey key{packet.stamp, points.front().t, points.back().t, size};
  admit(packets_, samples_, ArrivedPacket{std::move(packet), key, findings.reordered});
}

void MeasurementStream::take(ArrivedPacket&& arrived) {
  std::vector<TimedPoint>& points = arrived.packet.points;
  recent_packets_[recent_count_++ % kRecentPackets] = arrived.key;
  const auto closed = [](TimeNs limit, const TimedPoint& p) { return limit < p.t; };
  const auto open = std::upper_bound(points.begin(), points.end(), closed_until(), closed);
  const auto late = static_cast<std::size_t>(open - points.begin());
  const auto skipped = static_cast<std::size_t>(std::upper_bound(points.begin(), open, skipped_until_, closed) -
                                                std::upper_bound(points.begin(), open, skipped_from_, closed));
  counters_.points_before_start += skipped;
  counters_.points_late += late - skipped;
  counters_.points_reordered += arrived.reordered - std::min(arrived.reordered, late);
  const std::span<TimedPoint> accepted(open, points.end());
  // Late points count too: what comes after them must not depend on whether its packet came before or after the cut.
  next_index_ += static_cast<std::uint32_t>(late);
  if (accepted.empty()) return;
  for (TimedPoint& p : accepted) p.index = next_index_++;
  counters_.points += accepted.size();
  note_sweeps(accepted);
  points_.merge(accepted);
  const auto later = std::upper_bound(accepted.begin(), accepted.end(), packets_.newest(), closed);
  if (packets_.newest() != kTimeMin && later != accepted.end())
    counters_.longest_point_step = std::max(counters_.longest_point_step, later->t - packets_.newest());
  first_point_ = std::min(first_point_.value_or(kTimeMax), accepted.front().t);
  packets_.note_taken(accepted.back().t);
}

bool MeasurementStream::seen_before(const PacketKey& key) const {
  const auto end = recent_packets_.begin() + static_cast<std::ptrdiff_t>(std::min(recent_count_, kRecentPackets));
  return std::find(recent_packets_.begin(), end, key) != end;
}

void MeasurementStream::note_sweeps(std::span<const TimedPoint> points) {
  for (std::size_t i = 0; i < points.size();) {
    const std::uint32_t id = points[i].sweep_id;
    while (i < points.size() && points[i].sweep_id == id) ++i;
    const auto known = std::find_if(sweeps_.rbegin(), sweeps_.rend(), [id](const Sweep& s) { return s.id == id; });
    if (known == sweeps_.rend())
      sweeps_.push_back({id, points[i - 1].t});
    else
      known->end = std::max(known->end, points[i - 1].t);
  }
}

void MeasurementStream::push(const ImuSample& sample) {
  if (imu_left_out_) return;
  if (!possible(sample)) {
    ++counters_.imu_invalid;
    return;
  }
  ArrivedSample arrived{sample};
  arrived.t += clock_shift_;
  admit(samples_, packets_, std::move(arrived));
}

/// Copies and samples that come too late are none that the screen should see.
void MeasurementStream::screen(const ImuSample& sample) {
  const std::size_t until = imu_.count_until(sample.t);
  const bool copy = screen_.holds(sample.t) || (until > 0 && imu_.all()[until - 1].t == sample.t);
  if (copy || sample.t <= closed_until()) return take(sample);
  take(screen_.push(sample));
}

void MeasurementStream::take(std::span<const ImuSample> judged) {
  for (const ImuSample& sample : judged) take(sample);
  counters_.imu_found = screen_.findings();
}

void MeasurementStream::take(const ImuSample& sample) {
  const std::size_t until = imu_.count_until(sample.t);
  if (screen_.holds(sample.t) || (until > 0 && imu_.all()[until - 1].t == sample.t)) {
    ++counters_.imu_duplicate;
    return;
  }
  if (sample.t <= closed_until()) {
    ++counters_.imu_late;
    return;
  }
  if (first_imu_ && sample.t < samples_.newest()) {
    ++counters_.imu_reordered;
  } else if (first_imu_) {
    const TimeNs step = sample.t - samples_.newest();
    counters_.imu_gaps += imu_period() > 0 && step > kGapPeriods * imu_period();
    counters_.longest_imu_step = std::max(counters_.longest_imu_step, step);
    imu_steps_.add(step);
  }
  ++counters_.imu;
  imu_.merge({&sample, 1});
  first_imu_ = std::min(first_imu_.value_or(kTimeMax), sample.t);
  samples_.note_taken(sample.t);
}

void MeasurementStream::finish() {
  // What no other one of its sensor can confirm any more, the other sensor may. A pause that nothing confirms is a wild
  // stamp.
  for (ArrivedPacket& held : packets_.held_before(samples_.newest())) accept(std::move(held));
  for (ArrivedSample& held : samples_.held_before(packets_.newest())) accept(std::move(held));
  counters_.packet_time_jumps += packets_.drop_held();
  counters_.imu_time_jumps += samples_.drop_held();
  take(screen_.finish());
  finished_ = true;
}

ImuSample MeasurementStream::imu_at(std::size_t after, TimeNs t) const {
  const std::span<const ImuSample> samples = imu_.all();
  if (after > 0 && samples[after - 1].t == t) return samples[after - 1];
  if (after > 0 && after < samples.size()) return interpolated(samples[after - 1], samples[after], t);
  ImuSample nearest = samples[after == 0 ? 0 : after - 1];
  nearest.t = t;
  return nearest;
}

void MeasurementStream::imu_covering(TimeNs begin, TimeNs end, std::vector<ImuSample>& out) const {
  out.clear();
  if (imu_.empty()) return;
  const std::span<const ImuSample> samples = imu_.all();
  const std::size_t from = imu_.count_until(begin), to = imu_.count_until(end);
  out.push_back(imu_at(from, begin));
  for (std::size_t i = from; i < to && samples[i].t < end; ++i) out.push_back(samples[i]);
  out.push_back(imu_at(to, end));
  if (force_scale_ == 1.0) return;
  for (ImuSample& sample : out) sample.acc *= force_scale_;
}

std::optional<TimeNs> MeasurementStream::imu_silent_after(TimeNs begin, TimeNs end, TimeNs longest) const {
  const std::span<const ImuSample> samples = imu_.all();
  const std::size_t until_begin = imu_.count_until(begin);
  for (std::size_t i = until_begin > 0 ? until_begin - 1 : 0; i < samples.size() && samples[i].t < end; ++i) {
    const TimeNs next = i + 1 < samples.size() ? samples[i + 1].t : std::max(packets_.newest(), samples[i].t);
    if (next - samples[i].t > longest) return samples[i].t;
  }
  return std::nullopt;
}

TimeNs MeasurementStream::longest_imu_step(TimeNs begin, TimeNs end) const {
  const std::span<const ImuSample> samples = imu_.all();
  TimeNs longest = 0, last = begin;
  const std::size_t until_begin = imu_.count_until(begin);
  for (std::size_t i = until_begin > 0 ? until_begin - 1 : 0; i < samples.size() && last < end; ++i) {
    if (i >= until_begin) longest = std::max(longest, samples[i].t - last);
    last = samples[i].t;
  }
  return std::max(longest, end - last);
}

void MeasurementStream::learn_cut_steps(TimeNs end) {
  const std::span<const ImuSample> samples = imu_.all();
  const std::size_t until = imu_.count_until(end);
  for (std::size_t i = last_cut_step_ ? imu_.count_until(*last_cut_step_) : 0; i < until; ++i) {
    if (last_cut_step_) cut_steps_.add(samples[i].t - *last_cut_step_);
    last_cut_step_ = samples[i].t;
  }
}

Window MeasurementStream::cut(const WindowPlan& plan, std::uint32_t sequence) {
  Window window;
  window.plan = plan;
  window.sequence = sequence;
  window.fresh = points(plan.fresh_begin, plan.end);
  imu_covering(plan.fresh_begin, plan.end, window_imu_);
  window.imu = window_imu_;
  const std::size_t until = imu_.count_until(plan.end);
  window.imu_read_at_end = until > 0 && imu_.all()[until - 1].t == plan.end;
  const TimeNs step = longest_imu_step(plan.fresh_begin, plan.end);
  learn_cut_steps(plan.end);
  const TimeNs usual = cut_steps_.median();
  window.imu_gap = usual > 0 && step > kGapPeriods * usual ? step : 0;
  last_cut_ = std::max(last_cut_, plan.end);
  return window;
}

void MeasurementStream::release(TimeNs t) {
  if (t <= released_) return;
  released_ = t;
  if (t > last_cut_) {
    skipped_from_ = last_cut_;
    skipped_until_ = t;
  }
  points_.forget(points_.count_until(t));
  // The sample at or before t stays: the next window interpolates from it.
  const std::size_t until = imu_.count_until(t);
  if (until > 1) imu_.forget(until - 1);
  forget_sweeps(t);
}

void MeasurementStream::forget_points(TimeNs t) {
  points_.forget(points_.count_until(t));
  forget_sweeps(t);
}

void MeasurementStream::forget_sweeps(TimeNs t) {
  // The newest sweep stays: it is not over until a later one begins.
  const auto over = [t](const Sweep& s) { return s.end > t; };
  if (!sweeps_.empty()) sweeps_.erase(sweeps_.begin(), std::find_if(sweeps_.begin(), sweeps_.end() - 1, over));
}

TimeNs MeasurementStream::points_until() const {
  if (finished_) return kTimeMax;
  return packets_.newest() == kTimeMin ? kTimeMin : packets_.newest() - 1;
}

TimeNs MeasurementStream::imu_until() const {
  if (finished_ || imu_left_out_) return kTimeMax;
  const bool impatient = imu_patience_ != kTimeMax && packets_.newest() != kTimeMin;
  return impatient ? std::max(samples_.newest(), packets_.newest() - imu_patience_) : samples_.newest();
}
TimeNs MeasurementStream::last_point() const { return packets_.newest(); }
TimeNs MeasurementStream::last_imu() const { return samples_.newest(); }

std::span<const TimedPoint> MeasurementStream::points(TimeNs begin, TimeNs end) const {
  return points_.range(begin, end);
}

std::span<const ImuSample> MeasurementStream::imu(TimeNs begin, TimeNs end) const { return imu_.range(begin, end); }

std::optional<TimeNs> MeasurementStream::sweep_end_after(TimeNs t) const {
  std::optional<TimeNs> first;
  const std::size_t complete = sweeps_.empty() || finished_ ? sweeps_.size() : sweeps_.size() - 1;
  for (const Sweep& sweep : std::span(sweeps_).first(complete))
    if (sweep.end > t && (!first || sweep.end < *first)) first = sweep.end;
  return first;
}

}  // namespace aslio::stream
