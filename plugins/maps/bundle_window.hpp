#pragma once
/// The keyframes of `bundle_planes` whose poses may still move.

#include <cstdint>
#include <deque>
#include <vector>

#include "aslio/core/time.hpp"
#include "maps/bundle_voxels.hpp"
#include "maps/plane_bundle.hpp"

namespace aslio::plugins {

/// A sliding window of keyframes (docs/equations.md MAP-12). A keyframe is the points of a short time, which move
/// together. Its frame has the axes of W and its origin where the sensor was. When one ends, all of the window are
/// adjusted to the planes that they see, to the increments between them, and to what has settled.
class BundleWindow {
 public:
  struct Params {
    double keyframe = 0.2;           ///< [s]
    double lag = 3.0;                ///< [s]
    std::int64_t iterations = 2;     ///< 0: nothing moves
    double sigma = 0.02;             ///< of a point [m]
    double plane_sigma = 0.006;      ///< of a plane as one keyframe sees it [m]
    double kernel = 0.02;            ///< how far a keyframe's points may lie off a plane and count half [m]
    double thickness = 0.023;        ///< how thick they may be [m]
    double drift_deg = 0.01;         ///< of an increment [deg/sqrt(s)]
    double drift = 0.001;            ///< the same [m/sqrt(s)]
    std::int64_t max_planes = 3000;  ///< planes of one adjustment
  };

  explicit BundleWindow(const Params& params);

  /// Whether points of time t belong to no keyframe yet: the newest has ended, or time has gone back.
  bool ends(TimeNs t) const;
  /// A keyframe from t on, seen from `origin` (W).
  void begin(TimeNs t, const Vec3& origin);
  /// Adjusts the poses of all keyframes, moves their points, and settles those that are older than the lag.
  void revise(Staggered<BundleVoxels>& grids, std::uint32_t stamp);
  std::uint32_t newest() const { return first_ + static_cast<std::uint32_t>(keyframes_.size()) - 1; }
  bool empty() const { return keyframes_.empty(); }
  void set_noise_scale(double scale) { scale_ = scale; }
  void clear();

 private:
  struct Keyframe {
    TimeNs begin = 0;
    Pose pose;           ///< T_W_B as adjusted
    Pose increment;      ///< from the keyframe before, as adjusted, to where this one came in
    double seconds = 0;  ///< between both; 0: this is the first
  };

  void load(const Staggered<BundleVoxels>& grids);
  void add_planes(const Staggered<BundleVoxels>& grids);
  void add_plane(const BundleVoxels::Seen& seen, double share);
  double agreement(const BundleVoxels::Seen& seen, const PointMoments& points) const;
  void adjust(Staggered<BundleVoxels>& grids, std::uint32_t stamp);
  Mat6 information(double seconds) const;

  Params params_;
  double scale_ = 1.0;
  std::deque<Keyframe> keyframes_;
  std::uint32_t first_ = 0;  ///< number of the oldest
  Pose settled_;             ///< of the keyframe before the oldest
  PlaneBundle bundle_;
  std::vector<Pose> moves_;
  std::vector<PlaneBundle::Cluster> clusters_;
};

}  // namespace aslio::plugins
