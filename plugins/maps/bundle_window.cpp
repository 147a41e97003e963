#include "maps/bundle_window.hpp"

#include <algorithm>
#include <cmath>

#include "aslio/core/angles.hpp"

namespace aslio::plugins {

namespace {

/// Of the very first pose, about which the world turns [rad, m].
constexpr double kFirstSigma = 1e-5;
/// Least time between two keyframes in their increment [s].
constexpr double kLeastSeconds = 1e-3;

}  // namespace

BundleWindow::BundleWindow(const Params& params)
    : params_(params), bundle_({.max_iterations = static_cast<int>(params.iterations), .converged = 1e-6}) {}

void BundleWindow::clear() {
  keyframes_.clear();
  first_ = 0;
}

bool BundleWindow::ends(TimeNs t) const {
  if (keyframes_.empty()) return true;
  const TimeNs begin = keyframes_.back().begin;
  return t < begin || to_seconds(t - begin) >= params_.keyframe;
}

void BundleWindow::begin(TimeNs t, const Vec3& origin) {
  Keyframe next;
  next.begin = t;
  next.pose.p = origin;
  if (!keyframes_.empty()) {
    const Keyframe& before = keyframes_.back();
    next.increment = before.pose.inverse() * next.pose;
    next.seconds = std::max(to_seconds(t - before.begin), kLeastSeconds);
  }
  keyframes_.push_back(next);
}

/// eq. MAP-12: an increment drifts like a random walk.
Mat6 BundleWindow::information(double seconds) const {
  const double turn = params_.drift_deg * kRadPerDeg, shift = params_.drift;
  Vec6 out;
  out << Vec3::Constant(1.0 / (turn * turn * seconds)), Vec3::Constant(1.0 / (shift * shift * seconds));
  return out.asDiagonal();
}

/// How much the points of a keyframe count of what they would if they were certain to be of this plane: those of
/// something else in its voxel are thicker than a plane, or lie off it. eq. MAP-12
double BundleWindow::agreement(const BundleVoxels::Seen& seen, const PointMoments& points) const {
  const double thickness = params_.thickness * scale_;
  const double off = seen.normal.dot(points.mean() - seen.mean);
  const double across = seen.normal.dot(points.scatter() * seen.normal) / points.n;
  if (across > thickness * thickness || std::abs(off) > 3.0 * thickness) return 0;
  return 1.0 / (1.0 + off * off / (params_.kernel * params_.kernel));
}

/// `share`: how much a point of this grid counts.
void BundleWindow::add_plane(const BundleVoxels::Seen& seen, double share) {
  const Vec3 origin = keyframes_.front().pose.p;
  const double noise = params_.sigma * params_.sigma * scale_ * scale_,
               shared = params_.plane_sigma * params_.plane_sigma;
  clusters_.clear();
  for (const ClusterPool::Cluster* cluster : seen.clusters) {
    const double agrees = agreement(seen, cluster->points);
    if (agrees == 0) continue;
    const std::uint32_t i = cluster->keyframe - first_;
    const Pose to_body = keyframes_[i].pose.inverse() * Pose{Mat3::Identity(), seen.corner};
    const double weight = share * agrees / (noise + cluster->points.n * shared);
    clusters_.push_back({i, cluster->points.moved(to_body).weighted(weight)});
  }
  PointMoments settled;
  if (seen.settled->n > 0) {
    const double per_keyframe = seen.settled->n / seen.settled_keyframes;
    settled =
        seen.settled->moved({Mat3::Identity(), seen.corner - origin}).weighted(share / (noise + per_keyframe * shared));
  }
  bundle_.add_plane(settled, clusters_);
}

/// The planes that tell two of the window from each other, or one from what has settled.
void BundleWindow::add_planes(const Staggered<BundleVoxels>& grids) {
  const auto tells = [](const BundleVoxels::Seen& seen) { return seen.clusters.size() > 1 || seen.settled->n > 0; };
  std::size_t count = 0, number = 0;
  for (const BundleVoxels& grid : grids)
    grid.each_plane([&](const BundleVoxels::Seen& seen) { count += tells(seen) ? 1 : 0; });
  const auto limit = static_cast<std::size_t>(params_.max_planes);
  const std::size_t step = (count + limit - 1) / limit;
  for (const BundleVoxels& grid : grids) {
    grid.each_plane([&](const BundleVoxels::Seen& seen) {
      if (tells(seen) && number++ % step == 0) add_plane(seen, 1.0 / static_cast<double>(grids.count()));
    });
  }
}

void BundleWindow::load(const Staggered<BundleVoxels>& grids) {
  const Vec3 origin = keyframes_.front().pose.p;
  const auto local = [&](const Pose& pose) { return Pose{pose.R, pose.p - origin}; };
  bundle_.clear();
  for (const Keyframe& keyframe : keyframes_) {
    const std::uint32_t number = bundle_.add_pose(local(keyframe.pose));
    if (keyframe.seconds == 0) {
      bundle_.add_prior(number, local(keyframe.pose), Mat6::Identity() / (kFirstSigma * kFirstSigma));
    } else if (number == 0) {
      bundle_.add_prior(0, local(settled_ * keyframe.increment), information(keyframe.seconds));
    } else {
      bundle_.add_increment(number - 1, number, keyframe.increment, information(keyframe.seconds));
    }
  }
  add_planes(grids);
}

void BundleWindow::adjust(Staggered<BundleVoxels>& grids, std::uint32_t stamp) {
  if (params_.iterations == 0 || keyframes_.size() < 2) return;
  load(grids);
  if (bundle_.solve().steps == 0) return;
  const Vec3 origin = keyframes_.front().pose.p;
  moves_.clear();
  for (std::size_t i = 0; i < keyframes_.size(); ++i) {
    Pose now = bundle_.poses()[i];
    now.p += origin;
    moves_.push_back(now * keyframes_[i].pose.inverse());
    keyframes_[i].pose = now;
  }
  for (BundleVoxels& grid : grids) grid.move(first_, moves_, stamp);
}

void BundleWindow::revise(Staggered<BundleVoxels>& grids, std::uint32_t stamp) {
  if (keyframes_.empty()) return;
  adjust(grids, stamp);
  const auto most = static_cast<std::size_t>(std::max(1.0, std::round(params_.lag / params_.keyframe)));
  while (keyframes_.size() > most) {
    settled_ = keyframes_.front().pose;
    keyframes_.pop_front();
    ++first_;
  }
  for (BundleVoxels& grid : grids) grid.settle(first_, stamp);
}

}  // namespace aslio::plugins
