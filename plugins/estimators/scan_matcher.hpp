#pragma once

#include <optional>

#include "aslio/config/binder.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/toolkit/constant_twist.hpp"
#include "aslio/toolkit/deskewed_scan.hpp"
#include "aslio/toolkit/imu_track.hpp"
#include "aslio/toolkit/information_update.hpp"
#include "aslio/toolkit/point_matches.hpp"
#include "aslio/toolkit/registration.hpp"
#include "estimators/sweep_index.hpp"

namespace aslio::plugins {

/// Registration of lines and planes in two steps (LOAM, Zhang and Singh 2014): the clearest points against the last
/// sweep, then all points against the map; directions that the matches do not hold keep what they were before. Points
/// are de-skewed by the IMU, or by a motion that goes on as it did (docs/equations.md SWP-1 to SWP-3). Those without a
/// class count as planes. With the IMU, velocity and biases are learnt from the poses that were found.
class ScanMatcher final : public Estimator {
 public:
  enum class Prediction : std::uint8_t { constant_velocity, imu };

  struct Params {
    Prediction prediction = Prediction::imu;
    std::int64_t sweep_searches = 2;
    std::int64_t map_searches = 2;
    std::int64_t max_steps = 4;
    std::int64_t map_every = 1;
    double converged_m = 5e-4;
    double converged_deg = 0.05;
    double sigma = 0.1;
    std::int64_t min_matches = 20;
    double degenerate_eigenvalue = 100.0;
    double sweep_distance = 5.0;
    std::int64_t sweep_lines = 2;
    ImuTrack::Params imu;
    config::Nested<Residual> lines{"point_to_line"};
    config::Nested<Residual> planes{"point_to_plane"};
  };
  static void describe(config::Binder& b, Params& p);
  /// Throws ConfigError when a residual takes surfaces from the map.
  ScanMatcher(const Params& params, const BuildContext& context);

  bool uses_imu() const override { return params_.prediction == Prediction::imu; }
  bool uses_history() const override { return false; }
  bool uses_features() const override { return true; }
  void reset(const InitialState& initial) override;
  void adopt(const InertialEstimate& better) override { better.put(state_); }
  const Update& update(const Window& window, const HistorySelection& past, const StepContext& context) override;
  const NavState& state() const override { return state_; }
  NavState predict(std::span<const ImuSample> imu) const override;

 private:
  /// The points of one class: which residual they have, and where they are in the list of matches.
  struct Kind {
    Kind(std::unique_ptr<Residual> own_residual, std::uint8_t own_feature, const SweepIndex::Reach& reach)
        : residual(std::move(own_residual)), feature(own_feature), last_sweep(reach) {}
    std::unique_ptr<Residual> residual;
    std::uint8_t feature;
    SweepIndex last_sweep;
    PointMatches all;                  ///< against the map
    std::vector<std::uint32_t> index;  ///< of `all`, into the frame's matches
    PointMatches clearest;             ///< against the last sweep

    std::size_t rows() const { return static_cast<std::size_t>(residual->rows_per_match()); }
  };
  /// What a step of Gauss-Newton was like.
  enum class Step : std::uint8_t { refused, moved, small };
  /// Normal equations over matches, of which one may have several rows.
  struct MatchSum : PoseInformation {
    std::size_t rows = 0;
    MatchSum& operator+=(const MatchSum& other) {
      PoseInformation::operator+=(other);
      rows += other.rows;
      return *this;
    }
  };
  /// A pose on its way down.
  struct Descent {
    Pose end;
    Mat6 held = Mat6::Identity();  ///< directions in which it may move, from the first rows
    MatchSum sum = {};             ///< of the last step
    std::uint32_t matches = 0;     ///< of the last step
    bool degenerate = false;       ///< it may not move in all directions
    bool converged = false;        ///< the last step was small
    bool settled = false;          ///< new matches would change nothing
  };

  void propagate(const Window& window);
  void load(const Window& window, const StepContext& context);
  bool descend(PointMatches Kind::*points, bool first, Descent& at);
  void take(const Descent& at);
  bool drop(const Descent& at);
  void list_clearest(Kind& kind);
  bool match_last_sweep();
  void associate_clearest(Kind& kind);
  bool match_map(const Map& map);
  MatchSum measure(PointMatches& matches, Residual& residual, const Pose& at);
  Step move(const MatchSum& sum, const Mat6& held, Pose& end);
  void hold_directions(Descent& at) const;
  Mat6 measured(const Descent& at) const;
  void accept();
  void refuse(UpdateStatus status);
  void finish();
  void record_matches();

  Params params_;
  exec::Executor& exec_;
  ImuTrack imu_;
  Kind lines_, planes_;

  NavState state_;
  StateMatrix P_ = StateMatrix::Zero();
  ConstantTwist twist_;

  NavState prior_;
  WindowTrajectory trajectory_{WindowTrajectory::Spread::rigid};
  DeskewedScan frame_;
  std::optional<Descent> last_,
      before_;               ///< of this window, taken: the last, and that against the last sweep before it
  bool not_finite_ = false;  ///< a step of this window was not
  std::vector<MatchSum> partials_;
  std::vector<MatchRecord> records_, own_records_;
  Update result_;
};

}  // namespace aslio::plugins
