#include "aslio/experiment/overlap_series.hpp"

#include <fmt/format.h>

#include <cmath>
#include <exception>
#include <iterator>
#include <random>
#include <utility>

#include "aslio/config/load.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/core/thrown.hpp"
#include "aslio/experiment/measure.hpp"
#include "aslio/experiment/truth.hpp"
#include "aslio/io/sensor_file.hpp"
#include "aslio/io/writers.hpp"
#include "aslio/pipeline/odometry.hpp"
#include "monitoring.hpp"

namespace aslio::experiment {

namespace {

/// Directions, the same on every machine.
class Directions {
 public:
  explicit Directions(std::uint64_t seed) : engine_(seed) {}
  Vec3 next() {
    const double z = 2.0 * uniform() - 1.0, angle = 2.0 * M_PI * uniform(), r = std::sqrt(1.0 - z * z);
    return {r * std::cos(angle), r * std::sin(angle), z};
  }

 private:
  double uniform() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
  std::mt19937_64 engine_;
};

/// Cuts the stream into frames, places and scores them.
class Scorer {
 public:
  Scorer(const OverlapSeriesOptions& options, Trajectory path, OverlapMetric& metric, const SensorModel& sensor,
         const std::function<void(const OverlapSample&)>& take, ProgressFeed& feed)
      : options_(options),
        metric_(metric),
        sensor_(sensor),
        take_(take),
        feed_(feed),
        path_(std::move(path)),
        max_gap_(to_ns(measuring_options(path_, evaluation::Rule::interpolated).max_reference_gap)),
        period_(to_ns(options.period)),
        directions_(options.seed) {}

  void push(LidarPacket&& packet) {
    stream_.push(std::move(packet));
    run_available();
  }

  void finish() {
    stream_.finish();
    run_available();
  }

  const OverlapSeriesEnd& end() const { return end_; }

 private:
  void run_available() {
    if (!stream_.first_point()) return;
    if (!begin_) begin_ = *stream_.first_point() - 1;
    while (*begin_ + period_ <= stream_.points_until() && *begin_ < stream_.last_point()) {
      const TimeNs end = *begin_ + period_;
      score(*begin_, end);
      stream_.release(end);
      begin_ = end;
    }
  }

  void place(std::span<const TimedPoint> raw) {
    points_.clear();
    std::optional<Pose> T;
    TimeNs t = kTimeMin;
    for (const TimedPoint& p : raw) {
      const Vec3 p_L(p.x, p.y, p.z);
      const double range = p_L.norm();
      if (range < sensor_.min_range || range > sensor_.max_range) continue;
      if (p.t != t) T = path_.pose(t = p.t, max_gap_);
      if (!T) {
        ++end_.points_without_pose;
        continue;
      }
      points_.push_back({*T * (sensor_.T_imu_lidar * p_L), p.t, static_cast<float>(range), p.intensity,
                         static_cast<std::uint32_t>(points_.size()), p.line, p.feature});
    }
  }

  /// points_, as if the pose of the frame were wrong.
  void move(const Vec3& centre) {
    const Mat3 R = exp_so3(options_.rotation_error * directions_.next());
    const Vec3 offset = options_.position_error * directions_.next();
    moved_ = points_;
    for (WorldPoint& point : moved_) point.p_W = R * (point.p_W - centre) + centre + offset;
  }

  void score(TimeNs begin, TimeNs end) {
    ++end_.frames;
    OverlapSample sample;
    place(stream_.points(begin, end));
    if (!points_.empty()) score_placed(end, sample);
    feed_.reached(begin, end, sample.score.value, false);  // their rate is no news
  }

  void score_placed(TimeNs end, OverlapSample& sample) {
    sample.t = end;
    metric_.advance(end);
    sample.score = metric_.evaluate(points_, end);
    if (options_.position_error > 0 || options_.rotation_error > 0) {
      move(path_.pose(points_.back().t, max_gap_)->p);
      sample.moved = metric_.evaluate(moved_, end).value;
    }
    metric_.extend(points_, end);
    ++end_.scored;
    take_(sample);
  }

  const OverlapSeriesOptions& options_;
  OverlapMetric& metric_;
  const SensorModel& sensor_;
  const std::function<void(const OverlapSample&)>& take_;
  ProgressFeed& feed_;
  Trajectory path_;
  TimeNs max_gap_, period_;
  Directions directions_;
  stream::MeasurementStream stream_;
  std::optional<TimeNs> begin_;
  std::vector<WorldPoint> points_, moved_;
  OverlapSeriesEnd end_;
};

}  // namespace

OverlapSeriesEnd score_overlap(const OverlapSeriesOptions& options, const plugin::Catalog& catalog,
                               const std::function<void(const OverlapSample&)>& take, RunMonitor& monitor) {
  std::vector<config::Override> overrides;
  for (const std::string& assignment : options.overrides) overrides.push_back({assignment});
  const auto pipeline =
      config::load<pipeline::PipelineConfig>(options.pipeline, config::FileKind::pipeline, catalog, overrides);
  const auto sensor = io::load_sensor(options.sensor, catalog);
  exec::Executor executor(1);
  const auto metric = pipeline.value.overlap.make({executor, sensor.value.model, nullptr});
  Truth truth = load_truth(options.trajectory, &sensor.value);
  if (truth.positions_only) {
    throw ConfigError(
        fmt::format("{}: it has positions only, and frames are placed by poses: name another trajectory, or "
                    "set `positions_only: no` if its orientation is meant",
                    options.trajectory.file));
  }
  const auto source = io::open_source(options.inputs, sensor.value, options.section);
  const std::vector<std::string> told = source->notes().warnings;
  monitor.on_start(source->notes());
  ProgressFeed feed(monitor, *source);
  Scorer scorer(options, std::move(truth.trajectory), *metric, sensor.value.model, take, feed);
  std::optional<std::string> failure;
  bool bad_data = false, interrupted = false;
  try {
    while (!(interrupted = monitor.stop_requested())) {
      auto measurement = source->next();
      if (!measurement) break;
      if (auto* packet = std::get_if<LidarPacket>(&*measurement)) scorer.push(std::move(*packet));
      feed.after_measurement();
    }
    if (!interrupted) scorer.finish();
  } catch (const DataError& error) {
    failure = error.what();
    bad_data = true;
  } catch (...) {
    failure = fmt::format("the overlap failed: {}", what_was_thrown());
  }
  source->conclude();
  feed.show();
  OverlapSeriesEnd end = scorer.end();
  end.interrupted = interrupted;
  end.truncated = source->status() == io::InputStatus::truncated;
  end.late_warnings = late_warnings(*source, told);
  end.bad_data = bad_data;
  end.failure = std::move(failure);
  if (end.scored == 0 && !end.failure && !end.interrupted) {
    end.bad_data = true;
    end.failure = fmt::format("{}: has no pose for any point of {}: name a trajectory of the same recording",
                              options.trajectory.file, options.inputs.front().string());
  }
  return end;
}

std::string overlap_series_header() {
  std::string text = "t_ns,points,sod";
  for (std::size_t i = 0; i < kMaxLayers; ++i) fmt::format_to(std::back_inserter(text), ",layer_{}", i);
  return text + ",sod_moved\n";
}

std::string overlap_series_line(const OverlapSample& sample) {
  const auto cell = [](const std::optional<double>& value) { return value ? fmt::format("{}", *value) : ""; };
  std::string text = fmt::format("{},{},{}", sample.t, sample.score.points, cell(sample.score.value));
  for (const std::uint32_t count : sample.score.layers) fmt::format_to(std::back_inserter(text), ",{}", count);
  return text + fmt::format(",{}\n", cell(sample.moved));
}

}  // namespace aslio::experiment
