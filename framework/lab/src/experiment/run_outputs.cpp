#include "run_outputs.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <iterator>
#include <string_view>
#include <utility>
#include <vector>

#include "aslio/core/errors.hpp"

namespace aslio::experiment {

namespace {

/// Every file of the output folder.
constexpr std::array<std::string_view, 8> kNames = {"trajectory.tum", "trajectory_lidar.tum", "trajectory_dense.tum",
                                                    "updates.csv",    "timings.csv",          "resolved.yaml",
                                                    "manifest.json",  "summary.json"};

bool finite(const NavState& state) { return state.R.allFinite() && state.p.allFinite(); }

/// Poses in strictly increasing time, whatever an estimator emits.
struct Appender {
  io::AtomicFile& file;
  TimeNs& last;
  void add(const NavState& state) {
    if (state.t <= last || !finite(state)) return;
    file.write(io::tum_line({state.t, state.pose()}));
    last = state.t;
  }
};

}  // namespace

std::string updates_header() {
  std::string line = "t_ns,window_begin_ns,status,n_fresh,n_history,sod";
  for (std::size_t i = 0; i < kMaxLayers; ++i) fmt::format_to(std::back_inserter(line), ",layer_{}", i);
  line += ",seg_time,shift_time_s,echo,iterations,n_matches";
  for (int i = 1; i <= 6; ++i) fmt::format_to(std::back_inserter(line), ",eig_{}", i);
  return line +
         ",digest,extended,partial,n_fresh_matches,n_history_matches,residual_rms_m,inserted,tracking,gyro_rms_rad_s"
         ",prior_x,prior_y,prior_z,prior_qx,prior_qy,prior_qz,prior_qw,segment"
         ",nis,matched_share,fit_rise,nis_rise,match_loss,overlap_loss,velocity_pull_mps2,turn_pull_rad_s"
         ",velocity_pull_rise,turn_pull_rise,misfit,gyro_mismatch,mount,view_change,view_jump,unexplained,alarm\n";
}

std::string updates_line(const pipeline::UpdateRecord& record) {
  const WindowPlan& plan = record.plan;
  std::string line;
  const auto out = std::back_inserter(line);
  fmt::format_to(out, "{},{},{},{},{},", plan.end, plan.history_begin, pipeline::name(record.status), record.n_fresh,
                 record.n_history);
  if (record.overlap.value) fmt::format_to(out, "{}", *record.overlap.value);
  for (const std::uint32_t points : record.overlap.layers) fmt::format_to(out, ",{}", points);
  fmt::format_to(out, ",{},{},{},{},{}", plan.seg_time, plan.shift_time, plan.echo, record.iterations,
                 record.n_matches);
  // Without a solution there is no information to take eigenvalues of, and zeros would pass for a measurement.
  const bool solved = record.update->accepted;
  for (const double eigenvalue : record.spectrum) {
    line += ',';
    if (solved) fmt::format_to(out, "{}", eigenvalue);
  }
  fmt::format_to(out, ",{:016x},{},{},{},{},", record.digest, plan.extended ? 1 : 0, plan.partial ? 1 : 0,
                 record.update->fresh_matches, record.update->history_matches);
  if (solved) fmt::format_to(out, "{}", record.residual_rms);
  fmt::format_to(out, ",{},{},", record.inserted.inserted, pipeline::name(record.tracking));
  if (std::isfinite(record.gyro_rms)) fmt::format_to(out, "{}", record.gyro_rms);
  const NavState& prior = record.update->prior;
  const bool known = finite(prior);
  Eigen::Quaterniond q(prior.R);
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  for (const double value : {prior.p.x(), prior.p.y(), prior.p.z(), q.x(), q.y(), q.z(), q.w()}) {
    line += ',';
    if (known) fmt::format_to(out, "{}", value);
  }
  const pipeline::MonitorSignals& m = record.monitor;
  fmt::format_to(out, ",{}", record.segment);
  for (const double value : {m.nis, m.matched, m.fit_rise, m.nis_rise, m.match_loss, m.overlap_loss, m.velocity_pull,
                             m.turn_pull, m.velocity_pull_rise, m.turn_pull_rise, m.misfit, m.gyro_mismatch, m.mount,
                             m.view_change, m.view_jump, m.unexplained}) {
    line += ',';
    if (std::isfinite(value)) fmt::format_to(out, "{:.5g}", value);
  }
  fmt::format_to(out, ",{}\n", m.alarm ? 1 : 0);
  return line;
}

std::filesystem::path map_path(const std::filesystem::path& first, std::uint32_t finished) {
  if (finished == 0) return first;
  std::filesystem::path path = first;
  return path.replace_filename(
      fmt::format("{}.segment_{}{}", first.stem().string(), finished + 1, first.extension().string()));
}

std::string timings_header() {
  return "t_ns,window_s,predict_s,deskew_s,sample_s,associate_s,solve_s,overlap_s,insert_s\n";
}

std::string timings_line(const pipeline::UpdateRecord& record) {
  const StageTimes& s = record.times;
  return fmt::format("{},{},{},{},{},{},{},{},{}\n", record.plan.end, s.window, s.predict, s.deskew, s.sample,
                     s.associate, s.solve, s.overlap, s.insert);
}

RunOutputs::RunOutputs(const RunOptions& options, const SensorModel& sensor)
    : T_imu_lidar_(sensor.T_imu_lidar),
      trajectory_(options.output / "trajectory.tum"),
      trajectory_lidar_(options.output / "trajectory_lidar.tum"),
      updates_(options.output / "updates.csv"),
      timings_(options.output / "timings.csv") {
  updates_.write(updates_header());
  timings_.write(timings_header());
  if (options.dense) dense_ = std::make_unique<io::AtomicFile>(options.output / "trajectory_dense.tum");
  map_path_ = options.save_map;
  if (map_path_) map_ = io::open_map_writer(*map_path_);
}

void RunOutputs::on_update(const pipeline::UpdateRecord& record) {
  if (failure_) return;
  try {
    write(record);
  } catch (...) {
    failure_ = std::current_exception();
  }
}

void RunOutputs::write(const pipeline::UpdateRecord& record) {
  updates_.write(updates_line(record));
  timings_.write(timings_line(record));
  if (finite(record.state)) {
    const Pose T_W_I = record.state.pose();
    trajectory_.write(io::tum_line({record.plan.end, T_W_I}));
    trajectory_lidar_.write(io::tum_line({record.plan.end, T_W_I * T_imu_lidar_}));
  }
  if (dense_) {
    Appender dense{*dense_, last_dense_};
    for (const NavState& state : record.update->states) dense.add(state);
    dense.add(record.state);
  }
  if (map_ && record.segment != segment_) {
    map_->close();
    segment_ = record.segment;
    map_ = io::open_map_writer(map_path(*map_path_, ++maps_));
  }
  if (map_ && record.update->insert) {
    for (const WorldPoint& p : record.update->points(PointUse::map)) map_->add(p.p_W.cast<float>(), p.intensity);
  }
}

void RunOutputs::raise() const {
  if (failure_) std::rethrow_exception(failure_);
}

void RunOutputs::close() {
  for (io::AtomicFile* file : {&trajectory_, &trajectory_lidar_, &updates_, &timings_, dense_.get()}) {
    if (file != nullptr) file->close();
  }
  if (map_) map_->close();
}

void refuse_to_overwrite_inputs(const RunOptions& options) {
  std::vector<std::pair<std::string_view, std::filesystem::path>> inputs = {
      {"the pipeline", options.pipeline}, {"--input", options.input}, {"--sensor", options.sensor}};
  for (const auto& more : options.more_inputs) inputs.emplace_back("--input", more);
  if (options.reference) inputs.emplace_back("--reference", options.reference->file);
  if (options.dataset) inputs.emplace_back("--dataset", *options.dataset);
  for (const PluginFile& plugin : options.plugins) inputs.emplace_back("--plugin", plugin.path);
  std::vector<std::pair<std::string_view, std::filesystem::path>> outputs;
  for (const std::string_view name : kNames) outputs.emplace_back("--output", options.output / name);
  if (options.save_map) outputs.emplace_back("--save-map", *options.save_map);
  const auto canonical = [](const std::filesystem::path& path) {
    std::error_code ignored;
    return std::filesystem::weakly_canonical(path, ignored);
  };
  for (const auto& [written_by, output] : outputs) {
    for (const auto& [read_by, input] : inputs) {
      std::error_code ignored;
      if (canonical(output) != canonical(input) && !std::filesystem::equivalent(output, input, ignored)) continue;
      throw ConfigError(fmt::format("{}: {} would be overwritten, and {} reads it; name another place", written_by,
                                    input.string(), read_by));
    }
  }
}

void refuse_to_replace_strangers(const std::filesystem::path& output) {
  std::error_code ignored;
  // A run opens both files before it reads anything, and leaves both however it ends.
  const auto poses = output / "trajectory.tum";
  if (!std::filesystem::exists(poses, ignored) || std::filesystem::exists(output / "updates.csv", ignored)) return;
  throw ConfigError(
      fmt::format("--output {}: its trajectory.tum is not from a run of this program (it has no updates.csv) and would "
                  "be replaced; name another folder, or move the file",
                  output.string()));
}

std::optional<FolderLock> lock_output(const std::filesystem::path& output) {
  std::error_code error;
  std::filesystem::create_directories(output, error);
  std::error_code ignored;
  if (!std::filesystem::is_directory(output, ignored)) {
    throw ConfigError(fmt::format("--output {}: {}; name a folder that exists or can be created", output.string(),
                                  error ? error.message() : "it is not a folder"));
  }
  try {
    if (auto lock = FolderLock::take(output, true)) return lock;
  } catch (const DataError&) {
    return std::nullopt;  // a file system without locks, or a folder that may be written and not read: runs go there
  }
  throw ConfigError(fmt::format(
      "--output {}: another `aslio run` is at work there; wait for it, or name another folder", output.string()));
}

std::unique_ptr<RunOutputs> open_outputs(const RunOptions& options, const SensorModel& sensor) {
  const std::string place = fmt::format("--output {}", options.output.string());
  try {
    return std::make_unique<RunOutputs>(options, sensor);
  } catch (const DataError& failure) {
    throw ConfigError(fmt::format("{}: {}", place, failure.what()));
  }
}

void remove_stale(const RunOptions& options) {
  std::error_code ignored;
  for (const std::string_view name : kNames) std::filesystem::remove(options.output / name, ignored);
  for (std::uint32_t k = 1; options.save_map && std::filesystem::remove(map_path(*options.save_map, k), ignored);) ++k;
}

void write_file(const std::filesystem::path& path, const std::string& text) {
  io::AtomicFile file(path);
  file.write(text);
  file.close_durably();
}

}  // namespace aslio::experiment
