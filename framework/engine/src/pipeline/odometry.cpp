#include "aslio/pipeline/odometry.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "aslio/core/cpu_clock.hpp"
#include "aslio/pipeline/monitor.hpp"
#include "aslio/pipeline/stage_set.hpp"
#include "bias_watch.hpp"
#include "doubted_imu.hpp"
#include "lifecycle.hpp"
#include "prior_probe.hpp"
#include "wide_motion.hpp"

namespace aslio::pipeline {

namespace {

double gyro_rms(std::span<const ImuSample> samples) {
  double squares = 0;
  for (const ImuSample& sample : samples) squares += sample.gyro.squaredNorm();
  return samples.empty() ? std::numeric_limits<double>::quiet_NaN()
                         : std::sqrt(squares / static_cast<double>(samples.size()));
}

}  // namespace

class Odometry::Pipeline {
 public:
  Pipeline(const PipelineConfig& config, const BuildContext& context, StageSet stages)
      : config_(config),
        sensor_(context.sensor),
        anew_{context.exec, sensor_, context.log, context.order_seed, true},
        stream_(stream::ImuRange{sensor_.gyro_range, sensor_.acc_range}),
        life_(config_, sensor_, start_offset(context.order_seed), stream_),
        wide_motion_(context.sensor),
        monitor_(context.sensor),
        range_noise_(config.range_noise, context.sensor) {
    take(std::move(stages));
    if (!stages_.estimator->uses_imu()) stream_.leave_imu_out();
  }

  void run_available() {
    while (ready()) {
      std::optional<WindowPlan> plan;
      {
        const CpuTimer timer(deciding_);
        plan = stages_.window->next(stream_, feedback_, *probe_);
      }
      if (!plan) break;  // what it took to see that more is needed counts for the window that comes of it
      UpdateRecord record;
      record.times.window = std::exchange(deciding_, 0.0);
      life_.note_gaps(*plan, stages_.estimator->uses_imu());
      if (life_.lost()) continue;
      step(*plan, record);
      stream_.release(feedback_.t - stages_.window->reach());
    }
    life_.forget_unused_imu();
  }

  void step(const WindowPlan& plan, UpdateRecord& record) {
    Window window = stream_.cut(plan, ++sequence_);
    doubted_imu_.mend(window, feedback_.state);
    record.bridged = wide_motion_.mend(window, feedback_.state, doubted_imu_.rate());
    range_noise_.observe(window.fresh);
    if (range_noise_.scale() != noise_scale_) apply_noise_scale();
    const HistorySelection past = stages_.history->select(window);
    {
      const CpuTimer timer(record.times.insert);
      record.inserted = stages_.insertion->begin(window, *stages_.map);
    }
    stages_.samplers.observe(feedback_);
    const Update& update = stages_.estimator->update(window, past, {stages_.samplers, *stages_.map, *stages_.history});
    record.times = add(record.times, update.times);
    {  // After alignment, BEFORE merging: measured after the merge it would always be about 1.
      const CpuTimer timer(record.times.overlap);
      stages_.overlap->advance(plan.end);
      record.overlap = stages_.overlap->evaluate(update.points(PointUse::overlap), plan.end);
    }
    record.monitor = monitor_.observe(window, update, record.overlap, record.bridged);
    const bool alarm = monitor_.alarm().has_value();
    if (update.insert && !alarm) insert(window, update, record);
    if (!alarm && (update.accepted || update.status == UpdateStatus::initialising)) {
      // What was placed before the map began anew must not be matched against it.
      if (update.restart_map) {
        stages_.history->reset();
        wide_motion_.forget();
      }
      wide_motion_.observe(window, update);
      stages_.history->commit(window, update);
    } else {
      stages_.history->reset();
    }
    record.without_view = life_.note_update(window, update, unread(window), monitor_.alarm());
    doubted_imu_.observe(update.state);
    // What it left wrong turns predictions, too.
    if (record.bridged || alarm || unread(window)) bias_watch_.begin();
    const double bias_off = bias_watch_.observe(window, update);
    record.bias_step = bias_off > 0;
    report(window, past, update, record);
    if (record.bias_step) stages_.estimator->doubt_gyro_bias(bias_off);
    // Of a map that has begun anew nothing is known.
    const OverlapScore overlap = update.restart_map ? OverlapScore{} : record.overlap;
    feedback_ = {plan.end,     feedback_.first_insertion, update.status,    overlap,
                 update.state, update.spectrum,           record.n_matches, update.unobservable_direction()};
  }

  void finish() {
    stream_.finish();
    run_available();
    stages_.insertion->finish(*stages_.map);
  }

  /// Whether there is a state to go on from: that of the last update or, at the start and after a loss, a first one.
  bool ready() {
    if (life_.has_ended()) return false;
    if (life_.running()) return true;
    const bool was_lost = life_.lost();
    const auto initial = life_.find_start(*stages_.estimator, monitor_.alarm().has_value());
    if (!initial) return false;
    // All is new but the stream. How the old map lies to what follows is not known.
    if (was_lost) {
      take(build_stages(config_, anew_));
      feedback_ = {};
    }
    begin(*initial);
    return true;
  }

  void take(StageSet stages) {
    stages_ = std::move(stages);
    probe_.emplace(stream_, *stages_.estimator, stages_.samplers, *stages_.overlap, sensor_);
    noise_scale_ = 1;
    if (range_noise_.scale() != noise_scale_) apply_noise_scale();
  }

  void apply_noise_scale() {
    noise_scale_ = range_noise_.scale();
    stages_.map->set_noise_scale(noise_scale_);
    stages_.estimator->set_noise_scale(noise_scale_);
  }

  void begin(const InitialState& initial) {
    stages_.estimator->reset(initial);
    feedback_.t = initial.state.t;
    feedback_.state = initial.state;
    monitor_.begin(stages_.estimator->uses_imu());
    doubted_imu_.begin(initial.state);
    wide_motion_.forget();
    bias_watch_.begin();
  }

  static bool unread(const Window& window) {
    return window.imu_gap >= WideMotion::kLongGap ||
           std::any_of(window.imu.begin(), window.imu.end(),
                       [](const auto& s) { return (s.faults & imu_fault::gyro_dead) != 0; });
  }

  /// What the overlap takes to learn what is known counts as its cost, not as the map's.
  void insert(const Window& window, const Update& update, UpdateRecord& record) {
    {
      const CpuTimer timer(record.times.insert);
      if (update.restart_map) stages_.map->clear();
      const InsertCount inserted = stages_.insertion->apply(window, update, *stages_.map);
      record.inserted.offered += inserted.offered;
      record.inserted.inserted += inserted.inserted;
      stages_.map->trim(update.state.p);
    }
    {
      const CpuTimer timer(record.times.overlap);
      if (update.restart_map) stages_.overlap->clear();
      stages_.overlap->extend(update.points(PointUse::overlap), window.plan.end);
      stages_.overlap->trim(update.state.p, stages_.map->radius());
    }
    if (feedback_.first_insertion == kTimeMax && stages_.map->size() > 0) feedback_.first_insertion = window.plan.end;
  }

  void report(const Window& window, const HistorySelection& past, const Update& update, UpdateRecord& record) {
    record.plan = window.plan;
    record.sequence = window.sequence;
    record.segment = life_.segment();
    record.status = update.status;
    record.tracking = life_.tracking().status();
    record.n_fresh = static_cast<std::uint32_t>(window.fresh.size());
    record.n_history = static_cast<std::uint32_t>(past.points.size());
    record.iterations = update.iterations;
    record.n_matches = update.fresh_matches + update.history_matches;
    record.spectrum = update.spectrum;
    record.residual_rms = update.residual_rms;
    record.gyro_rms = gyro_rms(window.imu);
    record.map_points = stages_.map->size();
    record.state = update.state;
    record.digest = state_digest(update.state);
    record.update = &update;
    for (UpdateObserver* observer : observers_) observer->on_update(record);
  }

  static StageTimes add(StageTimes a, const StageTimes& b) {
    a.predict += b.predict;
    a.deskew += b.deskew;
    a.sample += b.sample;
    a.associate += b.associate;
    a.solve += b.solve;
    return a;
  }

  PipelineConfig config_;
  SensorModel sensor_;
  BuildContext anew_;  ///< of the stages after a loss
  stream::MeasurementStream stream_;
  DoubtedImu doubted_imu_;
  StageSet stages_;
  std::optional<PriorProbe> probe_;
  double deciding_ = 0;  ///< CPU time of the window that comes next, so far [s]
  Lifecycle life_;
  WideMotion wide_motion_;
  BiasWatch bias_watch_;
  Monitor monitor_;
  RangeNoise range_noise_;
  double noise_scale_ = 1;  ///< that the stages know of
  std::vector<UpdateObserver*> observers_;
  Feedback feedback_;
  std::uint32_t sequence_ = 0;
};

Odometry::Odometry(const PipelineConfig& config, const BuildContext& context)
    : Odometry(config, context, build_stages(config, context)) {}
Odometry::Odometry(const PipelineConfig& config, const BuildContext& context, StageSet stages)
    : pipeline_(std::make_unique<Pipeline>(config, context, std::move(stages))) {}
Odometry::~Odometry() = default;

void Odometry::add_observer(UpdateObserver& observer) { pipeline_->observers_.push_back(&observer); }

void Odometry::push(Measurement&& measurement) {
  if (pipeline_->life_.has_ended()) return;  // it would only pile up
  if (auto* packet = std::get_if<LidarPacket>(&measurement)) {
    pipeline_->stream_.push(std::move(*packet));
  } else {
    pipeline_->stream_.push(std::get<ImuSample>(measurement));
  }
  pipeline_->life_.note_clock_jumps();
  pipeline_->run_available();
}

void Odometry::finish() { pipeline_->finish(); }

const Divergence* Odometry::divergence() const { return pipeline_->life_.tracking().divergence(); }
const std::vector<Divergence>& Odometry::losses() const { return pipeline_->life_.tracking().losses(); }
bool Odometry::has_ended() const { return pipeline_->life_.has_ended(); }
const MonitorReport& Odometry::monitor() const { return pipeline_->monitor_.report(); }
TrackingStatus Odometry::tracking() const { return pipeline_->life_.tracking().status(); }
const std::optional<Initialisation>& Odometry::initialisation() const { return pipeline_->life_.initialisation(); }
const stream::MeasurementStream& Odometry::stream() const { return pipeline_->stream_; }
const Map& Odometry::map() const { return *pipeline_->stages_.map; }
const OverlapMetric& Odometry::overlap() const { return *pipeline_->stages_.overlap; }
const RangeNoise& Odometry::range_noise() const { return pipeline_->range_noise_; }

}  // namespace aslio::pipeline
