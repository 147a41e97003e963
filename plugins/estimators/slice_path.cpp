#include "estimators/slice_path.hpp"

#include <algorithm>
#include <cmath>

namespace aslio::plugins {

namespace {

/// sin(x)/x and (1 - cos x)/x^2 of an angle x given by its square.
struct TurnRatios {
  double sine, cosine;

  explicit TurnRatios(double x2) {
    if (x2 < 0.01) {  // series, exact to 1e-12
      sine = 1.0 - x2 / 6.0 * (1.0 - x2 / 20.0 * (1.0 - x2 / 42.0));
      cosine = 0.5 - x2 / 24.0 * (1.0 - x2 / 30.0 * (1.0 - x2 / 56.0));
    } else {
      const double x = std::sqrt(x2);
      sine = std::sin(x) / x;
      cosine = (1.0 - std::cos(x)) / x2;
    }
  }
};

Vec3 turned(const Vec3& p, const Vec3& by) {
  const TurnRatios ratio(by.squaredNorm());
  const Vec3 across = by.cross(p);
  return p + ratio.sine * across + ratio.cosine * by.cross(across);
}

}  // namespace

void SlicePath::clear(const NavState& begin, TimeNs end) {
  begin_ = predicted_ = end_ = begin;
  end_t_ = end;
  segments_.clear();
  turn_ = move_ = Vec3::Zero();
}

void SlicePath::append(const MotionSegment& segment, const NavState& after) {
  segments_.push_back(segment);
  predicted_ = end_ = after;
}

void SlicePath::meet(const NavState& end) {
  end_ = end;
  turn_ = predicted_.R * log_so3(predicted_.R.transpose() * end.R);
  move_ = end.p - predicted_.p;
}

SlicePath SlicePath::between(const Pose& begin, const Pose& end) const {
  SlicePath out = *this;
  const Mat3 turn = begin.R * begin_.R.transpose();
  const Vec3 by = begin.p - begin_.p;
  const auto carry = [&](auto& with) {
    with.R = turn * with.R;
    with.p += by;
  };
  for (MotionSegment& segment : out.segments_) carry(segment);
  carry(out.begin_);
  carry(out.predicted_);
  NavState met = end_;
  met.R = end.R;
  met.p = end.p;
  out.meet(met);
  return out;
}

double SlicePath::share(TimeNs t) const {
  if (t >= end_t_) return 1.0;
  return t <= begin_.t ? 0.0 : static_cast<double>(t - begin_.t) / static_cast<double>(end_t_ - begin_.t);
}

const MotionSegment* SlicePath::segment_of(TimeNs t) const {
  const auto later = std::upper_bound(segments_.begin(), segments_.end(), t,
                                      [](TimeNs at, const MotionSegment& segment) { return at < segment.t; });
  if (segments_.empty()) return nullptr;
  return later == segments_.begin() ? &segments_.front() : &*std::prev(later);
}

Pose SlicePath::pose(TimeNs t) const {
  if (t >= end_t_) return end_.pose();
  if (t <= begin_.t) return begin_.pose();
  const double a = share(t);
  const MotionSegment* segment = segment_of(t);
  const Pose carried = segment == nullptr ? begin_.pose() : segment->pose(t);
  return {exp_so3(a * turn_) * carried.R, carried.p + a * move_};
}

SlicePath::Slope SlicePath::slope(TimeNs t) const {
  const double a = share(t);
  const MotionSegment* segment = segment_of(t);
  const Mat3 carried = segment == nullptr ? begin_.R : segment->pose(std::clamp(t, begin_.t, end_t_)).R;
  const Vec3 missed = predicted_.R.transpose() * turn_, part = a * (carried.transpose() * turn_);
  const Mat3 so_far = carried.transpose() * begin_.R, rest = carried.transpose() * predicted_.R,
             whole = predicted_.R.transpose() * begin_.R, grown = a * right_jacobian_so3(part) * rest;
  return {a, exp_so3(-part) * so_far - grown * left_jacobian_inverse_so3(missed) * whole,
          grown * right_jacobian_inverse_so3(missed)};
}

void SlicePath::list_states(std::vector<NavState>& out) const {
  const Vec3 faster = end_.v - predicted_.v;
  for (std::size_t s = 1; s < segments_.size(); ++s) {
    NavState state = end_;
    state.t = segments_[s].t;
    const Pose here = pose(state.t);
    state.R = orthonormalised(here.R);
    state.p = here.p;
    state.v = segments_[s].v + share(state.t) * faster;
    out.push_back(state);
  }
  out.push_back(end_);
}

void SlicePath::place(std::span<const Vec3> body, std::span<const TimeNs> times, std::span<Vec3> world,
                      std::span<Vec3> lever, std::span<double> share_out) const {
  const MotionSegment still{begin_.t, 0.0, begin_.R, begin_.p, Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  std::size_t s = 0;
  for (std::size_t i = 0; i < body.size(); ++i) {
    while (s + 1 < segments_.size() && segments_[s + 1].t <= times[i]) ++s;
    const MotionSegment& segment = segments_.empty() ? still : segments_[s];
    const double tau = to_seconds(times[i] - segment.t), a = share(times[i]);
    const Vec3 bent = segment.w_dot.isZero(0) ? body[i] : turned(body[i], segment.bend(tau) * segment.w_dot);
    const Vec3 carried = segment.R * turned(bent, tau * segment.w);
    lever[i] = turned(carried, a * turn_);
    world[i] = lever[i] + segment.p + tau * (segment.v + 0.5 * tau * segment.a_W) + a * move_;
    share_out[i] = a;
  }
}

std::size_t SliceChain::slice_of(TimeNs t) const {
  std::size_t i = 0;
  while (i + 1 < paths_.size() && t > paths_[i]->end().t) ++i;
  return i;
}

Pose SliceChain::moved(TimeNs t, const Eigen::VectorXd& xi) const {
  const std::size_t i = slice_of(t);
  const auto at = static_cast<Eigen::Index>(6 * i);
  const SlicePath& path = *paths_[i];
  return path.between(path.begin().pose().moved(xi.segment<6>(at)), path.end().pose().moved(xi.segment<6>(at + 6)))
      .pose(t);
}

void SliceChain::jacobian(TimeNs t, Eigen::MatrixXd& out) const {
  const std::size_t i = slice_of(t);
  const SlicePath::Slope slope = paths_[i]->slope(t);
  out.resize(6, dof());
  out.setZero();
  const Eigen::Index at = 6 * static_cast<Eigen::Index>(i);
  out.block<3, 3>(0, at) = slope.of_begin;
  out.block<3, 3>(3, at + 3) = (1.0 - slope.share) * Mat3::Identity();
  out.block<3, 3>(0, at + 6) = slope.of_end;
  out.block<3, 3>(3, at + 9) = slope.share * Mat3::Identity();
}

SliceInformation& SliceInformation::operator+=(const SliceInformation& other) {
  A0 += other.A0;
  A1 += other.A1;
  A2 += other.A2;
  b0 += other.b0;
  b1 += other.b1;
  squared_sum += other.squared_sum;
  weighted_sum += other.weighted_sum;
  accepted += other.accepted;
  return *this;
}

void SliceInformation::tell(const Mat3& begin, const Mat3& end, SliceEquations& out) const {
  EndsMatrix into = EndsMatrix::Identity();
  into.block<3, 3>(0, 0) = begin;
  into.block<3, 3>(6, 6) = end;
  EndsMatrix A;
  A << A0 - 2.0 * A1 + A2, A1 - A2, A1 - A2, A2;
  EndsVector b;
  b << b0 - b1, b1;
  out.A = into.transpose() * A * into;
  out.b = into.transpose() * b;
  out.weighted_sum = weighted_sum;
}

}  // namespace aslio::plugins
