#include "aslio/experiment/run.hpp"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "aslio/config/load.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/core/thrown.hpp"
#include "aslio/experiment/family.hpp"
#include "aslio/experiment/measure.hpp"
#include "aslio/experiment/truth.hpp"
#include "aslio/io/sensor_file.hpp"
#include "aslio/io/writers.hpp"
#include "aslio/pipeline/stage_set.hpp"
#include "manifest.hpp"
#include "monitoring.hpp"
#include "run_outputs.hpp"

namespace aslio::experiment {

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

/// User and system time of the process [s].
double process_cpu_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

/// Of this program image: what getrusage tells survives exec, and so is that of whoever started the program, if larger.
double peak_rss_mb() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("VmHWM:")) return std::stod(line.substr(6)) * 1024e-6;
  }
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) * 1024e-6;
}

/// Everything a run works with, checked before any data is read.
struct Prepared {
  config::Loaded<pipeline::PipelineConfig> pipeline;
  config::Loaded<io::SensorConfig> sensor;
  std::optional<Truth> reference;
};

Prepared prepare(const RunOptions& options, const plugin::Catalog& catalog) {
  std::vector<config::Override> overrides;
  for (const std::string& assignment : options.overrides) overrides.push_back({assignment});
  if (options.stop_when_diverged) overrides.push_back({"when_lost=end"});
  Prepared prepared;
  prepared.pipeline =
      config::load<pipeline::PipelineConfig>(options.pipeline, config::FileKind::pipeline, catalog, overrides);
  prepared.sensor = io::load_sensor(options.sensor, catalog);
  if (options.reference) prepared.reference.emplace(load_truth(*options.reference, &prepared.sensor.value));
  return prepared;
}

void notify(RunMonitor& monitor, const RunOptions& options, const Prepared& prepared) {
  if (prepared.pipeline.alias_of.empty()) return;
  monitor.on_notice(fmt::format("{} is the old name of {}", options.pipeline.filename().string(),
                                prepared.pipeline.alias_of.filename().string()));
}

/// Before the run: the digest of a large input takes a while, and must not count as CPU time of the method.
Manifest identify(const RunOptions& options, const Prepared& prepared) {
  Manifest manifest;
  manifest.program_sha256 = io::input_digest("/proc/self/exe");
  manifest.pipeline_sha256 = io::input_digest(options.pipeline);
  manifest.sensor_sha256 = io::input_digest(options.sensor);
  if (options.reference) manifest.reference_sha256 = io::input_digest(options.reference->file);
  if (prepared.reference) manifest.reference_resolved = io::resolved_text(prepared.reference->spec);
  manifest.sensor_resolved = prepared.sensor.resolved;
  manifest.stages = prepared.pipeline.plugin_types;
  const auto start = Clock::now();
  if (!options.open_input) manifest.input_sha256 = io::input_digest(options.inputs());
  manifest.input_hash_s = seconds_since(start);
  return manifest;
}

/// Opens the input and identifies everything that is read. What cannot be read fails the run, and the summary says so.
std::unique_ptr<io::MeasurementSource> open_source(const RunOptions& options, const Prepared& prepared,
                                                   Manifest& manifest) {
  try {
    auto source = options.open_input ? options.open_input(prepared.sensor.value)
                                     : io::open_source(options.inputs(), prepared.sensor.value, options.section);
    manifest = identify(options, prepared);
    return source;
  } catch (const std::exception& error) {
    Summary summary;
    RunOutcome outcome;
    outcome.failure = error.what();
    judge(summary, outcome);
    write_file(options.output / "resolved.yaml", prepared.pipeline.resolved);
    write_file(options.output / "summary.json", to_json(summary));
    throw;
  }
}

/// How a run went on after its first loss.
std::string what_followed(const std::vector<pipeline::Divergence>& losses) {
  const auto restarts =
      std::count_if(losses.begin(), losses.end(), [](const auto& loss) { return loss.restarted.has_value(); });
  if (restarts == 0) return {};
  const std::string first = losses.front().restarted
                                ? fmt::format("; started again {:.2f} s later with an empty map",
                                              to_seconds(*losses.front().restarted - losses.front().t))
                                : std::string();
  return losses.size() == 1
             ? first
             : fmt::format("{}; lost {} times and started again {} times in all", first, losses.size(), restarts);
}

/// Pumps the source into the odometry until one of them, or the monitor, ends it.
class Runner {
 public:
  /// `watched`: the reference by which a run ends that has diverged from it, or nullptr. `keeps_poses`: of the whole
  /// run.
  Runner(io::MeasurementSource& source, pipeline::Odometry& odometry, RunOutputs& outputs, RunMonitor& monitor,
         const Truth* watched, bool keeps_poses)
      : source_(source),
        odometry_(odometry),
        outputs_(outputs),
        monitor_(monitor),
        collector_(keeps_poses),
        feed_(monitor, source) {
    if (watched != nullptr) watch_.emplace(watched->trajectory, watched->positions_only);
    watched_ = watched;
    odometry_.add_observer(outputs_);
    odometry_.add_observer(collector_);
    odometry_.add_observer(feed_);
  }

  /// What ended it. A failure is kept as text: what was written so far is worth keeping.
  RunOutcome run() {
    RunOutcome outcome;
    contain(outcome, [&] { pump(outcome); });
    source_.conclude();
    if (const auto* first = odometry_.divergence()) {
      outcome.divergence = {first->t, first->reason + what_followed(odometry_.losses())};
    }
    outcome.truncated = source_.status() == io::InputStatus::truncated;
    outcome.tracking = odometry_.tracking();
    feed_.show();
    return outcome;
  }

  /// Gives the files their names, unless one of them could not be written in full.
  void close_outputs(RunOutcome& outcome) {
    contain(outcome, [&] {
      outputs_.raise();
      outputs_.close();
    });
  }

  const SummaryCollector& collector() const { return collector_; }
  bool bad_data() const { return bad_data_; }
  bool stage_failed() const { return stage_failed_; }
  /// Before the data were, by a DivergenceWatch.
  bool was_ended() const { return was_ended_; }
  /// Measurements that were read.
  std::int64_t sweeps() const { return sweeps_; }
  std::int64_t imu_samples() const { return imu_samples_; }

 private:
  template <class F>
  void contain(RunOutcome& outcome, F&& work) {
    try {
      work();
    } catch (const DataError& error) {
      if (!outcome.failure) outcome.failure = error.what();
      bad_data_ = true;
    } catch (...) {
      if (!outcome.failure) outcome.failure = fmt::format("a stage failed: {}", what_was_thrown());
      stage_failed_ = true;
    }
  }

  void pump(RunOutcome& outcome) {
    while (!(outcome.interrupted = monitor_.stop_requested())) {
      auto measurement = source_.next();
      if (!measurement) break;
      ++(std::holds_alternative<LidarPacket>(*measurement) ? sweeps_ : imu_samples_);
      odometry_.push(std::move(*measurement));
      outputs_.raise();
      feed_.after_measurement();
      if (odometry_.has_ended() || (outcome.divergence = watch())) return;
    }
    if (outcome.interrupted) return;
    odometry_.finish();
    outputs_.raise();
  }

  /// What ends the run when it has diverged from its reference.
  std::optional<std::pair<TimeNs, std::string>> watch() {
    if (!watch_) return std::nullopt;
    const auto& poses = collector_.poses();
    for (const StampedPose& pose : watched_->comparable(std::span(poses).subspan(compared_.size()))) {
      compared_.push_back(pose);
    }
    auto found = watch_->look(compared_);
    was_ended_ = found.has_value();
    if (found) found->second += "; the run was ended there";
    return found;
  }

  io::MeasurementSource& source_;
  pipeline::Odometry& odometry_;
  RunOutputs& outputs_;
  RunMonitor& monitor_;
  SummaryCollector collector_;
  ProgressFeed feed_;
  const Truth* watched_ = nullptr;
  std::vector<StampedPose> compared_;  ///< the poses so far, as the reference is to be compared with
  std::optional<DivergenceWatch> watch_;
  std::int64_t sweeps_ = 0, imu_samples_ = 0;
  bool bad_data_ = false, stage_failed_ = false, was_ended_ = false;
};

/// Whether the data, not the method, is to blame.
bool blames_data(const Summary& summary, const Runner& runner) {
  switch (summary.status) {
    case pipeline::RunStatus::truncated:
      return true;
    case pipeline::RunStatus::failed:
      return runner.bad_data() || (summary.updates == 0 && !runner.stage_failed());
    default:
      return false;
  }
}

void gather(Summary& summary, const pipeline::Odometry& odometry, const io::MeasurementSource& source) {
  if (odometry.initialisation()) {
    summary.initialisation = odometry.initialisation()->verdict;
    summary.start_doubt = odometry.initialisation()->doubt;
  }
  summary.notes = source.notes().verdicts;
  for (const std::string& warning : source.notes().warnings) summary.notes.push_back("warning: " + warning);
  for (const std::string& warning : odometry.stream().warnings()) summary.notes.push_back("warning: " + warning);
  summary.malformed_lidar = source.notes().malformed_lidar;
  summary.malformed_imu = source.notes().malformed_imu;
  summary.losses = odometry.losses();
  summary.monitor = odometry.monitor();
}

/// What the points scatter, against what the sensor file says.
void gather_noise(Summary& summary, const pipeline::RangeNoise& noise, const SensorModel& sensor) {
  constexpr double clearly = 1.5;
  summary.range_sigma = sensor.range_sigma;
  summary.range_sigma_seen = noise.range_sigma_seen();
  summary.noise_scale = noise.scale();
  if (!summary.range_sigma_seen) return;
  const double ratio = *summary.range_sigma_seen / sensor.range_sigma;
  if (ratio <= clearly && clearly * ratio >= 1) return;
  summary.notes.push_back(fmt::format("range noise seen {:.3f} m, sensor file says range_sigma {:.3g}",
                                      *summary.range_sigma_seen, sensor.range_sigma));
}

/// A run is worth keeping although its reference turns out not to fit.
void measure(Summary& summary, const std::vector<StampedPose>& poses, const Truth& reference) {
  try {
    summary.evaluation = evaluate_against(reference, poses, reference.options());
  } catch (const std::exception& error) {
    summary.evaluation_error = error.what();
  }
}

/// Whether a published sequence was read in full. Pre: it was read to its end.
std::vector<std::string> compare_counts(const RunOptions& options, const Runner& runner) {
  if (!options.published || options.section.start > 0 || options.section.duration) return {};
  return count_warnings(*options.published, runner.sweeps(), runner.imu_samples());
}

/// The end of data that were read to their end: a recording may hold other topics, which go on.
std::optional<TimeNs> last_arrived(const stream::MeasurementStream& stream) {
  return std::max(stream.last_point(), stream.last_imu());
}

/// Pre: the run has been judged.
/// `data_end`: a run is not silent after it, though the reference goes on. `was_ended`: by a DivergenceWatch.
void mark_failure(Summary& summary, const SummaryCollector& collector, const Truth& truth,
                  std::optional<TimeNs> data_end, bool was_ended) {
  const Trajectory& reference = truth.trajectory;
  if (reference.samples().empty()) return;
  const auto& poses = collector.poses();
  const TimeNs end = std::min(reference.samples().back().t, data_end.value_or(kTimeMax));
  // Nor is one that was ended when it diverged, for the rest of them.
  std::optional<TimeNs> other = collector.lost_at(was_ended ? std::min(end, poses.back().t) : end);
  const bool good = summary.status == pipeline::RunStatus::ok || summary.status == pipeline::RunStatus::degraded;
  if (!good && !poses.empty()) {
    // One that was lost by itself may have begun anew and gone on.
    const TimeNs end_of_good = summary.losses.empty() ? kTimeMax : summary.losses.front().t;
    other = std::min({other.value_or(kTimeMax), poses.back().t, end_of_good});
  }
  summary.failed_at = failed_after(truth.comparable(poses), reference, other, truth.positions_only);
}

/// The summary last: where it is, all is. Where the others cannot be written they make room for one that says so, and
/// this throws for them.
void write_texts(const std::filesystem::path& output, const std::string& resolved, const std::string& manifest,
                 Summary& summary) {
  std::exception_ptr failure;
  try {
    write_file(output / "resolved.yaml", resolved);
    write_file(output / "manifest.json", manifest);
  } catch (const DataError& error) {
    failure = std::current_exception();
    if (summary.status == pipeline::RunStatus::ok || summary.status == pipeline::RunStatus::degraded) {
      summary.status = pipeline::RunStatus::failed;
      summary.reason = error.what();
    }
    std::error_code ignored;
    std::filesystem::remove(output / "resolved.yaml", ignored);
  }
  write_file(output / "summary.json", to_json(summary));
  if (failure) std::rethrow_exception(failure);
}

}  // namespace

RunResult run(const RunOptions& options, const plugin::Catalog& catalog, RunMonitor& monitor,
              std::shared_ptr<spdlog::logger> log) {
  const Prepared prepared = prepare(options, catalog);
  const SensorModel& sensor = prepared.sensor.value.model;
  exec::Executor executor(options.threads);
  const BuildContext context{executor, sensor, std::move(log), options.order_seed};
  pipeline::Odometry odometry(prepared.pipeline.value, context, pipeline::build_stages(prepared.pipeline, context));
  refuse_to_overwrite_inputs(options);
  refuse_to_replace_strangers(options.output);
  const auto lock = lock_output(options.output);
  std::unique_ptr<RunOutputs> outputs = open_outputs(options, sensor);
  remove_stale(options);

  Manifest manifest;
  const auto source = open_source(options, prepared, manifest);

  notify(monitor, options, prepared);
  monitor.on_start(source->notes());
  const std::vector<std::string> told = source->notes().warnings;
  RunResult result;
  Summary& summary = result.summary;
  const auto start = Clock::now();
  const double cpu_start = process_cpu_seconds();
  const Truth* watched = options.stop_when_diverged && prepared.reference ? &*prepared.reference : nullptr;
  Runner runner(*source, odometry, *outputs, monitor, watched, prepared.reference.has_value());
  RunOutcome outcome = runner.run();
  const bool whole = !outcome.interrupted && !outcome.failure && !outcome.divergence;
  runner.collector().fill(summary, odometry.stream(), whole ? std::nullopt : source->end_time(),
                          to_ns(prepared.pipeline.value.limits.max_gap));
  if (!options.closed_loop) summary.end_to_end_m.reset();
  gather(summary, odometry, *source);
  gather_noise(summary, odometry.range_noise(), sensor);
  runner.close_outputs(outcome);
  outputs.reset();  // what could not be written makes room for what says so
  summary.cpu_s = process_cpu_seconds() - cpu_start;
  summary.wall_s = seconds_since(start);
  summary.peak_rss_mb = peak_rss_mb();
  if (prepared.reference) {
    measure(summary, runner.collector().poses(), *prepared.reference);
    const auto found =
        find_divergence(prepared.reference->comparable(runner.collector().poses()), prepared.reference->trajectory);
    if (found && (!outcome.divergence || found->first < outcome.divergence->first)) outcome.divergence = found;
  }
  judge(summary, outcome);
  if (prepared.reference) {
    const auto data_end = whole ? last_arrived(odometry.stream()) : source->end_time();
    mark_failure(summary, runner.collector(), *prepared.reference, data_end, runner.was_ended());
  }
  result.bad_data = blames_data(summary, runner);
  result.late_warnings = late_warnings(*source, told);
  for (const std::string& warning : odometry.stream().warnings()) result.late_warnings.push_back(warning);
  if (whole && !odometry.has_ended()) {
    for (const std::string& warning : compare_counts(options, runner)) {
      result.late_warnings.push_back(warning);
      summary.notes.push_back("warning: " + warning);
    }
  }

  write_texts(options.output, prepared.pipeline.resolved, to_json(manifest, options), summary);
  return result;
}

}  // namespace aslio::experiment
