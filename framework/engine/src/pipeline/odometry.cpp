#include "aslio/pipeline/odometry.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "aslio/core/cpu_clock.hpp"
#include "aslio/pipeline/monitor.hpp"
#include "aslio/pipeline/new_start.hpp"
#include "aslio/pipeline/stage_set.hpp"
#include "bias_watch.hpp"
#include "doubted_imu.hpp"
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
        start_offset_(start_offset(context.order_seed)),
        anew_{context.exec, sensor_, context.log, context.order_seed, true},
        stream_(stream::ImuRange{sensor_.gyro_range, sensor_.acc_range}),
        tracking_(config.limits, context.sensor.sweep_period),
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
      note_gaps(*plan);
      if (tracking_.lost()) continue;
      step(*plan, record);
      stream_.release(feedback_.t - stages_.window->reach());
    }
    forget_unused_imu();
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
    // A gap at the begin of the window is no time in which the estimator failed: its silence begins with the data.
    const TimeNs data_begin = window.fresh.empty() ? plan.fresh_begin : window.fresh.front().t;
    record.without_view = lacks_view(window, update);
    tracking_.observe(update, data_begin, plan.end, record.without_view, unread(window));
    if (alarm) tracking_.observe_alarm(plan.end, *monitor_.alarm());
    // One that is lost by silence has a dead-reckoned pose; one that is lost by its state, the last that was accepted.
    // One that is lost by an alarm has its pose from points that do not fit.
    if (!alarm && (tracking_.lost() ? sound(update.state) : update.accepted)) believed_ = update.state.pose();
    if (update.accepted && !tracking_.lost()) last_accepted_ = plan.end;
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

  /// The points of before a jump of the clock are gone, and how long ago they were is not known.
  void note_clock_jumps() {
    for (; clock_jumps_ < stream_.clock_jumps().size(); ++clock_jumps_) {
      const stream::ClockJump& jump = stream_.clock_jumps()[clock_jumps_];
      if (!started()) continue;
      new_start_.reset();
      found_start_.reset();
      tracking_.observe_clock_jump(jump.t, jump.by);
    }
  }

  void finish() {
    stream_.finish();
    run_available();
    stages_.insertion->finish(*stages_.map);
  }

  bool started() const { return initialisation_.has_value(); }
  bool has_ended() const {
    return tracking_.lost() && (config_.when_lost == PipelineConfig::WhenLost::end || !tracking_.may_restart());
  }

  /// Whether there is a state to go on from: that of the last update, the first one, or after a loss a new first one.
  bool ready() {
    if (has_ended()) return false;
    if (tracking_.lost()) return restart();
    return started() || start();
  }

  bool start() {
    if (!stream_.settled()) {
      forget_waiting_data();
      return false;
    }
    initialisation_ = stages_.estimator->uses_imu()
                          ? initialise(stream_, config_.initialisation, sensor_, start_offset_)
                          : initialise_without_imu(stream_, start_offset_);
    if (started() && !look_at_sweeps(*initialisation_, nullptr)) initialisation_.reset();
    if (!started()) {
      forget_waiting_data();
      return false;
    }
    begin(initialisation_->initial);
    tracking_.begin(feedback_.t);
    // A silence is known to be longer than max_gap once points that much later came, and the IMU may still be late.
    stream_.wait_for_imu(to_ns(config_.limits.max_gap) + kMaxKept);
    return true;
  }

  /// Lets the first sweeps confirm or correct a start (eq. INI-6). False while they have not arrived.
  bool look_at_sweeps(Initialisation& found, const Mat3* heading) {
    if (!config_.initialisation.register_sweeps) return true;
    const bool declared_rest = config_.initialisation.mode == InitialisationMode::static_start;
    const bool inertial = stages_.estimator->uses_imu();
    const TimeNs begin = found.initial.state.t, end = begin + sweep_motion_span(sensor_);
    // An IMU that falls silent is waited for as long as the points of the sweeps are kept.
    const TimeNs patience = points_kept() - sweep_motion_span(sensor_);
    const bool arrived = stream_.points_until() >= end && (!inertial || stream_.imu_until() >= end);
    if (!arrived && !stream_.finished() && stream_.last_point() < end + patience) return false;
    std::vector<ImuSample> imu;
    if (inertial) stream_.imu_covering(begin, end, imu);
    const auto motion = find_sweep_motion(stream_.points(begin, end), imu, begin, sensor_);
    if (motion && declared_rest && segment_ == 0) doubt_declared_rest(found, *motion);
    if (motion && !declared_rest) apply_sweep_motion(found, *motion, heading);
    return true;
  }

  /// Without IMU data nothing begins, nor without points, and what comes of the others would pile up.
  void forget_waiting_data() {
    if (stream_.last_point() > kTimeMin + points_kept()) stream_.forget_points(stream_.last_point() - points_kept());
    const TimeNs imu_kept = kMaxKept + to_ns(config_.initialisation.time);
    const bool no_points_yet = !stream_.first_point() && stream_.last_imu() > kTimeMin + imu_kept;
    if (no_points_yet && stream_.imu_settled()) stream_.release(stream_.last_imu() - imu_kept);
  }

  /// What comes while the LiDAR is silent would pile up. Points may be late, but not by so much.
  void forget_unused_imu() {
    constexpr TimeNs kept = 600 * kSecond;
    if (!stream_.imu_settled() || stream_.last_imu() < kTimeMin + kept) return;
    if (stream_.last_imu() - kept > stream_.last_point()) stream_.release(stream_.last_imu() - kept);
  }

  /// Of points that wait for IMU data: those of the first sweeps (INI-6) are among them, also of a slow sensor.
  TimeNs points_kept() const { return kMaxKept + sweep_motion_span(sensor_) - kSweepsOfMotion * kSecond / 10; }

  /// Everything anew but the stream. The old map is let go: how it lies to what follows is not known.
  bool restart() {
    if (!new_start_) new_start_.emplace(last_known(), config_.initialisation, sensor_);
    if (stages_.estimator->uses_imu() && stream_.last_point() > kTimeMin + points_kept()) {
      // IMU data of points that are kept no longer.
      new_start_->skip(stream_.last_point() - points_kept() - to_ns(config_.initialisation.time));
    }
    if (!found_start_) found_start_ = new_start_->find(stream_, *stages_.estimator);
    if (!found_start_) {
      if (stages_.estimator->uses_imu()) stream_.release(new_start_->keep_imu_from());
      stream_.forget_points(new_start_->searched_until());
      forget_waiting_data();
      return false;
    }
    const Mat3 heading = found_start_->initial.state.R;
    if (!look_at_sweeps(*found_start_, &heading)) return false;
    const auto found = std::exchange(found_start_, std::nullopt);
    take(build_stages(config_, anew_));
    new_start_.reset();
    feedback_ = {};
    ++segment_;
    tracking_.restart(found->initial.state.t);
    begin(found->initial);
    return true;
  }

  LastKnown last_known() const {
    LastKnown known{
        tracking_.losses().back().t + start_offset_, believed_, {}, last_accepted_, config_.limits.max_speed};
    // Soon after a start in motion an estimator does not know yet how fast it is.
    const NavState& state = stages_.estimator->state();
    // After an alarm it has learnt from what does not fit.
    const bool learnt = last_accepted_ - segment_begin_ >= kSecond && !monitor_.alarm();
    if (learnt && sound(state)) known.state = state;
    return known;
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
    last_point_ = last_accepted_ = segment_begin_ = feedback_.t;
    believed_ = initial.state.pose();
    doubted_imu_.begin(initial.state);
    wide_motion_.forget();
    bias_watch_.begin();
    stream_.release(feedback_.t);
  }

  /// Before the window is cut: what comes after a gap that is too long is for a new start.
  void note_gaps(const WindowPlan& plan) {
    note_gap(plan);
    if (tracking_.lost() || !stages_.estimator->uses_imu()) return;
    const auto silent_after = stream_.imu_silent_after(plan.fresh_begin, plan.end, to_ns(config_.limits.max_gap));
    if (silent_after) tracking_.observe_silent_imu(*silent_after);
  }

  void note_gap(const WindowPlan& plan) {
    const auto points = stream_.points(plan.fresh_begin, plan.end);
    if (points.empty()) return;
    tracking_.observe_gap(last_point_, points.front().t - 1);
    if (plan.end - plan.fresh_begin > to_ns(config_.limits.max_gap)) {  // only then may one lie between its points
      for (std::size_t i = 1; i < points.size() && !tracking_.lost(); ++i) {
        tracking_.observe_gap(points[i - 1].t, points[i].t - 1);
      }
    }
    last_point_ = points.back().t;
  }

  /// Whether an update was refused because hardly any points came, where usually many do.
  bool lacks_view(const Window& window, const Update& update) {
    constexpr double kHardlyAny = 0.1, kShare = 0.05;
    const double length = to_seconds(window.plan.end - window.plan.fresh_begin);
    const double density = static_cast<double>(window.fresh.size()) / std::max(length, 1e-3);
    if (update.accepted) usual_density_ += (usual_density_ > 0 ? kShare : 1.0) * (density - usual_density_);
    return update.status == UpdateStatus::few_matches && density < kHardlyAny * usual_density_;
  }

  static bool unread(const Window& window) {
    return window.imu_gap >= WideMotion::kLongGap ||
           std::any_of(window.imu.begin(), window.imu.end(),
                       [](const auto& s) { return (s.faults & imu_fault::gyro_dead) != 0; });
  }

  bool sound(const NavState& state) const {
    return state.R.allFinite() && state.p.allFinite() && state.v.allFinite() &&
           state.v.norm() <= config_.limits.max_speed;
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
    record.segment = segment_;
    record.status = update.status;
    record.tracking = tracking_.status();
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

  /// Of data that wait for others, while there is no state. IMU data that come no later than this after the points
  /// change nothing by it.
  static constexpr TimeNs kMaxKept = 5 * kSecond;
  PipelineConfig config_;
  SensorModel sensor_;
  TimeNs start_offset_;
  BuildContext anew_;  ///< of the stages after a loss
  stream::MeasurementStream stream_;
  DoubtedImu doubted_imu_;
  std::size_t clock_jumps_ = 0;  ///< of the stream, that the tracking knows of
  StageSet stages_;
  std::optional<PriorProbe> probe_;
  double deciding_ = 0;  ///< CPU time of the window that comes next, so far [s]
  Tracking tracking_;
  WideMotion wide_motion_;
  BiasWatch bias_watch_;
  Monitor monitor_;
  RangeNoise range_noise_;
  double noise_scale_ = 1;  ///< that the stages know of
  std::vector<UpdateObserver*> observers_;
  std::optional<Initialisation> initialisation_;
  Feedback feedback_;
  Pose believed_;  ///< T_W_I where the run begins anew if it is lost now
  TimeNs last_point_ = 0, last_accepted_ = 0, segment_begin_ = 0;
  double usual_density_ = 0;                   ///< points per second of the updates that were accepted
  std::optional<NewStart> new_start_;          ///< while lost
  std::optional<Initialisation> found_start_;  ///< by it, not yet confirmed by the sweeps
  std::uint32_t sequence_ = 0, segment_ = 0;
};

Odometry::Odometry(const PipelineConfig& config, const BuildContext& context)
    : Odometry(config, context, build_stages(config, context)) {}
Odometry::Odometry(const PipelineConfig& config, const BuildContext& context, StageSet stages)
    : pipeline_(std::make_unique<Pipeline>(config, context, std::move(stages))) {}
Odometry::~Odometry() = default;

void Odometry::add_observer(UpdateObserver& observer) { pipeline_->observers_.push_back(&observer); }

void Odometry::push(Measurement&& measurement) {
  if (pipeline_->has_ended()) return;  // it would only pile up
  if (auto* packet = std::get_if<LidarPacket>(&measurement)) {
    pipeline_->stream_.push(std::move(*packet));
  } else {
    pipeline_->stream_.push(std::get<ImuSample>(measurement));
  }
  pipeline_->note_clock_jumps();
  pipeline_->run_available();
}

void Odometry::finish() { pipeline_->finish(); }

const Divergence* Odometry::divergence() const { return pipeline_->tracking_.divergence(); }
const std::vector<Divergence>& Odometry::losses() const { return pipeline_->tracking_.losses(); }
bool Odometry::has_ended() const { return pipeline_->has_ended(); }
const MonitorReport& Odometry::monitor() const { return pipeline_->monitor_.report(); }
TrackingStatus Odometry::tracking() const { return pipeline_->tracking_.status(); }
const std::optional<Initialisation>& Odometry::initialisation() const { return pipeline_->initialisation_; }
const stream::MeasurementStream& Odometry::stream() const { return pipeline_->stream_; }
const Map& Odometry::map() const { return *pipeline_->stages_.map; }
const OverlapMetric& Odometry::overlap() const { return *pipeline_->stages_.overlap; }
const RangeNoise& Odometry::range_noise() const { return pipeline_->range_noise_; }

}  // namespace aslio::pipeline
