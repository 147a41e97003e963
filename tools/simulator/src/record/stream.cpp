#include "record/stream.hpp"

#include <algorithm>
#include <cmath>

#include "purposes.hpp"

namespace aslio::simulator {

namespace {

/// Beams of a sweep of that period.
io::SweepGrid sweep_grid(const Simulation& simulation, double period, int lines) {
  const ScanPattern& pattern = simulation.pattern();
  const TimeNs firing = pattern.firing_period();
  const bool even = pattern.message() == LidarMessage::point_cloud2 && to_ns(period) % firing == 0;
  return {period, std::min(lines, static_cast<int>(pattern.beams_per_firing())),
          even ? static_cast<int>(to_ns(period) / firing) : 0};
}

io::LayoutPlace place_of(const Simulation& simulation, const RecordLayout& layout) {
  return {layout.folder,
          layout.sequence,
          simulation.begin_time(),
          simulation.end_time(),
          sweep_grid(simulation, layout.sweep_period, layout.lines),
          simulation.claimed_sensor().T_imu_lidar};
}

}  // namespace

RecordingStream::RecordingStream(const Simulation& simulation, const Trajectory& truth, const RecordLayout& layout)
    : simulation_(simulation),
      truth_(truth),
      writer_(io::open_layout_writer(layout.layout, place_of(simulation, layout))),
      sweep_period_(to_ns(layout.sweep_period)),
      lines_(layout.lines),
      jitter_(simulation.options().seed, purpose::kStampJitter),
      imu_loss_(simulation.options().seed, purpose::kImuLoss) {
  constexpr double kLeastDrift = 0.05, kLeastJitter = 0.1;
  const ClockRealism& clock = simulation.realism().clock;
  RandomStream random(simulation.options().seed, purpose::kClock);
  const double drift = clock.drift * random.uniform(kLeastDrift, 1), sign = random.uniform() < 0.5 ? -1 : 1;
  imu_clock_rate_ = 1e-6 * sign * drift;
  jitter_us_ = std::hypot(simulation.scene().stress.stamp_jitter, clock.jitter * random.uniform(kLeastJitter, 1));
}

void RecordingStream::add(const LidarPacket& packet, std::size_t index) {
  // By index, so that the loss of one packet does not depend on how many came before.
  RandomStream loss(simulation_.options().seed, purpose::kPacketLoss, index);
  const bool lost = loss.uniform() < simulation_.scene().stress.packet_loss;
  const TimeNs packet_end = std::min(packet.stamp + Simulation::kPacketPeriod, simulation_.end_time());
  auto first = packet.points.begin();
  for (TimeNs begin = packet.stamp; begin < packet_end; begin += sweep_period_) {
    // A message arrives when its last pulse has come back.
    const TimeNs arrival = std::min(begin + sweep_period_, packet_end);
    const auto last = std::find_if(first, packet.points.end(), [&](const auto& point) { return point.t >= arrival; });
    add_imu_until(arrival);
    if (!lost) {
      LidarPacket sweep;
      sweep.stamp = begin;
      sweep.sweep_id = packet.sweep_id;
      sweep.points.assign(first, arrival == packet_end ? packet.points.end() : last);
      for (TimedPoint& point : sweep.points) point.line = static_cast<std::uint8_t>(point.line % lines_);
      writer_->add_sweep(sweep, arrival);
      ++lidar_count_;
    }
    first = last;
  }
}

void RecordingStream::add_imu_until(TimeNs arrival) {
  const StressParams& stress = simulation_.scene().stress;
  const std::vector<ImuSample>& samples = simulation_.imu().samples;
  for (; next_imu_ < samples.size() && samples[next_imu_].t <= arrival; ++next_imu_) {
    ImuSample sample = samples[next_imu_];
    const TimeNs received = sample.t;
    add_truth_until(received);
    const double jitter_us = jitter_us_ * jitter_.normal();
    const double drift_ns = imu_clock_rate_ * static_cast<double>(sample.t - simulation_.begin_time());
    TimeNs stamp = sample.t + static_cast<TimeNs>(std::llround(1e6 * stress.clock_offset + 1e3 * jitter_us + drift_ns));
    stamp = std::max(stamp, last_imu_stamp_ + 1);
    const bool lost = imu_loss_.uniform() < stress.imu_loss;
    if (lost) continue;
    last_imu_stamp_ = stamp;
    sample.t = stamp;
    writer_->add_imu(sample, received);
    ++imu_count_;
  }
  add_truth_until(arrival);
}

void RecordingStream::add_truth_until(TimeNs time) {
  const auto& poses = truth_.samples();
  for (; next_truth_ < poses.size() && poses[next_truth_].t <= time; ++next_truth_) {
    writer_->add_reference(poses[next_truth_]);
  }
}

void RecordingStream::close() {
  add_imu_until(simulation_.end_time() + kSecond);
  writer_->close();
}

}  // namespace aslio::simulator
