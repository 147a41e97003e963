#include "aslio/stream/imu_screen.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace aslio::stream {
namespace {

constexpr double kG = kStandardGravity;

/// A step from one sample to another, or back, that a body may take at once, and per second between them. A heel strike
/// has 4 to 6 g over one or two samples, a turn that is thrown 200 rad/s^2.
constexpr double kGyroStep = 6.0, kGyroPerSecond = 100.0;       // [rad/s], [rad/s^2]
constexpr double kAccStep = 8.0 * kG, kAccPerSecond = 20 * kG;  // [m/s^2], [m/s^3]
/// Times the usual step of an axis: what shakes has larger ones.
constexpr double kTimesUsual = 4.0;
/// So much farther from its neighbours than they are from each other lies a spike.
constexpr double kTimesApart = 2.0;

/// Range: readings nearer to its end than this are at the end.
constexpr double kAtEnd = 0.99, kAtFoundEnd = 0.999, kBeyondEnd = 1.01;
/// What is repeated so often, at a reading that large, is an end of the range.
constexpr int kPlateau = 7;  // times: fewer happen by chance, at the peak of a turn that is read in coarse steps
constexpr double kExtremeGyro = 1.0, kExtremeAcc = 15.0;  // [rad/s], [m/s^2]
constexpr int kOthersVary = 3;
/// The jolts of steps are clipped for a few samples each. A largest reading after a step, or after the one before it,
/// that is as steep as this [rad/s, m/s^2 per second], and no less than this, is on the way to a peak beyond it.
constexpr double kSteepGyro = 100.0, kSteepAcc = 600.0, kLeastSteepGyro = 0.1, kLeastSteepAcc = 0.5;
/// Exactly the same largest reading so many times, and so many times as often as readings just below it, is an end:
/// peaks that are read in coarse steps meet their largest reading again, too, and more often what is below it.
constexpr int kSteepHits = 4, kPileUp = 3;
constexpr double kJustBelow = 0.97;
/// What all axes of a sensor repeat for so long is stuck.
constexpr TimeNs kStuck = kSecond / 5;
constexpr int kStuckRepeats = 5;
/// Steps that must have changed before a repetition means anything [%].
constexpr std::ptrdiff_t kAxisVaries = 75, kSensorVaries = 90;

double reading(const ImuSample& s, int axis) { return axis < 3 ? s.gyro[axis] : s.acc[axis - 3]; }

double allowed_step(int axis, double dt) {
  return axis < 3 ? kGyroStep + kGyroPerSecond * dt : kAccStep + kAccPerSecond * dt;
}

std::uint8_t dead(int sensor) { return sensor == 0 ? imu_fault::gyro_dead : imu_fault::acc_dead; }

const Vec3& of_sensor(const ImuSample& s, int sensor) { return sensor == 0 ? s.gyro : s.acc; }

bool holds_time(std::span<const ImuSample> held, TimeNs t) {
  return std::any_of(held.begin(), held.end(), [t](const ImuSample& s) { return s.t == t; });
}

}  // namespace

bool ImuSpikes::holds(TimeNs t) const { return holds_time(held_, t); }

void ImuSpikes::forget() {
  last_.reset();
  held_.clear();
  step_count_ = 0;
}

/// The fourth largest of the last steps of an axis: what three samples do is not usual.
double ImuSpikes::usual_step(int axis) const {
  const std::size_t n = std::min(step_count_, kRecent);
  constexpr std::ptrdiff_t kRank = 3;
  if (n <= static_cast<std::size_t>(kRank)) return 0;
  std::array<double, kRecent> steps{};
  for (std::size_t i = 0; i < n; ++i) steps[i] = steps_[i][static_cast<std::size_t>(axis)];
  std::nth_element(steps.begin(), steps.begin() + kRank, steps.begin() + static_cast<std::ptrdiff_t>(n),
                   std::greater<>());
  return steps[static_cast<std::size_t>(kRank)];
}

bool ImuSpikes::far(const ImuSample& from, const ImuSample& to) const {
  const double dt = to_seconds(std::abs(to.t - from.t));
  for (int axis = 0; axis < 6; ++axis) {
    const double step = std::abs(reading(to, axis) - reading(from, axis));
    if (step > allowed_step(axis, dt) && step > kTimesUsual * usual_step(axis)) return true;
  }
  return false;
}

/// Of those that are held, between the last that passed and `after`: every one of them is far from the line between.
bool ImuSpikes::are_spikes(const ImuSample& after) const {
  const double whole = static_cast<double>(after.t - last_->t);
  return std::all_of(held_.begin(), held_.end(), [&](const ImuSample& s) {
    const double share = static_cast<double>(s.t - last_->t) / whole;
    const double dt = to_seconds(std::min(s.t - last_->t, after.t - s.t));
    for (int axis = 0; axis < 6; ++axis) {
      const double a = reading(*last_, axis), b = reading(after, axis);
      const double off = std::abs(reading(s, axis) - (a + share * (b - a)));
      if (off > allowed_step(axis, dt) && off > kTimesApart * std::abs(b - a) && off > kTimesUsual * usual_step(axis))
        return true;
    }
    return false;
  });
}

void ImuSpikes::accept(const ImuSample& sample, std::vector<ImuSample>& out) {
  if (!last_ || sample.t > last_->t) {
    if (last_) {
      std::array<double, 6>& step = steps_[step_count_++ % kRecent];
      for (int axis = 0; axis < 6; ++axis)
        step[static_cast<std::size_t>(axis)] = std::abs(reading(sample, axis) - reading(*last_, axis));
    }
    last_ = sample;
  }
  out.push_back(sample);
}

void ImuSpikes::accept_held(std::vector<ImuSample>& out) {
  for (const ImuSample& held : held_) accept(held, out);
  held_.clear();
}

void ImuSpikes::refuse() {
  refused_ += held_.size();
  held_.clear();
}

void ImuSpikes::push(const ImuSample& sample, std::vector<ImuSample>& out) {
  if (!last_) return accept(sample, out);
  if (sample.t <= (held_.empty() ? last_->t : held_.back().t)) {  // between others, which are not kept
    out.push_back(sample);
    return;
  }
  if (far(*last_, sample)) {
    held_.push_back(sample);
    const bool too_long = held_.size() > 1 && sample.t - last_->t > kLongest;
    if (held_.size() > kMaxInARow || too_long) accept_held(out);
    return;
  }
  if (!held_.empty() && are_spikes(sample)) refuse();
  accept_held(out);
  accept(sample, out);
}

void ImuRepeats::Run::take(bool same, TimeNs t) {
  if (!same) {
    since = t;
    repeats = 0;
  } else {
    ++repeats;
  }
}

bool ImuRepeats::holds(TimeNs t) const { return holds_time(held_, t); }

void ImuRepeats::forget() {
  last_.reset();
  held_.clear();
  axis_run_ = {};
  stuck_run_ = {};
  peak_ = {};
}

/// Of what a sensor reads, as declared or as found; 0: not known.
double ImuRepeats::limit(int sensor) const {
  const double declared = sensor == 0 ? declared_.gyro : declared_.acc;
  return declared > 0 ? kAtEnd * declared : kAtFoundEnd * limit_[static_cast<std::size_t>(sensor)];
}

/// A sensor that reads more than the end that was found had no end there.
void ImuRepeats::note_extremes(const ImuSample& sample) {
  for (int sensor = 0; sensor < 2; ++sensor) {
    const auto k = static_cast<std::size_t>(sensor);
    const double largest = of_sensor(sample, sensor).cwiseAbs().maxCoeff();
    if (limit_[k] > 0 && largest > kBeyondEnd * limit_[k]) {
      never_[k] = limit_[k];
      limit_[k] = 0;
    }
    largest_[k] = std::max(largest_[k], largest);
  }
}

/// Finds the end of a range at peaks that are too short to repeat it often.
void ImuRepeats::note_steep_ends(const ImuSample& sample) {
  const double dt = to_seconds(sample.t - last_->t);
  for (int axis = 0; axis < 6; ++axis) {
    const auto k = static_cast<std::size_t>(axis / 3);
    Peak& peak = peak_[static_cast<std::size_t>(axis)];
    if ((k == 0 ? declared_.gyro : declared_.acc) > 0 || limit_[k] > 0) {
      peak = {};
      continue;
    }
    const double size = std::abs(reading(sample, axis));
    const double step = std::abs(reading(sample, axis) - reading(*last_, axis));
    const double steep = std::max(k == 0 ? kLeastSteepGyro : kLeastSteepAcc, dt * (k == 0 ? kSteepGyro : kSteepAcc));
    const bool before = std::exchange(peak.steep, step >= steep);
    const bool extreme =
        size >= (k == 0 ? kExtremeGyro : kExtremeAcc) && size >= largest_[k] && size > kBeyondEnd * never_[k];
    peak.at_end = extreme && (before || peak.steep || (peak.at_end && step == 0));
    End& end = end_[k];
    if (peak.at_end && size != end.value) end = {size, 0, 0};
    end.hits += peak.at_end ? 1 : 0;
    end.below += size < end.value && size >= kJustBelow * end.value ? 1 : 0;
    if (peak.at_end && end.hits >= kSteepHits && end.hits >= kPileUp * end.below) limit_[k] = size;
  }
}

/// Whether an axis repeats an extreme reading while others vary.
bool ImuRepeats::is_plateau(int axis, const ImuSample& sample, std::span<const bool> changed) const {
  const auto k = static_cast<std::size_t>(axis / 3);
  if ((k == 0 ? declared_.gyro : declared_.acc) > 0 || limit_[k] > 0) return false;
  const double size = std::abs(reading(sample, axis));
  if (size < (k == 0 ? kExtremeGyro : kExtremeAcc) || size < largest_[k] || size <= kBeyondEnd * never_[k])
    return false;
  return std::count(changed.begin(), changed.end(), true) >= kOthersVary;
}

/// Whether an axis or a sensor has shown noise, in so many of the last steps: one that never does, in a simulation
/// without noise, repeats itself at rest, and one that is read in coarse steps does so often.
bool ImuRepeats::varies(std::size_t what, std::ptrdiff_t percent) const {
  const auto& changed = changed_[what];
  return changed_count_ >= kRecent &&
         std::count(changed.begin(), changed.end(), true) * 100 >= std::ssize(changed) * percent;
}

void ImuRepeats::mark_clipped(ImuSample& sample) const {
  for (int axis = 0; axis < 6; ++axis) {
    const double end = limit(axis / 3);
    if (end > 0 && std::abs(reading(sample, axis)) >= end) sample.faults |= imu_fault::clipped(axis >= 3, axis % 3);
  }
}

void ImuRepeats::count(const ImuSample& sample) {
  const bool gyro_dead = (sample.faults & imu_fault::gyro_dead) != 0,
             acc_dead = (sample.faults & imu_fault::acc_dead) != 0;
  const bool zero = sample.gyro.isZero(0.0) && sample.acc.isZero(0.0);
  findings_.zero += zero;
  findings_.stuck += !zero && (gyro_dead || acc_dead);
  findings_.gyro_clipped += (sample.faults & imu_fault::gyro_clipped) != 0;
  findings_.acc_clipped += (sample.faults & imu_fault::acc_clipped) != 0;
}

void ImuRepeats::release(std::vector<ImuSample>& out) {
  for (ImuSample& held : held_) {
    mark_clipped(held);
    count(held);
    out.push_back(held);
  }
  held_.clear();
}

/// Follows what single axes repeat; whether it is too soon to know what that means.
bool ImuRepeats::doubts_axes(const ImuSample& sample) {
  std::array<bool, 6> changed{};
  for (int axis = 0; axis < 6; ++axis)
    changed[static_cast<std::size_t>(axis)] = reading(sample, axis) != reading(*last_, axis);
  bool wait = false;
  for (int axis = 0; axis < 6; ++axis) {
    const auto at = static_cast<std::size_t>(axis);
    Run& run = axis_run_[at];
    const bool repeats =
        !changed[at] && is_plateau(axis, sample, changed) && (run.repeats > 0 || varies(at, kAxisVaries));
    run.take(repeats, sample.t);
    changed_[at][changed_count_ % kRecent] = changed[at];
    if (run.repeats >= kPlateau) {
      limit_[at / 3] = std::abs(reading(sample, axis));
      run.repeats = 0;
    }
    wait = wait || run.repeats > 0;
  }
  return wait;
}

/// Follows whether all axes of a sensor repeat their readings, and marks those once they have done so for long enough.
bool ImuRepeats::doubts_sensor(int sensor, const ImuSample& sample) {
  const auto k = static_cast<std::size_t>(sensor);
  const bool same = of_sensor(sample, sensor) == of_sensor(*last_, sensor);
  Run& run = stuck_run_[k];
  if (!same || run.repeats > 0 || varies(6 + k, kSensorVaries)) run.take(same, sample.t);
  changed_[6 + k][changed_count_ % kRecent] = !same;
  const bool stuck = run.repeats >= kStuckRepeats && sample.t - run.since >= kStuck;
  if (stuck) {
    for (ImuSample& held : held_)
      if (held.t > run.since) held.faults |= dead(sensor);
  }
  return run.repeats > 0 && !stuck;
}

void ImuRepeats::push(const ImuSample& sample, std::vector<ImuSample>& out) {
  const bool in_order = !last_ || sample.t > last_->t;
  if (in_order) held_.push_back(sample);
  ImuSample late = sample;  // what came out of order says nothing of what is repeated
  ImuSample& own = in_order ? held_.back() : late;
  if (sample.gyro.isZero(0.0) && sample.acc.isZero(0.0)) own.faults |= imu_fault::gyro_dead | imu_fault::acc_dead;
  if (!in_order) {
    mark_clipped(late);
    count(late);
    out.push_back(late);
    return;
  }
  note_extremes(sample);
  bool wait = false;
  if (last_ && own.faults == 0) {
    note_steep_ends(sample);
    wait = doubts_axes(sample);
    for (int sensor = 0; sensor < 2; ++sensor) wait = doubts_sensor(sensor, sample) || wait;
    ++changed_count_;
  } else {
    axis_run_ = {};
    peak_ = {};
    stuck_run_ = {Run{sample.t, 0}, Run{sample.t, 0}};
  }
  last_ = sample;
  if (!wait) release(out);
}

std::span<const ImuSample> ImuScreen::push(const ImuSample& sample) {
  passed_.clear();
  judged_.clear();
  spikes_.push(sample, passed_);
  for (const ImuSample& s : passed_) repeats_.push(s, judged_);
  return judged_;
}

std::span<const ImuSample> ImuScreen::finish() {
  judged_.clear();
  spikes_.finish();
  repeats_.finish(judged_);
  return judged_;
}

void ImuScreen::forget() {
  spikes_.forget();
  repeats_.forget();
}

ImuFindings ImuScreen::findings() const {
  ImuFindings findings = repeats_.findings();
  findings.spikes = spikes_.refused();
  return findings;
}

std::vector<std::string> ImuScreen::warnings() const {
  std::vector<std::string> out;
  const ImuRange found = repeats_.found();
  const auto warn = [&out](const char* sensor, double value, const char* unit, const char* key) {
    if (value > 0)
      out.push_back(
          fmt::format("the {} ends at {:.6g} {} again and again: that is taken for the end of its range; "
                      "declare it in the sensor file (`{}: {:.6g}`)",
                      sensor, value, unit, key, value));
  };
  warn("gyroscope", found.gyro, "rad/s", "gyro_range");
  warn("accelerometer", found.acc, "m/s^2", "acc_range");
  return out;
}

}  // namespace aslio::stream
