#include "aslio/experiment/external_run.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <thread>

#include "aslio/core/errors.hpp"
#include "aslio/evaluation/report.hpp"
#include "aslio/experiment/family.hpp"
#include "aslio/experiment/measure.hpp"
#include "aslio/experiment/summary.hpp"
#include "aslio/experiment/truth.hpp"
#include "aslio/io/sensor_file.hpp"
#include "aslio/io/writers.hpp"
#include "aslio/plugin/registry.hpp"
#include "external_input.hpp"
#include "manifest.hpp"
#include "metrics_json.hpp"
#include "run_outputs.hpp"
#include "study_files.hpp"
#include "study_judge.hpp"
#include "study_process.hpp"

namespace aslio::experiment {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using pipeline::RunStatus;

constexpr double kLook = 0.02;                // between looks at the program [s]
constexpr double kSeen = 0.2;                 // a program that ends sooner has not been looked at often enough [s]
constexpr double kGrace = 2.0;                // for it to end after a stop [s]
constexpr double kLongest = 1e9;              // the caller has limits of its own [s]
constexpr TimeNs kLongestStep = 3 * kSecond;  // between poses that covers the data
constexpr const char* kInputFolder = ".input";
constexpr const char* kLog = "program.log";

/// The last line of a log that says anything. A progress bar ends its lines with a carriage return.
std::string last_line(const fs::path& log) {
  constexpr std::streamoff kTail = 4096;
  constexpr std::size_t kMost = 200;
  std::ifstream stream(log, std::ios::binary);
  stream.seekg(0, std::ios::end);
  stream.seekg(std::max<std::streamoff>(0, static_cast<std::streamoff>(stream.tellg()) - kTail));
  std::string text{std::istreambuf_iterator<char>(stream), {}};
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back())) != 0) text.pop_back();
  const std::size_t begin = text.find_last_of("\r\n");
  if (begin != std::string::npos) text.erase(0, begin + 1);
  if (text.size() <= kMost) return text;
  std::size_t end = kMost;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;  // not inside a character
  return text.substr(0, end) + "..";
}

/// What the program reads lies there; gone when the run ends, however that is.
class InputFolder {
 public:
  explicit InputFolder(fs::path folder) : folder_(std::move(folder)) { clear(); }
  ~InputFolder() { clear(); }
  InputFolder(const InputFolder&) = delete;
  InputFolder& operator=(const InputFolder&) = delete;
  const fs::path& path() const { return folder_; }

 private:
  void clear() const {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }
  fs::path folder_;
};

void set(ExternalSummary& s, RunStatus status, std::string reason) {
  s.status = status;
  s.reason = std::move(reason);
}

/// The longest step between poses that leaves nothing out [ns]: authors may give keyframes alone.
TimeNs longest_step(const std::vector<StampedPose>& poses) {
  std::vector<TimeNs> steps;
  for (std::size_t i = 1; i < poses.size(); ++i) steps.push_back(poses[i].t - poses[i - 1].t);
  if (steps.empty()) return kLongGap;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return std::clamp(3 * *middle, kLongGap, kLongestStep);
}

/// The share of [begin, end] that lies between poses at most longest_step() apart. The first second may be without.
double coverage_of(const std::vector<StampedPose>& poses, TimeNs begin, TimeNs end) {
  if (poses.empty() || end <= begin) return 0;
  const TimeNs step = longest_step(poses);
  TimeNs covered = 0;
  TimeNs last = std::max(begin, poses.front().t - kInitialisationGrace);
  for (const StampedPose& pose : poses) {
    const TimeNs t = std::min(pose.t, end);
    if (t > last && (t - last <= step || &pose == &poses.front())) covered += t - last;
    last = std::max(last, t);
  }
  if (end - last <= step) covered += std::max<TimeNs>(0, end - last);  // of one sweep behind the last pose
  return to_seconds(covered) / to_seconds(end - begin);
}

class ExternalRun {
 public:
  ExternalRun(const ExternalOptions& options, const std::function<bool()>& stop)
      : options_(options), stop_(stop), input_(options.output / kInputFolder) {
    const plugin::Catalog no_stages;
    sensor_ = io::load_sensor(options.dataset.sensor, no_stages);
    if (options.dataset.reference) truth_.emplace(load_truth(*options.dataset.reference, &sensor_.value));
  }

  ExternalSummary run() {
    fed_ = feed_recording(options_.dataset, sensor_.value, options_.method, input_.path(), stop_);
    note_input();
    fill_places();
    bool ran = !stop_();
    if (!ran) set(summary_, RunStatus::interrupted, "stopped from outside");
    if (ran && !options_.method.command.empty()) ran = run_program();
    if (ran && read_trajectory()) {
      write_trajectories();
      measure();
      judge();
    }
    write_texts();
    return std::move(summary_);
  }

 private:
  void note_input() {
    if (fed_.sweeps > 0) summary_.data_s = to_seconds(fed_.end - fed_.begin);
    summary_.notes = fed_.notes.verdicts;
    for (const std::string& warning : fed_.notes.warnings) warn(warning);
    if (options_.dataset.published && !options_.dataset.section.duration && options_.dataset.section.start == 0) {
      for (const std::string& warning : count_warnings(*options_.dataset.published, fed_.sweeps, fed_.imu_samples))
        warn(warning);
    }
  }

  void warn(const std::string& warning) { summary_.notes.push_back("warning: " + warning); }

  void fill_places() {
    places_ = {.bags = fed_.bags,
               .imu_topic = fed_.imu_topic,
               .lidar_topic = fed_.lidar_topic,
               .output = options_.output,
               .sensor = sensor_file(),
               .data = options_.data_name,
               .sequence = options_.sequence,
               .seed = fmt::to_string(options_.seed)};
  }

  /// That of the recording, or one that fits its copy.
  fs::path sensor_file() const {
    if (fed_.sensor.empty()) return fs::absolute(options_.dataset.sensor).lexically_normal();
    const fs::path file = input_.path() / "sensor.yaml";
    write_file(file, fed_.sensor);
    return file;
  }

  /// Of an earlier run, or of another program: it must not be taken for what this one writes.
  void remove_earlier() const {
    const fs::path file = trajectory_file();
    std::error_code ignored;
    if (file.string().starts_with(options_.output.string() + "/")) fs::remove(file, ignored);
  }

  std::string container() const { return fmt::format("aslio-{}", ::getpid()); }

  /// Its processes are not ours: they would live on.
  void end_container() const {
    if (options_.method.engine != "docker") return;
    try {
      ChildProcess child({.program = "docker", .arguments = {"docker", "kill", container()}, .log = "/dev/null"},
                         {.time_s = kGrace, .memory_mb = kLongest});
      while (!child.poll()) std::this_thread::sleep_for(std::chrono::duration<double>(kLook));
    } catch (const DataError&) {  // without docker there is none
    }
  }

  /// False: it did not do its work, and the summary says why.
  bool run_program() {
    remove_earlier();
    const auto begun = fs::file_time_type::clock::now();
    std::vector<fs::path> read = {places_.sensor.parent_path()};
    for (const fs::path& bag : fed_.bags) {
      read.push_back(bag.parent_path());
      std::error_code ignored;
      const fs::path real = fs::canonical(bag, ignored);  // a link must lead somewhere inside a container, too
      if (!real.empty()) read.push_back(real.parent_path());
    }
    const auto words =
        in_container(options_.method, filled_in(options_.method.command, places_), options_.output, read, container());
    const fs::path log = options_.output / kLog;
    std::optional<ChildEnd> end;
    try {
      ChildProcess child(
          {.program = words.front(), .arguments = words, .log = log, .folder = options_.output, .adopts = true},
          {.time_s = kLongest, .memory_mb = kLongest});
      end = wait_for(child);
    } catch (const DataError& error) {
      set(summary_, RunStatus::failed,
          fmt::format("{}; a program is named by its path, or found in PATH", error.what()));
      return false;
    }
    if (!end) {
      end_container();
      set(summary_, RunStatus::interrupted, "stopped from outside");
      return false;
    }
    summary_.wall_s = end->wall_s;
    // The processes of a container of docker are not ours.
    if (options_.method.engine != "docker") {
      summary_.cpu_s = end->cpu_s;
      if (end->wall_s > kSeen) summary_.peak_rss_mb = end->peak_rss_mb;
    } else {
      summary_.notes.emplace_back("CPU time and memory inside a container of docker are not measured");
    }
    const auto& good = options_.method.exit_codes;
    if (end->cause == ChildEnd::Cause::exit && std::find(good.begin(), good.end(), end->code) != good.end()) {
      return require_new(begun);
    }
    const std::string last = last_line(log);
    const std::string how = end->cause == ChildEnd::Cause::signal ? exit_text(*end, log)
                                                                  : fmt::format("ended with exit code {}", end->code);
    set(summary_, RunStatus::failed,
        fmt::format("{}: {}{}", words.front(), how,
                    last.empty() ? "; it said nothing" : fmt::format("; its last line: {}", last)));
    return false;
  }

  /// False: the trajectory is older than the run.
  bool require_new(fs::file_time_type begun) {
    const fs::path file = trajectory_file();
    std::error_code error;
    const auto written = fs::last_write_time(file, error);
    if (error || written + std::chrono::seconds(2) >= begun) return true;  // file systems have coarse clocks
    set(summary_, RunStatus::failed,
        fmt::format("{}: is older than the run: the program ended well, and has not written it", file.string()));
    return false;
  }

  /// Nothing: it was stopped from outside.
  std::optional<ChildEnd> wait_for(ChildProcess& child) const {
    while (true) {
      auto end = child.poll();
      if (stop_()) {
        if (end) return std::nullopt;
        break;
      }
      if (end) return end;
      std::this_thread::sleep_for(std::chrono::duration<double>(kLook));
    }
    child.interrupt();
    const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(kGrace);
    while (!child.poll() && std::chrono::steady_clock::now() < until) {
      std::this_thread::sleep_for(std::chrono::duration<double>(kLook));
    }
    return std::nullopt;
  }

  fs::path trajectory_file() const {
    const fs::path named = filled_in(options_.method.trajectory, places_);
    return named.is_absolute() ? named : options_.output / named;
  }

  bool read_trajectory() {
    const fs::path file = trajectory_file();
    std::error_code ignored;
    if (!fs::exists(file, ignored)) {
      set(summary_, RunStatus::failed,
          fmt::format("there is no trajectory {}{}", file.string(),
                      options_.method.command.empty() ? "" : ": the program ended well, and has not written it"));
      return false;
    }
    try {
      io::ReferenceSpec spec = io::load_reference_spec(file, trajectory_keys());
      if (spec.format == io::ReferenceFormat::automatic) spec.format = options_.method.format;
      const Truth estimate = load_truth(spec, &sensor_.value);
      if (estimate.positions_only) {
        throw DataError(
            fmt::format("{}: holds positions alone, or an orientation that never changes: a trajectory needs "
                        "orientations. Where it has "
                        "them, say `trajectory_set: [positions_only=no]`",
                        file.string()));
      }
      for (const std::string& warning : estimate.warnings) warn(warning);
      poses_.assign(estimate.trajectory.samples().begin(), estimate.trajectory.samples().end());
      for (StampedPose& pose : poses_) pose.T.p += estimate.origin;
    } catch (const std::exception& error) {
      set(summary_, RunStatus::failed, error.what());
      return false;
    }
    if (poses_.empty()) {
      set(summary_, RunStatus::failed, fmt::format("{}: holds no pose", file.string()));
      return false;
    }
    return true;
  }

  /// Keys of the file of poses; those that are written out go before `frame`.
  std::vector<std::string> trajectory_keys() const {
    std::vector<std::string> keys;
    bool placed = false;
    for (const std::string& written : options_.method.trajectory_set) {
      std::string key = filled_in(written, places_);
      placed =
          placed || key.starts_with("frame=") || key.starts_with("T_imu_reference") || key.starts_with("lever_arm=");
      constexpr std::string_view kTimes = "times=";
      if (key.starts_with(kTimes) && fs::path(key.substr(kTimes.size())).is_relative()) {
        key = std::string(kTimes) + (options_.output / key.substr(kTimes.size())).string();
      }
      keys.push_back(std::move(key));
    }
    if (!placed) keys.insert(keys.begin(), "frame=" + options_.method.frame);
    return keys;
  }

  void write_trajectories() const {
    io::write_tum(options_.output / "trajectory.tum", poses_);
    std::vector<StampedPose> lidar = poses_;
    for (StampedPose& pose : lidar) pose.T = pose.T * sensor_.value.model.T_imu_lidar;
    io::write_tum(options_.output / "trajectory_lidar.tum", lidar);
  }

  void measure() {
    summary_.poses = poses_.size();
    summary_.path_length_m = Trajectory(poses_).path_length();
    if (fed_.sweeps > 0) summary_.coverage = coverage_of(poses_, fed_.begin, fed_.end);
    if (options_.dataset.closed_loop) {
      summary_.end_to_end_m = (poses_.back().T.p - poses_.front().T.p).norm();
    }
    if (!truth_) return;
    try {
      summary_.evaluation = evaluate_against(*truth_, poses_, truth_->options());
    } catch (const std::exception& error) {
      summary_.evaluation_error = error.what();
    }
  }

  void judge() {
    std::optional<std::pair<TimeNs, std::string>> diverged;
    if (truth_) diverged = find_divergence(truth_->comparable(poses_), truth_->trajectory);
    if (stop_()) {
      set(summary_, RunStatus::interrupted, "stopped from outside");
    } else if (fed_.sweeps == 0) {
      set(summary_, RunStatus::failed, "the recording has no sweep of the LiDAR");
      summary_.bad_data = true;
    } else if (diverged) {
      set(summary_, RunStatus::diverged, diverged->second);
    } else if (fed_.truncated) {
      set(summary_, RunStatus::truncated, "the input ends inside its last record");
      summary_.bad_data = true;
    } else if (poses_.front().t > fed_.end || poses_.back().t < fed_.begin) {
      set(summary_, RunStatus::failed,
          fmt::format(
              "the poses have times {:.3f} to {:.3f} s, the recording {:.3f} to {:.3f} s: another clock or unit; "
              "`trajectory_set` takes time_unit and time_offset",
              to_seconds(poses_.front().t), to_seconds(poses_.back().t), to_seconds(fed_.begin), to_seconds(fed_.end)));
    } else if (summary_.coverage < kMinCoverage) {
      set(summary_, RunStatus::failed,
          fmt::format("poses cover {:.1f} % of the data, less than {:.0f} %", 100 * summary_.coverage,
                      100 * kMinCoverage));
    } else if (const std::string off = off_reference(summary_.evaluation); !off.empty()) {
      set(summary_, RunStatus::degraded, off);
    } else {
      set(summary_, RunStatus::ok, "");
    }
    if (!truth_ || truth_->trajectory.samples().empty()) return;
    std::optional<TimeNs> silent;
    if (summary_.status == RunStatus::failed) silent = poses_.back().t;
    summary_.failed_at = failed_after(truth_->comparable(poses_), truth_->trajectory, silent, truth_->positions_only);
  }

  void write_texts() const {
    Manifest manifest;
    manifest.program_sha256 = io::input_digest("/proc/self/exe");
    manifest.sensor_sha256 = io::input_digest(options_.dataset.sensor);
    manifest.sensor_resolved = sensor_.resolved;
    manifest.input_sha256 = io::input_digest(options_.dataset.inputs);
    if (truth_) {
      manifest.reference_sha256 = io::input_digest(options_.dataset.reference->file);
      manifest.reference_resolved = io::resolved_text(truth_->spec);
    }
    RunOptions run;
    run.pipeline = options_.method.command.empty() ? fs::path(options_.method.trajectory)
                                                   : fs::path(options_.method.command.front());
    run.input = options_.dataset.inputs.front();
    run.more_inputs.assign(options_.dataset.inputs.begin() + 1, options_.dataset.inputs.end());
    run.sensor = options_.dataset.sensor;
    run.dataset = options_.dataset.file;
    run.published = options_.dataset.published;
    run.reference = options_.dataset.reference;
    run.section = options_.dataset.section;
    run.order_seed = options_.seed;
    run.command_line = options_.command_line;
    for (const fs::path& file : files_of(options_.method, places_)) {
      if (manifest.pipeline_sha256.empty()) manifest.pipeline_sha256 = io::input_digest(file);
    }
    write_file(options_.output / "resolved.yaml", resolved_text(options_.method));
    write_file(options_.output / "manifest.json", to_json(manifest, run));
    write_file(options_.output / "summary.json", to_json(summary_));
  }

  const ExternalOptions& options_;
  const std::function<bool()>& stop_;
  InputFolder input_;
  config::Loaded<io::SensorConfig> sensor_;
  std::optional<Truth> truth_;
  FedRecording fed_;
  ExternalPlaces places_;
  std::vector<StampedPose> poses_;  ///< of the IMU
  ExternalSummary summary_;
};

Json or_null(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

}  // namespace

std::string to_json(const ExternalSummary& s) {
  Json out = {{"status", pipeline::name(s.status)},
              {"reason", s.reason},
              {"external", true},
              {"coverage", s.coverage},
              {"poses", s.poses},
              {"path_length_m", s.path_length_m},
              {"cpu_s", or_null(s.cpu_s)},
              {"wall_s", or_null(s.wall_s)},
              {"data_s", s.data_s},
              {"peak_rss_mb", or_null(s.peak_rss_mb)},
              {"notes", s.notes},
              {"metrics", metrics_json(s.evaluation, s.end_to_end_m, s.failed_at, s.evaluation_error)}};
  if (s.evaluation) out["evaluation"] = evaluation::to_json(*s.evaluation);
  return out.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

ExternalSummary run_external(const ExternalOptions& options, const std::function<bool()>& stop) {
  ExternalOptions absolute = options;
  absolute.output = fs::absolute(options.output).lexically_normal();
  if (!absolute.output.has_filename()) absolute.output = absolute.output.parent_path();
  create_folder(absolute.output);
  const auto lock = lock_output(absolute.output);
  for (const std::string& file : files_of_a_run()) {
    if (file == "method.yaml" || file == "log.txt") continue;  // of the study that called
    std::error_code ignored;
    fs::remove(absolute.output / file, ignored);
  }
  return ExternalRun(absolute, stop).run();
}

}  // namespace aslio::experiment
