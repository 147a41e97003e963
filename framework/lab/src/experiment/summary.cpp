#include "aslio/experiment/summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <numeric>

#include "aslio/evaluation/report.hpp"
#include "aslio/experiment/measure.hpp"
#include "metrics_json.hpp"

namespace aslio::experiment {

namespace {

using Json = nlohmann::ordered_json;
using pipeline::RunStatus;

using StatusCounts = std::array<std::uint64_t, 6>;

std::uint64_t sum(const StatusCounts& counts) {
  return std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
}

std::uint64_t count(const StatusCounts& counts, UpdateStatus status) {
  return counts[static_cast<std::size_t>(status)];
}

constexpr double kMaxRefused = 0.095;  // [s]: a sweep of 0.1 s, not a few windows of 8 ms at an edge of the map
constexpr std::array kWeak = {UpdateStatus::degenerate, UpdateStatus::few_matches, UpdateStatus::non_finite};

void append(std::string& text, std::string_view what, std::string_view separator) {
  if (!text.empty() && !what.empty()) text += separator;
  text += what;
}

/// "3 few_matches, 1 non_finite".
std::string by_status(const StatusCounts& counts) {
  std::string text;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (counts[i] == 0) continue;
    append(text, fmt::format("{} {}", counts[i], pipeline::name(static_cast<UpdateStatus>(i))), ", ");
  }
  return text;
}

/// "7 of 273 updates were refused (7 few_matches)"; empty when none was.
std::string refused(const Summary& s) {
  const std::uint64_t total = sum(s.refused_by_status);
  if (total == 0) return {};
  return fmt::format("{} of {} updates were refused ({})", total, s.updates, by_status(s.refused_by_status));
}

std::string none_accepted(const Summary& s) {
  const std::string why =
      s.matchable_points == 0 ? "no point passed the samplers (range limits?)" : by_status(s.updates_by_status);
  return fmt::format("none of {} updates was accepted: {}", s.updates, why);
}

/// What makes a run `degraded`; empty: nothing.
std::string shortcomings(const Summary& s, const std::string& odd) {
  std::string text;
  const bool broke = s.refused_s > 0 && s.refused_by_status[static_cast<std::size_t>(UpdateStatus::non_finite)] > 0;
  if (s.refused_s > kMaxRefused || broke) append(text, refused(s), "; ");
  if (s.weak_share > kMaxWeakShare) {
    append(text,
           fmt::format("{}: {:.0f} % of the time, more than {:.0f} %", weak_updates(s), 100 * s.weak_share,
                       100 * kMaxWeakShare),
           "; ");
  }
  append(text, s.start_doubt, "; ");
  append(text, off_reference(s.evaluation), "; ");
  append(text, s.monitor.implausible, "; ");
  append(text, odd, "; ");
  return text;
}

template <class T>
Json or_null(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json counts(const Summary& s) {
  const stream::StreamCounters& c = s.counters;
  Json out = {{"packets", c.packets},
              {"empty_packets", c.empty_packets},
              {"duplicate_packets", c.duplicate_packets},
              {"packet_time_jumps", c.packet_time_jumps},
              {"points", c.points},
              {"points_invalid", c.points_invalid},
              {"points_beyond_lines", c.points_beyond_lines},
              {"points_stray", c.points_stray},
              {"points_before_start", c.points_before_start},
              {"points_late", c.points_late},
              {"points_reordered", c.points_reordered},
              {"imu", c.imu},
              {"imu_invalid", c.imu_invalid},
              {"imu_duplicate", c.imu_duplicate},
              {"imu_late", c.imu_late},
              {"imu_reordered", c.imu_reordered},
              {"imu_time_jumps", c.imu_time_jumps},
              {"imu_gaps", c.imu_gaps},
              {"imu_spikes", c.imu_found.spikes},
              {"imu_gyro_clipped", c.imu_found.gyro_clipped},
              {"imu_acc_clipped", c.imu_found.acc_clipped},
              {"imu_stuck", c.imu_found.stuck},
              {"imu_zero", c.imu_found.zero},
              {"clock_jumps", c.clock_jumps},
              {"malformed_messages", s.malformed_lidar + s.malformed_imu}};
  for (std::size_t i = 0; i < s.updates_by_status.size(); ++i) {
    const auto name = pipeline::name(static_cast<UpdateStatus>(i));
    out[fmt::format("updates_{}", name)] = s.updates_by_status[i];
  }
  out["updates_refused"] = sum(s.refused_by_status);
  out["updates_without_view"] = s.updates_without_view;
  out["updates_bridged"] = s.updates_bridged;
  out["gyro_bias_steps"] = s.gyro_bias_steps;
  return out;
}

/// Row by row; null what is held fixed.
template <class T>
Json numbers(const T& values, const T& sigma) {
  Json out = Json::array();
  for (Eigen::Index row = 0; row < values.rows(); ++row)
    for (Eigen::Index column = 0; column < values.cols(); ++column)
      out.push_back(sigma(row, column) > 0.0 ? Json(values(row, column)) : Json(nullptr));
  return out;
}

template <class T>
void add_known(Json& out, const char* key, const char* sigma, const std::optional<Estimate<T>>& known) {
  out[key] = known ? numbers(known->value, known->sigma) : Json(nullptr);
  out[sigma] = known ? numbers(known->sigma, known->sigma) : Json(nullptr);
}

Json calibration(const Summary& s) {
  if (!s.calibration) return nullptr;
  const Calibration& c = *s.calibration;
  Json out = {{"t_ns", c.t}, {"text", to_text(c)}};
  add_known(out, "gyro_bias_rad_s", "gyro_bias_sigma_rad_s", c.gyro_bias);
  add_known(out, "acc_bias_mps2", "acc_bias_sigma_mps2", c.acc_bias);
  add_known(out, "gyro_sensitivity", "gyro_sensitivity_sigma", c.gyro_sensitivity);
  out["imu_delay_s"] = c.imu_delay ? Json(c.imu_delay->value) : Json(nullptr);
  out["imu_delay_sigma_s"] = c.imu_delay ? Json(c.imu_delay->sigma) : Json(nullptr);
  add_known(out, "extrinsic_turn_rad", "extrinsic_turn_sigma_rad", c.extrinsic_turn);
  add_known(out, "extrinsic_shift_m", "extrinsic_shift_sigma_m", c.extrinsic_shift);
  add_known(out, "acc_scale", "acc_scale_sigma", c.acc_scale);
  out["T_imu_lidar"] = nullptr;  // as a sensor file has it
  if (c.extrinsic_turn) {
    const Pose& T = c.T_imu_lidar;
    out["T_imu_lidar"] = {{"translation", numbers(T.p, Vec3(Vec3::Ones()))},
                          {"rotation", numbers(T.R, Mat3(Mat3::Ones()))}};
  }
  return out;
}

/// What was not taken as it came and is more than the peculiarity of a sensor: duplicates, disorder and points that
/// the decoder drops lose nothing, and neither do fewer than one in a thousand.
std::string anomalies(const Summary& s) {
  std::string text;
  const auto add = [&text](const std::string& what) { text += (text.empty() ? "" : ", ") + what; };
  const auto dropped = [&add](std::uint64_t count, std::uint64_t accepted, std::string_view what) {
    if (count * 1000 > accepted) add(fmt::format("{} {} dropped", count, what));
  };
  const stream::StreamCounters& c = s.counters;
  dropped(s.malformed_lidar, c.packets, "malformed LiDAR messages");
  if (c.imu > 0) dropped(s.malformed_imu, c.imu, "malformed IMU messages");  // where they are taken at all
  dropped(c.packet_time_jumps, c.packets, "LiDAR messages with an implausible stamp");
  dropped(c.points_stray, c.points, "points with a stray time");
  dropped(c.points_late, c.points, "points that arrived too late");
  dropped(c.imu_invalid, c.imu, "IMU samples that are not finite");
  dropped(c.imu_late, c.imu, "IMU samples that arrived too late");
  dropped(c.imu_time_jumps, c.imu, "IMU samples with an implausible stamp");
  dropped(c.imu_found.spikes, c.imu, "IMU samples that are spikes");
  const auto lasts = [&](std::uint64_t samples, std::string_view what) {
    const double seconds = static_cast<double>(samples) * s.imu_period_s;
    if (seconds > to_seconds(kDoubtedImu)) add(fmt::format("{} for {:.2f} s ({} samples)", what, seconds, samples));
  };
  lasts(c.imu_found.gyro_clipped, "gyroscope at the end of its range");
  lasts(c.imu_found.acc_clipped, "accelerometer at the end of its range");
  lasts(c.imu_found.stuck, "IMU stuck at one reading");
  lasts(c.imu_found.zero, "IMU dead, all readings zero");
  if (c.points_beyond_lines * 20 > c.points + c.points_beyond_lines)
    add(fmt::format("{} points of a scan line beyond `scan_lines` of the sensor file dropped", c.points_beyond_lines));
  if (s.longest_imu_gap_s > to_seconds(kLongGap)) add(fmt::format("{:.2f} s without IMU data", s.longest_imu_gap_s));
  if (s.longest_lidar_gap_s > to_seconds(kLongGap)) add(fmt::format("{:.2f} s without points", s.longest_lidar_gap_s));
  return text;
}

std::string no_state(const Summary& s) {
  if (s.counters.points == 0) return "no point with a usable coordinate and time has arrived";
  if (s.counters.imu == 0) return "no IMU sample has arrived";
  return "no state was found: the IMU data does not cover the time that initialisation needs";
}

void set(Summary& s, RunStatus status, std::string reason) {
  s.status = status;
  s.reason = std::move(reason);
}

}  // namespace

std::string to_json(const Summary& s) {
  Json out = {{"status", pipeline::name(s.status)}, {"reason", s.reason}};
  if (s.moment) out["moment_ns"] = *s.moment;
  out["losses"] = Json::array();
  for (const pipeline::Divergence& loss : s.losses) {
    out["losses"].push_back({{"t_ns", loss.t}, {"reason", loss.reason}, {"restarted_ns", or_null(loss.restarted)}});
  }
  out["coverage"] = s.coverage;
  out["counts"] = counts(s);
  out["monitor"] = {{"alarms", s.monitor.alarms},
                    {"implausible", s.monitor.implausible},
                    {"unbound", pipeline::unbound_text(s.monitor)}};
  out["updates"] = s.updates;
  out["weak_updates"] = weak_updates(s);
  out["weak_share"] = s.weak_share;
  out["rate_hz"] = nullptr;
  if (s.rate_hz) out["rate_hz"] = {{"min", s.rate_hz->min}, {"median", s.rate_hz->median}, {"max", s.rate_hz->max}};
  out["path_length_m"] = s.path_length_m;
  out["cpu_s"] = s.cpu_s;
  out["wall_s"] = s.wall_s;
  out["data_s"] = s.data_s;
  out["peak_rss_mb"] = s.peak_rss_mb;
  out["longest_imu_gap_s"] = s.longest_imu_gap_s;
  out["longest_lidar_gap_s"] = s.longest_lidar_gap_s;
  out["range_sigma"] = s.range_sigma;
  out["range_sigma_seen"] = or_null(s.range_sigma_seen);
  out["noise_scale"] = s.noise_scale;
  out["initialisation"] = s.initialisation;
  out["notes"] = s.notes;
  out["calibration"] = calibration(s);
  out["metrics"] = metrics_json(s.evaluation, s.end_to_end_m, s.failed_at, s.evaluation_error);
  if (s.evaluation) out["evaluation"] = evaluation::to_json(*s.evaluation);
  return out.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

bool is_weak(UpdateStatus status) { return std::find(kWeak.begin(), kWeak.end(), status) != kWeak.end(); }

std::string weak_updates(const Summary& s) {
  std::string text;
  for (const UpdateStatus status : kWeak) {
    const std::uint64_t n = count(s.updates_by_status, status);
    if (n > 0) append(text, fmt::format("{} of {} updates {}", n, s.updates, pipeline::name(status)), ", ");
  }
  return text;
}

void judge(Summary& s, const RunOutcome& outcome) {
  if (outcome.interrupted) {
    set(s, RunStatus::interrupted, fmt::format("stopped from outside after {:.2f} s of data", s.data_s));
  } else if (outcome.failure) {
    set(s, RunStatus::failed, *outcome.failure);
  } else if (outcome.divergence) {
    s.moment = outcome.divergence->first;
    set(s, RunStatus::diverged, outcome.divergence->second);
  } else if (outcome.truncated) {
    set(s, RunStatus::truncated, "the input ends inside its last record; the complete records were used");
  } else if (s.updates == 0) {
    set(s, RunStatus::failed, no_state(s));
  } else if (s.accepted == 0) {
    set(s, RunStatus::failed, none_accepted(s));
  } else if (outcome.tracking == pipeline::TrackingStatus::lost) {
    set(s, RunStatus::failed, "tracking was lost at the end");
  } else if (s.coverage < kMinCoverage) {
    set(s, RunStatus::failed,
        fmt::format("updates cover {:.1f} % of the data, less than {:.0f} %{}", 100 * s.coverage, 100 * kMinCoverage,
                    refused(s).empty() ? "" : "; " + refused(s)));
  } else if (const std::string shortfall = shortcomings(s, anomalies(s)); !shortfall.empty()) {
    set(s, RunStatus::degraded, shortfall);
  } else {
    set(s, RunStatus::ok, "");
  }
}

}  // namespace aslio::experiment
