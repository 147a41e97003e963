#include "aslio/evaluation/turns.hpp"

#include <algorithm>

namespace aslio::evaluation {

namespace {

constexpr int kParts = 5;  // of a window: the mean of a swing of 5 Hz over 0.1 s is right to 1 %

}  // namespace

GyroTurns::GyroTurns(std::span<const ImuSample> imu, TimeNs max_gap) {
  knots_.reserve(imu.size());
  for (const ImuSample& sample : imu) {
    if (!sample.gyro.allFinite()) continue;
    if (knots_.empty()) {
      knots_.push_back({sample.t, Mat3::Identity(), sample.gyro, 0});
      continue;
    }
    Knot& last = knots_.back();
    if (sample.t <= last.t) continue;
    const double dt = to_seconds(sample.t - last.t);
    last.rate = 0.5 * (last.rate + sample.gyro);
    const Mat3 R = orthonormalised(last.R * exp_so3(dt * last.rate));
    knots_.push_back({sample.t, R, sample.gyro, last.gaps + (sample.t - last.t > max_gap ? 1 : 0)});
  }
}

const GyroTurns::Knot* GyroTurns::knot_before(TimeNs t) const {
  if (knots_.size() < 2 || t < knots_.front().t || t > knots_.back().t) return nullptr;
  auto next = std::upper_bound(knots_.begin(), knots_.end(), t, [](TimeNs a, const Knot& k) { return a < k.t; });
  if (next == knots_.end()) --next;
  return &*(next - 1);
}

std::optional<Vec3> GyroTurns::turn(TimeNs begin, TimeNs end) const {
  const Knot *from = knot_before(begin), *to = knot_before(end);
  if (from == nullptr || to == nullptr || (std::max(from, to) + 1)->gaps != std::min(from, to)->gaps)
    return std::nullopt;
  const auto at = [](const Knot& k, TimeNs t) { return Mat3(k.R * exp_so3(to_seconds(t - k.t) * k.rate)); };
  return log_so3(at(*from, begin).transpose() * at(*to, end));
}

std::optional<Vec3> PathTurns::turn(TimeNs begin, TimeNs end) const {
  const auto from = path_.pose(begin, max_gap_), to = path_.pose(end, max_gap_);
  if (!from || !to) return std::nullopt;
  return log_so3(from->R.transpose() * to->R);
}

std::vector<TimeNs> window_offsets(TimeNs window) {
  if (window <= 0) return {0};
  std::vector<TimeNs> offsets;
  for (int i = 0; i < kParts; ++i) offsets.push_back((2 * i + 1 - kParts) * window / (2 * kParts));
  return offsets;
}

std::optional<Vec3> mean_turn(const TurnSource& source, TimeNs begin, TimeNs end, TimeNs window) {
  const std::vector<TimeNs> offsets = window_offsets(window);
  const auto between = source.turn(begin, end);
  if (!between || offsets.size() == 1) return between;
  // From the attitude at a moment to the mean of those around it.
  const auto to_mean = [&](TimeNs t) -> std::optional<Vec3> {
    Vec3 sum = Vec3::Zero();
    for (const TimeNs offset : offsets) {
      const auto turn = source.turn(t, t + offset);
      if (!turn) return std::nullopt;
      sum += *turn;
    }
    return Vec3(sum / static_cast<double>(offsets.size()));
  };
  const auto from = to_mean(begin), to = to_mean(end);
  if (!from || !to) return std::nullopt;
  return log_so3(exp_so3(-*from) * exp_so3(*between) * exp_so3(*to));
}

}  // namespace aslio::evaluation
