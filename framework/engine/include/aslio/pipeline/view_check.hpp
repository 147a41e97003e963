#pragma once
/// Whether what was seen a moment ago is where the run's own motion puts it now.

#include <array>
#include <optional>
#include <span>

#include "aslio/core/sensor.hpp"
#include "aslio/stages/estimator.hpp"

namespace aslio::pipeline {

/// Share of the surfaces of a slot before, beyond 2 m, that are nearer or farther now than the motion explains.
struct Unexplained {
  double share = 0;
  bool skips = false;  ///< against the slot before the last one
};

/// Places the points of a slot (a sweep, at least 0.1 s) by the poses of the run, sees the next slot from where the run
/// then is, and compares ranges by direction (docs/equations.md MON-6). A sensor that was moved, whose data were cut,
/// or whose velocity is wrong is not where its run says. It knows neither map nor filter. No allocation.
class ViewCheck {
 public:
  explicit ViewCheck(const SensorModel& sensor);

  /// Takes the raw points of a window that ends at `t`, placed by `poses`. `ends`: a slot ends with it
  /// (ViewChange::ended(), so that both see the same slots); then it is compared with the slot before. Surfaces within
  /// 2 m of where this slot starts, as they were or are, do not count: there a person is much of the view. Two slots
  /// say nothing of each other after a time without points, where fewer than kMin surfaces count, or less is seen again
  /// than a share of those of the earlier slot or of a slot of the last second. The slot before the last is taken where
  /// the last says nothing, and where more of that one is seen again: then the view changed within the last.
  std::optional<Unexplained> add(std::span<const TimedPoint> points, const TrajectoryModel& poses, TimeNs t, bool ends);
  /// What was seen is no longer before what comes.
  void forget();

 private:
  static constexpr int kSide = 64;                 ///< cells of the octahedral map per axis: 3 deg
  static constexpr std::size_t kMaxPoints = 6000;  ///< of a slot
  static constexpr TimeNs kPose = kSecond / 200;   ///< points of so long share a pose
  static constexpr int kMin = 20;
  /// A direction from the origin of its slot.
  struct Cell {
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();  ///< of points from the origin [m]
    float nearest = 0, farthest = 0;                ///< [m]
    std::uint32_t n = 0;
  };
  struct Slot {
    std::array<Cell, kSide * kSide> cells{};
    Vec3 origin = Vec3::Zero();  ///< of the LiDAR, at its first point, in W [m]
    TimeNs begin = kTimeMin;
  };
  void place(std::span<const TimedPoint> points, const TrajectoryModel& poses, std::size_t stride);
  std::optional<Unexplained> compare();
  /// Surfaces of `earlier` that are seen in the slot of now.
  struct Seen {
    int all = 0, again = 0, counted = 0, unexplained = 0;  ///< counted: of `again`, those farther than a passer-by
  };
  Seen see_again(const Slot& earlier) const;
  /// A share, if enough was seen again.
  std::optional<double> share_of(const Seen& seen) const;

  SensorModel sensor_;
  TimeNs slot_, blind_;  ///< length of a slot; time without points after which nothing is compared [ns]
  Slot now_, before_, earlier_;
  std::array<int, 10> n_again_{};          ///< directions seen again in the slots of the last second
  std::size_t n_slots_ = 1, i_again_ = 0;  ///< slots of a second, at least 1; their number so far
  TimeNs last_placed_ = kTimeMin;          ///< of the points that count
  TimeNs last_end_ = kTimeMin;
};

}  // namespace aslio::pipeline
