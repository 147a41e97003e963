#include "aslio/pipeline/view_check.hpp"

#include <algorithm>
#include <cmath>

#include "octahedral.hpp"

namespace aslio::pipeline {

namespace {

constexpr std::uint32_t kSeen = 2;   // points that a direction needs
constexpr float kOneSurface = 1.3F;  // farthest to nearest of one surface
constexpr float kLoose = 0.08F;      // share of a range within which two agree, and ..
constexpr float kLooseBy = 0.15F;    // .. so much more [m]
constexpr double kSeenAgain = 0.4;   // least share of the directions of the slot before that are seen again, and ..
constexpr double kOfUsual = 0.55;    // .. of the most that were seen again in a slot of the last second
constexpr float kPasserBy = 2.0F;    // [m] who walks by nearer than this is much of the view, and moves by himself
constexpr double kSkips = 1.1;       // surfaces of the slot before the last that are seen again, to those of the last

}  // namespace

ViewCheck::ViewCheck(const SensorModel& sensor)
    : sensor_(sensor), slot_(std::max(kSecond / 10, to_ns(sensor.sweep_period))), blind_(slot_ * 5 / 2) {
  n_slots_ = static_cast<std::size_t>(std::clamp<TimeNs>(kSecond / slot_, 1, static_cast<TimeNs>(n_again_.size())));
}

void ViewCheck::forget() {
  now_ = before_ = earlier_ = Slot{};
  n_again_.fill(0);
  last_placed_ = last_end_ = kTimeMin;
}

// eq. MON-6.
std::optional<Unexplained> ViewCheck::add(std::span<const TimedPoint> points, const TrajectoryModel& poses, TimeNs t,
                                          bool ends) {
  if (points.empty()) return std::nullopt;
  const TimeNs length = last_end_ > kTimeMin ? std::clamp<TimeNs>(t - last_end_, 1, slot_) : slot_;
  last_end_ = t;
  const double most = static_cast<double>(kMaxPoints) * static_cast<double>(length) / static_cast<double>(slot_);
  place(points, poses, 1 + static_cast<std::size_t>(static_cast<double>(points.size()) / std::max(most, 1.0)));
  if (!ends || now_.begin == kTimeMin) return std::nullopt;
  const auto unexplained = compare();
  earlier_ = before_;
  before_ = now_;
  now_ = Slot{};
  return unexplained;
}

void ViewCheck::place(std::span<const TimedPoint> points, const TrajectoryModel& poses, std::size_t stride) {
  TimeNs posed = kTimeMin;
  Pose T;
  for (std::size_t i = 0; i < points.size(); i += stride) {
    const TimedPoint& point = points[i];
    const Vec3 p(point.x, point.y, point.z);
    const double range = p.norm();
    if (!(range >= sensor_.min_range && range <= sensor_.max_range)) continue;
    if (last_placed_ > kTimeMin && point.t - last_placed_ > blind_) now_ = before_ = earlier_ = Slot{};
    last_placed_ = point.t;
    if (posed == kTimeMin || point.t - posed > kPose) {
      posed = point.t;
      T = poses.pose(point.t) * sensor_.T_imu_lidar;
    }
    if (now_.begin == kTimeMin) {
      now_.begin = point.t;
      now_.origin = T.p;
    }
    const Eigen::Vector3f q = (T * p - now_.origin).cast<float>();
    const float sum = q.cwiseAbs().sum(), distance = q.norm();
    if (!(sum > 0) || !std::isfinite(sum)) continue;
    Cell& cell = now_.cells[octahedral_cell(q, sum, kSide)];
    cell.nearest = cell.n == 0 ? distance : std::min(cell.nearest, distance);
    cell.farthest = std::max(cell.farthest, distance);
    cell.sum += q;
    ++cell.n;
  }
}

std::optional<Unexplained> ViewCheck::compare() {
  const Seen last = see_again(before_);
  n_again_[i_again_++ % n_slots_] = last.again;
  const Seen earlier = see_again(earlier_);
  const auto of_last = share_of(last), of_earlier = share_of(earlier);
  if (of_earlier && (!of_last || earlier.again > kSkips * last.again)) {
    return Unexplained{.share = *of_earlier, .skips = true};
  }
  return of_last ? std::optional(Unexplained{.share = *of_last}) : std::nullopt;
}

ViewCheck::Seen ViewCheck::see_again(const Slot& earlier) const {
  const Eigen::Vector3f shift = (earlier.origin - now_.origin).cast<float>();
  Seen seen;
  for (const Cell& was : earlier.cells) {
    if (was.n < kSeen) continue;
    ++seen.all;
    if (was.farthest > kOneSurface * was.nearest) continue;
    const Eigen::Vector3f q = was.sum / static_cast<float>(was.n) + shift;
    const float sum = q.cwiseAbs().sum(), distance = q.norm();
    if (!(distance > static_cast<float>(sensor_.min_range)) || !std::isfinite(sum)) continue;
    const Cell& is = now_.cells[octahedral_cell(q, sum, kSide)];
    if (is.n < kSeen) continue;
    ++seen.again;
    if (distance < kPasserBy || is.nearest < kPasserBy) continue;
    ++seen.counted;
    if (distance < (1.0F - kLoose) * is.nearest - kLooseBy || distance > (1.0F + kLoose) * is.farthest + kLooseBy) {
      ++seen.unexplained;
    }
  }
  return seen;
}

// Where little of the view is seen again, who walks by the lens is much of that. A wall that comes close takes the view
// away over several slots.
std::optional<double> ViewCheck::share_of(const Seen& seen) const {
  const int usual = *std::max_element(n_again_.begin(), n_again_.end());
  if (seen.counted < kMin || seen.again < kSeenAgain * seen.all || seen.again < kOfUsual * usual) return std::nullopt;
  return static_cast<double>(seen.unexplained) / seen.counted;
}

}  // namespace aslio::pipeline
