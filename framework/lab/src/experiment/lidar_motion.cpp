#include "aslio/experiment/lidar_motion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <variant>

#include "aslio/config/load.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/pipeline/odometry.hpp"
#include "aslio/pipeline/stage_set.hpp"
#include "monitoring.hpp"

namespace aslio::experiment {

namespace {

constexpr double kUnsettled = 0.5;             // [s] at the begin of a stretch, where the motion is not known yet
constexpr double kShortest = 1.0;              // [s] of a stretch that is worth keeping
constexpr double kTurns = 0.05, kMoves = 0.1;  // [rad/s], [m/s] of a window in motion

/// Keeps the poses in the middle of the windows.
class PoseCollector final : public pipeline::UpdateObserver {
 public:
  explicit PoseCollector(LidarMotion& motion) : motion_(motion) {}

  void on_update(const pipeline::UpdateRecord& record) override {
    ++motion_.windows;
    const Update* update = record.update;
    const bool good = update != nullptr && update->accepted && update->trajectory != nullptr && !record.plan.partial;
    if (!good) return cut();
    ++motion_.accepted;
    const TimeNs begin = record.plan.fresh_begin, end = record.plan.end, window = end - begin;
    const bool follows = open_ && record.segment == segment_ && begin == last_end_ && alike(window);
    if (!follows) cut();
    segment_ = record.segment;
    last_end_ = end;
    const StampedPose pose{begin + window / 2, update->trajectory->pose(begin + window / 2)};
    if (follows) measure(pose);
    if (!open_) {
      stretch_ = {{}, window};
      begin_ = begin;
    }
    open_ = true;
    last_ = pose;
    if (to_seconds(begin - begin_) >= kUnsettled) stretch_.poses.push_back(pose);
  }

  /// The stretch ends here.
  void cut() {
    const auto& poses = stretch_.poses;
    if (!poses.empty() && to_seconds(poses.back().t - poses.front().t) >= kShortest) {
      motion_.stretches.push_back(std::move(stretch_));
    }
    stretch_ = {};
    open_ = false;
  }

 private:
  bool alike(TimeNs window) const { return 10 * std::abs(window - stretch_.window) <= stretch_.window; }

  void measure(const StampedPose& pose) {
    const double dt = to_seconds(pose.t - last_.t);
    const double turned = log_so3(last_.T.R.transpose() * pose.T.R).norm(), moved = (pose.T.p - last_.T.p).norm();
    if (turned > kTurns * dt || moved > kMoves * dt) motion_.moving_s += dt;
  }

  LidarMotion& motion_;
  evaluation::MotionStretch stretch_;
  bool open_ = false;
  std::uint32_t segment_ = 0;
  TimeNs begin_ = kTimeMin, last_end_ = kTimeMin;  ///< of the stretch, of the last window
  StampedPose last_;
};

/// Takes the IMU samples aside, and the time between messages.
class Pump {
 public:
  Pump(const LidarMotionOptions& options, LidarMotion& motion, pipeline::Odometry& odometry)
      : options_(options), motion_(motion), odometry_(odometry) {}

  /// False when it is enough.
  bool take(Measurement&& measurement) {
    if (const auto* sample = std::get_if<ImuSample>(&measurement)) {
      if (sample->gyro.allFinite() && sample->acc.allFinite()) motion_.imu.push_back(*sample);
      return true;
    }
    const TimeNs stamp = std::get<LidarPacket>(measurement).stamp;
    if (first_ == kTimeMin) {
      first_ = stamp;
    } else {
      periods_.push_back(to_seconds(stamp - last_));
    }
    last_ = stamp;
    motion_.data_s = to_seconds(stamp - first_);
    odometry_.push(std::move(measurement));
    return motion_.moving_s < options_.enough && motion_.data_s < options_.longest && !odometry_.has_ended();
  }

  void conclude() {
    std::stable_sort(motion_.imu.begin(), motion_.imu.end(),
                     [](const ImuSample& a, const ImuSample& b) { return a.t < b.t; });
    if (periods_.empty()) return;
    const auto middle = periods_.begin() + static_cast<std::ptrdiff_t>(periods_.size() / 2);
    std::nth_element(periods_.begin(), middle, periods_.end());
    motion_.sweep_period = *middle;
  }

 private:
  const LidarMotionOptions& options_;
  LidarMotion& motion_;
  pipeline::Odometry& odometry_;
  TimeNs first_ = kTimeMin, last_ = kTimeMin;  ///< stamps of messages; kTimeMin: none yet
  std::vector<double> periods_;
};

}  // namespace

LidarMotion read_lidar_motion(const LidarMotionOptions& options, const plugin::Catalog& catalog, RunMonitor& monitor) {
  std::vector<config::Override> overrides;
  for (const std::string& assignment : options.overrides) overrides.push_back({assignment});
  const auto pipeline =
      config::load<pipeline::PipelineConfig>(options.pipeline, config::FileKind::pipeline, catalog, overrides);
  SensorModel model = options.sensor.model;
  model.T_imu_lidar = Pose{};  // the poses are those of the LiDAR
  exec::Executor executor(1);
  const BuildContext context{executor, model, nullptr};
  pipeline::StageSet stages = pipeline::build_stages(pipeline, context);
  if (stages.estimator->uses_imu()) {
    throw ConfigError(
        fmt::format("{}: its estimator takes IMU data, and the check compares the IMU with the points "
                    "alone: name one without, as ct_icp.yaml",
                    options.pipeline.string()));
  }
  pipeline::Odometry odometry(pipeline.value, context, std::move(stages));
  const auto source = io::open_source(options.inputs, options.sensor, options.section);
  const std::vector<std::string> told = source->notes().warnings;
  monitor.on_start(source->notes());

  LidarMotion motion;
  PoseCollector collector(motion);
  ProgressFeed feed(monitor, *source);
  odometry.add_observer(collector);
  odometry.add_observer(feed);
  Pump pump(options, motion, odometry);
  while (!(motion.interrupted = monitor.stop_requested())) {
    auto measurement = source->next();
    if (!measurement) {
      odometry.finish();
      break;
    }
    if (!pump.take(std::move(*measurement))) break;
    feed.after_measurement();
  }
  collector.cut();
  pump.conclude();
  source->conclude();
  feed.show();
  motion.late_warnings = late_warnings(*source, told);
  return motion;
}

}  // namespace aslio::experiment
