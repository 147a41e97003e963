#include "aslio/toolkit/deskewed_scan.hpp"

#include <Eigen/Geometry>
#include <algorithm>

#include "aslio/core/cpu_clock.hpp"

namespace aslio {

void DeskewedScan::reserve(std::size_t points) {
  if (points <= raw_.capacity()) return;
  points *= 2;  // windows vary with what is in view: one that is twice as full needs no memory
  raw_.reserve(points);
  index_.reserve(points);
  body_.reserve(points);
  features_.reserve(points);
  match_feature_.reserve(points);
  match_body_.reserve(points);
  match_range_.reserve(points);
  match_raw_.reserve(points);
  match_time_.reserve(points);
  for (auto& list : world_) list.reserve(points);
}

void DeskewedScan::load(std::span<const TimedPoint> fresh, const WindowTrajectory& trajectory, SamplerChain& samplers,
                        StageTimes& times) {
  {
    const CpuTimer timer(times.sample);
    sample_raw(fresh, samplers);
  }
  {
    const CpuTimer timer(times.deskew);
    deskew(trajectory);
  }
  const CpuTimer timer(times.sample);
  sample_body(samplers);
}

void DeskewedScan::sample_raw(std::span<const TimedPoint> fresh, SamplerChain& samplers) {
  if (uses_.capacity() < fresh.size()) uses_.reserve(2 * fresh.size());
  uses_.assign(fresh.size(), kAllUses);
  SampleBatch batch{fresh, {}, uses_};
  samplers.sample(Sampler::ActsOn::raw, batch);
  reserve(fresh.size() - static_cast<std::size_t>(std::count(uses_.begin(), uses_.end(), PointUses{0})));
  raw_.clear();
  index_.clear();
  features_.clear();
  moved_.clear();
  std::size_t kept = 0;
  for (std::size_t i = 0; i < fresh.size(); ++i) {
    if (uses_[i] == 0) continue;
    raw_.push_back(fresh[i]);
    features_.push_back(fresh[i].feature);
    index_.push_back(static_cast<std::uint32_t>(i));
    uses_[kept++] = uses_[i];
  }
  uses_.resize(kept);
}

namespace {

/// One segment seen from the end of the window: p(tau) = R (q + A(tau) w x q + B(tau) w x (w x q)) + p + v tau +
/// a tau^2/2, q = p_I turned alike by what the change of w adds.
struct EndSegment {
  const MotionSegment& segment;
  Mat3 R;
  Vec3 p, v, half_a, w, w_dot;
  double w2, w_dot2;

  EndSegment(const MotionSegment& s, const NavState& end)
      : segment(s),
        R(end.R.transpose() * s.R),
        p(end.R.transpose() * (s.p - end.p)),
        v(end.R.transpose() * s.v),
        half_a(0.5 * end.R.transpose() * s.a_W),
        w(s.w),
        w_dot(s.w_dot),
        w2(s.w.squaredNorm()),
        w_dot2(s.w_dot.squaredNorm()) {}

  PointLanes at_end(const PointLanes& p_I, const PointLanes::Lane& tau) const {
    PointLanes::Lane A{}, B{};
    PointLanes q = p_I;
    if (w_dot2 > 0) {
      PointLanes::Lane bend{};
      for (std::size_t l = 0; l < tau.size(); ++l) bend[l] = segment.bend(tau[l]);
      turn_factors(w_dot2, bend, A, B);
      q = p_I.turned(w_dot, A, B);
    }
    turn_factors(w2, tau, A, B);
    PointLanes out = q.turned(w, A, B).moved(R, p);
    for (std::size_t l = 0; l < tau.size(); ++l) {
      out.x[l] += tau[l] * (v.x() + tau[l] * half_a.x());
      out.y[l] += tau[l] * (v.y() + tau[l] * half_a.y());
      out.z[l] += tau[l] * (v.z() + tau[l] * half_a.z());
    }
    return out;
  }
};

/// Hands p_I at the end of the window of `count` points in time order to `out`; `raw_of` tells the i-th.
template <class RawOf, class Out>
void bring_to_end(const WindowTrajectory& trajectory, const Pose& T_imu_lidar, std::size_t count, const RawOf& raw_of,
                  const Out& out) {
  const auto segments = trajectory.segments();
  const NavState& end = trajectory.predicted_end();
  std::size_t i = 0;
  PointLanes measured;
  PointLanes::Lane tau{};
  for (std::size_t s = 0; s < segments.size(); ++s) {
    const EndSegment segment(segments[s], end);
    const TimeNs until = s + 1 < segments.size() ? segments[s + 1].t : kTimeMax;
    while (i < count && raw_of(i).t <= until) {
      std::size_t n = 0;
      for (; n < PointLanes::kWidth && i + n < count && raw_of(i + n).t <= until; ++n) {
        const TimedPoint& raw = raw_of(i + n);
        measured.set(n, Vec3(raw.x, raw.y, raw.z));
        tau[n] = to_seconds(raw.t - segments[s].t);
      }
      std::fill(tau.begin() + static_cast<std::ptrdiff_t>(n), tau.end(), tau[0]);
      const PointLanes placed = segment.at_end(measured.moved(T_imu_lidar.R, T_imu_lidar.p), tau);
      for (std::size_t l = 0; l < n; ++l) out(i + l, placed[l]);
      i += n;
    }
  }
  // No IMU at all: the points stay as measured.
  for (; i < count; ++i) out(i, T_imu_lidar * Vec3(raw_of(i).x, raw_of(i).y, raw_of(i).z));
}

}  // namespace

void DeskewedScan::deskew(const WindowTrajectory& trajectory) {
  body_.resize(raw_.size());
  bring_to_end(
      trajectory, T_imu_lidar_, raw_.size(), [&](std::size_t i) -> const TimedPoint& { return raw_[i]; },
      [&](std::size_t i, const Vec3& p) { body_[i] = p.cast<float>(); });
  for (std::size_t i = 0; i < moved_.size(); ++i) body_[i] += moved_[i];
}

void DeskewedScan::bring_to_imu() {
  body_.resize(raw_.size());
  for (std::size_t i = 0; i < raw_.size(); ++i) {
    body_[i] = (T_imu_lidar_ * Vec3(raw_[i].x, raw_[i].y, raw_[i].z)).cast<float>();
  }
}

void DeskewedScan::deskew_matches(const WindowTrajectory& trajectory) {
  bring_to_end(
      trajectory, T_imu_lidar_, match_raw_.size(),
      [&](std::size_t i) -> const TimedPoint& { return raw_[match_raw_[i]]; },
      [&](std::size_t i, const Vec3& p) {
        match_body_[i] = p;
        if (!moved_.empty()) match_body_[i] += moved_[match_raw_[i]].cast<double>();
      });
}

void DeskewedScan::sample_body(SamplerChain& samplers) {
  if (samplers.moves_points()) moved_ = body_;
  SampleBatch batch{raw_, body_, uses_, features_};
  samplers.sample(Sampler::ActsOn::body, batch);
  for (std::size_t i = 0; i < moved_.size(); ++i) moved_[i] = body_[i] - moved_[i];
  list_matches();
}

void DeskewedScan::take_as_measured() {
  bring_to_imu();
  list_matches();
}

void DeskewedScan::list_matches() {
  match_body_.clear();
  match_range_.clear();
  match_raw_.clear();
  match_time_.clear();
  match_feature_.clear();
  for (std::size_t i = 0; i < raw_.size(); ++i) {
    if ((uses_[i] & mask(PointUse::match)) == 0) continue;
    match_body_.push_back(body_[i].cast<double>());
    match_raw_.push_back(static_cast<std::uint32_t>(i));
    match_time_.push_back(raw_[i].t);
    match_feature_.push_back(features_[i]);
    match_range_.push_back(Eigen::Vector3f(raw_[i].x, raw_[i].y, raw_[i].z).norm());
  }
}

void DeskewedScan::begin_world() {
  for (auto& list : world_) list.clear();
  alike_ = std::all_of(uses_.begin(), uses_.end(), [](PointUses uses) {
    return ((uses & mask(PointUse::overlap)) != 0) == ((uses & mask(PointUse::map)) != 0);
  });
}

/// The i-th kept point, at p_W and seen from viewpoint_W, to the lists of its uses.
void DeskewedScan::list_world(std::size_t i, const Vec3& p_W, const Vec3& viewpoint_W) {
  if (uses_[i] == 0) return;
  const TimedPoint& p = raw_[i];
  const WorldPoint point{p_W,
                         p.t,
                         Eigen::Vector3f(p.x, p.y, p.z).norm(),
                         p.intensity,
                         index_[i],
                         p.line,
                         static_cast<std::uint8_t>(features_[i] & ~feature_class::clearest),
                         PackedDirection((p_W - viewpoint_W).cast<float>())};
  for (const PointUse use : {PointUse::overlap, PointUse::map, PointUse::match}) {
    if ((uses_[i] & mask(use)) == 0 || (alike_ && use == PointUse::overlap)) continue;
    world_[slot(use)].push_back(point);
  }
}

void DeskewedScan::place(const WindowTrajectory& trajectory) {
  const Pose& end = trajectory.corrected_end();
  const Vec3 seen_from = viewpoint(end);
  begin_world();
  trajectory.to_end(
      raw_.size(), [&](std::size_t i) -> Vec3 { return body_[i].cast<double>(); },
      [&](std::size_t i) { return raw_[i].t; },
      [&](std::size_t i, const Vec3& p_I) { list_world(i, end * p_I, seen_from); });
}

void DeskewedScan::place_along(const TrajectoryModel& trajectory) {
  begin_world();
  for (std::size_t i = 0; i < raw_.size(); ++i) {
    if (uses_[i] == 0) continue;
    const Pose T = trajectory.pose(raw_[i].t);
    list_world(i, T * body_[i].cast<double>(), viewpoint(T));
  }
}

}  // namespace aslio
