#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "aslio/config/binder.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/stages/estimator.hpp"

namespace my_plugin {

/// T_W_I between two poses, evenly in rotation and position. Its unknown is the end.
class Between final : public aslio::TrajectoryModel {
 public:
  aslio::TimeNs begin_t = 0, end_t = 1;
  aslio::Pose begin, end;

  aslio::Pose pose(aslio::TimeNs t) const override;
  int dof() const override { return 6; }
  aslio::Pose moved(aslio::TimeNs t, const Eigen::VectorXd& xi) const override;
  void jacobian(aslio::TimeNs t, Eigen::MatrixXd& out) const override;

 private:
  double share(aslio::TimeNs t) const;
};

/// What is the state, given window and map? Here: registration. The gyro says how far the window turns, the velocity of
/// the last one how far it goes; Gauss-Newton steps, each with new matches, move its end until they are small, and the
/// prediction holds the directions that nothing was seen of. Old points of the window and the accelerometer take no
/// part. The contract stands in aslio/stages/estimator.hpp.
class MyStage final : public aslio::Estimator {
 public:
  /// Defaults stand here and nowhere else.
  struct Params {
    std::int64_t max_iterations = 30;
    double converged = 1e-4;
    std::int64_t min_matches = 50;
    double sigma = 0.1;
    double sigma_rotation = 0.005;
    double sigma_position = 0.02;
    aslio::config::Nested<aslio::Residual> residual{"point_to_plane"};
  };
  /// Names, units, ranges and meanings: what `aslio describe` tells and what a configuration is checked against.
  static void describe(aslio::config::Binder& b, Params& p);

  MyStage(const Params& params, const aslio::BuildContext& context);

  aslio::MapContent map_content() const override;
  void reset(const aslio::InitialState& initial) override;
  void adopt(const aslio::InertialEstimate& better) override;
  const aslio::Update& update(const aslio::Window& window, const aslio::HistorySelection& past,
                              const aslio::StepContext& context) override;
  const aslio::NavState& state() const override { return state_; }
  aslio::NavState predict(std::span<const aslio::ImuSample> imu) const override;

 private:
  /// J^T R^-1 J and J^T R^-1 r over (theta, p) of the end.
  struct Normal {
    aslio::Mat6 A = aslio::Mat6::Zero();
    aslio::Vec6 b = aslio::Vec6::Zero();
    std::uint32_t rows = 0;
    double squared = 0;  ///< sum of r^2 [m^2]
  };
  void load(const aslio::Window& window, aslio::SamplerChain& samplers);
  void associate(const aslio::Map& map, const aslio::Pose& end);
  Normal evaluate(const aslio::Pose& end);
  void solve(const aslio::Map& map);
  void accept(const aslio::Pose& end, const Normal& normal);
  void finish();

  Params params_;
  aslio::Pose T_imu_lidar_;
  std::unique_ptr<aslio::Residual> residual_;
  aslio::Mat6 prior_information_ = aslio::Mat6::Zero();  ///< of the predicted (theta, p)

  aslio::NavState state_;
  Between trajectory_;
  aslio::Update result_;

  // Buffers of the points: raw, in I at the end of the window, and in W for each consumer.
  std::vector<aslio::TimedPoint> raw_;
  std::vector<Eigen::Vector3f> body_;
  std::vector<aslio::TapMask> taps_;
  std::vector<std::uint32_t> index_;  ///< position in Window::fresh
  std::vector<aslio::Vec3> match_body_, queries_;
  std::vector<float> match_range_;
  aslio::Neighbours neighbours_;
  std::vector<aslio::Surface> surfaces_;
  std::vector<aslio::ResidualRow> rows_;
  std::vector<aslio::MatchRecord> records_;
  std::vector<aslio::WorldPoint> overlap_points_, map_points_, match_points_;
};

}  // namespace my_plugin
