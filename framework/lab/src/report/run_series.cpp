#include "aslio/report/run_series.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "aslio/core/angles.hpp"
#include "aslio/core/csv.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/evaluation/evaluation.hpp"
#include "aslio/experiment/dataset.hpp"
#include "aslio/experiment/measure.hpp"
#include "aslio/experiment/truth.hpp"
#include "aslio/io/json.hpp"
#include "aslio/io/markup.hpp"
#include "aslio/io/writers.hpp"
#include "aslio/report/encode.hpp"
#include "placement.hpp"
#include "run_columns.hpp"

namespace aslio::report {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr double kTimeUnit = 1e-4;       // [s]
constexpr double kLengthUnit = 1e-3;     // [m] of positions
constexpr double kErrorUnit = 1e-4;      // [m]
constexpr double kPathTolerance = 4e-3;  // [m]; with the rounding of the positions within 5 mm
constexpr double kTolerance = 3e-3;      // of a channel's range
constexpr double kValueUnit = 2e-3;      // of a channel's range: with the tolerance within 0.4 %
/// Values over time, without what is not finite: there a line breaks.
struct Channel {
  std::vector<double> t, values;
  std::vector<std::size_t> breaks;  ///< ascending: samples that follow a missing one

  void add(double time, double value) {
    if (!std::isfinite(value)) {
      missing_ = !t.empty();
      return;
    }
    if (missing_) breaks.push_back(t.size());
    missing_ = false;
    t.push_back(time);
    values.push_back(value);
  }

 private:
  bool missing_ = false;
};

/// Of all but the smallest and largest hundredth: one window that the end cuts short has a rate of thousands. Above 0.
double usual_range(const std::vector<double>& values) {
  std::vector<double> sorted = values;
  std::sort(sorted.begin(), sorted.end());
  const std::size_t cut = sorted.size() / 100;
  const double range = sorted[sorted.size() - 1 - cut] - sorted[cut];
  return range > 0 ? range : std::max(std::abs(sorted[sorted.size() / 2]), 1e-6);
}

Json packed(const Channel& channel) {
  if (channel.t.empty()) return nullptr;
  const double range = usual_range(channel.values), unit = kValueUnit * range;
  std::vector<double> t, values;
  std::vector<std::int64_t> breaks;
  const std::span<const double> all_t = channel.t, all_values = channel.values;
  // Each stretch by itself: a line over a break would stand for what is missing.
  std::size_t begin = 0;
  for (std::size_t k = 0; k <= channel.breaks.size(); ++k) {
    const std::size_t end = k < channel.breaks.size() ? channel.breaks[k] : channel.t.size();
    if (k > 0) breaks.push_back(static_cast<std::int64_t>(t.size()));
    const auto stretch = all_values.subspan(begin, end - begin);
    for (const std::uint32_t i : decimated(all_t.subspan(begin, end - begin), stretch, kTolerance * range)) {
      t.push_back(channel.t[begin + i]);
      values.push_back(stretch[i]);
    }
    begin = end;
  }
  Json json = {{"t", packed_numbers(t, kTimeUnit)}, {"v", packed_numbers(values, unit)}, {"unit", unit}};
  if (!breaks.empty()) json["breaks"] = packed_integers(breaks);
  return json;
}

void put(Json& json, const char* name, const Channel& channel) {
  if (!channel.t.empty()) json[name] = packed(channel);
}

double seconds_from(TimeNs origin, TimeNs t) { return to_seconds(t - origin); }

void put_vectors(Json& json, std::array<const char*, 3> names, const std::vector<Vec3>& vectors, double unit) {
  for (Eigen::Index k = 0; k < 3; ++k) {
    std::vector<double> values;
    for (const Vec3& v : vectors) values.push_back(v[k]);
    json[names[static_cast<std::size_t>(k)]] = packed_numbers(values, unit);
  }
}

/// The quaternion x, y, z, w in bytes of 1/127.
void put_rotation(std::vector<std::uint8_t>& bytes, const Mat3& R) {
  const Eigen::Quaterniond q(R);
  for (const double c : {q.x(), q.y(), q.z(), q.w()}) {
    bytes.push_back(static_cast<std::uint8_t>(static_cast<std::int8_t>(std::lround(127 * std::clamp(c, -1.0, 1.0)))));
  }
}

/// Positions within kPathTolerance, with orientations, and errors where there are any (`known`: 1 at each that has one,
/// where some have none).
Json path_json(std::span<const StampedPose> poses, TimeNs origin, const std::vector<Vec3>& errors) {
  std::array<std::vector<double>, 4> all;
  for (const StampedPose& pose : poses) {
    all[0].push_back(seconds_from(origin, pose.t));
    for (Eigen::Index k = 0; k < 3; ++k) all[static_cast<std::size_t>(k) + 1].push_back(pose.T.p[k]);
  }
  std::vector<double> t;
  std::vector<Vec3> positions, kept_errors;
  std::vector<std::uint8_t> rotations, known;
  Vec3 held = Vec3::Zero();
  for (const std::uint32_t i : decimated(all[0], all[1], all[2], all[3], kPathTolerance)) {
    t.push_back(all[0][i]);
    positions.push_back(poses[i].T.p);
    if (!errors.empty()) {
      known.push_back(errors[i].allFinite() ? 1 : 0);
      // Held, where there is none: drawn larger, the path should not jump there.
      if (errors[i].allFinite()) held = errors[i];
      kept_errors.push_back(held);
    }
    put_rotation(rotations, poses[i].T.R);
  }
  Json json = {{"t", packed_numbers(t, kTimeUnit)}};
  put_vectors(json, {"x", "y", "z"}, positions, kLengthUnit);
  json["q"] = io::base64(rotations);
  if (!errors.empty()) put_vectors(json, {"dx", "dy", "dz"}, kept_errors, kErrorUnit);
  if (std::find(known.begin(), known.end(), 0) != known.end()) json["known"] = io::base64(known);
  return json;
}

const std::vector<double>* column(const Columns& columns, const std::string& name) {
  const auto at = columns.numbers.find(name);
  return at != columns.numbers.end() ? &at->second : nullptr;
}

Channel channel_of(const Columns& columns, const std::string& name, TimeNs origin, double scale = 1) {
  Channel channel;
  if (const auto* values = column(columns, name)) {
    for (std::size_t i = 0; i < values->size(); ++i) {
      channel.add(seconds_from(origin, columns.t[i]), scale * (*values)[i]);
    }
  }
  return channel;
}

/// Inverse of the time to the update before.
Channel rate_of(const Columns& columns, TimeNs origin) {
  Channel channel;
  for (std::size_t i = 1; i < columns.t.size(); ++i) {
    channel.add(seconds_from(origin, columns.t[i]), 1 / to_seconds(columns.t[i] - columns.t[i - 1]));
  }
  return channel;
}

/// What each update was: `alarm` of the monitor, `lost`, else its status.
std::vector<std::string> states(const Columns& columns) {
  const auto status = columns.texts.find("status");
  if (status == columns.texts.end()) return {};
  std::vector<std::string> out = status->second;
  const auto tracking = columns.texts.find("tracking");
  const std::vector<double>* alarm = column(columns, "alarm");
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (tracking != columns.texts.end() && tracking->second[i] == "lost") out[i] = "lost";
    if (alarm != nullptr && (*alarm)[i] > 0) out[i] = "alarm";
  }
  return out;
}

/// [begin, end, state] of the stretches whose updates were not `ok`.
Json weak_stretches(const Columns& columns, TimeNs origin) {
  Json json = Json::array();
  const std::vector<std::string> status = states(columns);
  const auto rounded = [&](std::size_t i) { return std::round(1e3 * seconds_from(origin, columns.t[i])) / 1e3; };
  for (std::size_t i = 0; i < status.size();) {
    std::size_t end = i + 1;
    while (end < status.size() && status[end] == status[i]) ++end;
    if (status[i] != "ok") json.push_back({rounded(i == 0 ? 0 : i - 1), rounded(end - 1), status[i]});
    i = end;
  }
  return json;
}

/// CPU of every update [ms], and by stage the mean over all.
void put_timings(Json& json, const fs::path& file, TimeNs origin, std::vector<std::string>& notes) {
  const auto columns = read_columns(file, notes);
  if (!columns) return;
  std::vector<double> total(columns->t.size(), 0.0);
  Json stages = Json::object();
  for (const auto& [name, values] : columns->numbers) {
    double sum = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (!std::isfinite(values[i])) continue;
      total[i] += values[i];
      sum += values[i];
    }
    stages[name.substr(0, name.rfind("_s"))] = 1e3 * sum / static_cast<double>(values.size());
  }
  Channel channel;
  for (std::size_t i = 0; i < total.size(); ++i) channel.add(seconds_from(origin, columns->t[i]), 1e3 * total[i]);
  put(json["channels"], "cpu_ms", channel);
  json["stages_ms"] = stages;
}

void put_telemetry(Json& json, const fs::path& file, TimeNs origin, std::vector<std::string>& notes) {
  const auto columns = read_columns(file, notes);
  if (!columns) return;
  Json& channels = json["channels"];
  put(channels, "sod", channel_of(*columns, "sod", origin));
  put(channels, "rate_hz", rate_of(*columns, origin));
  put(channels, "gyro_deg_s", channel_of(*columns, "gyro_rms_rad_s", origin, kDegPerRad));
  put(channels, "matches", channel_of(*columns, "n_matches", origin));
  put(channels, "residual_cm", channel_of(*columns, "residual_rms_m", origin, 100));
  put(channels, "weakest", channel_of(*columns, "eig_1", origin));
  put(channels, "iterations", channel_of(*columns, "iterations", origin));
  json["weak"] = weak_stretches(*columns, origin);
}

/// The complaint of a reader about a file of a run, less the folder: that is of this machine, and the page is for any.
std::string within_run(std::string text, const FolderRun& run) {
  const std::string folder = run.folder.string() + "/";
  if (text.starts_with(folder)) text.erase(0, folder.size());
  return text;
}

/// The reference that measured a run, by its manifest; none where none is named.
std::optional<io::ReferenceSpec> reference_of(const fs::path& run) {
  std::error_code ignored;
  const auto read = io::parse_json(read_file(run / "manifest.json").value_or(""));
  if (!read || !read->is_object()) return std::nullopt;
  const Json& manifest = *read;
  const auto reference = manifest.find("reference");
  if (reference != manifest.end() && reference->is_object()) {
    const auto path = reference->find("path");
    if (path != reference->end() && path->is_string()) {
      const auto keys = reference->find("resolved");
      const bool known = keys != reference->end() && keys->is_string();
      io::ReferenceSpec spec =
          known ? io::parse_reference_spec(*keys, (run / "manifest.json").string()) : io::ReferenceSpec();
      spec.file = *path;  // absolute
      return spec;
    }
  }
  if (reference != manifest.end()) return std::nullopt;
  // A run of before manifests named the reference.
  const auto dataset = manifest.find("dataset");
  if (dataset == manifest.end() || !dataset->is_string()) return std::nullopt;
  const auto file = dataset->get<std::string>();
  return fs::exists(file, ignored) ? experiment::load_dataset(file).reference : std::nullopt;
}

}  // namespace

DataTruth read_truth(const StudyFolder& study, const std::string& data) {
  DataTruth out;
  fs::path file = study.folder / "data" / data / "truth.tum";
  std::error_code ignored;
  const auto run = std::find_if(study.runs.begin(), study.runs.end(), [&](const FolderRun& r) {
    return r.data == data && fs::exists(r.folder / "manifest.json", ignored);
  });
  try {
    std::optional<io::ReferenceSpec> spec;
    if (fs::is_regular_file(file, ignored)) {
      spec = file;
    } else if (run != study.runs.end()) {
      spec = reference_of(run->folder);
    }
    if (spec && fs::exists(spec->file, ignored)) {
      experiment::Truth truth = experiment::load_truth(*spec);
      out.truth = std::move(truth.trajectory);
      out.point = truth.point;
    }
  } catch (const std::runtime_error&) {
    out.truth.reset();  // the page tells that there is no truth
  }
  if (out.truth) {
    out.origin = out.truth->begin_time();
  } else if (run != study.runs.end()) {
    if (const auto columns = read_columns(run->folder / "updates.csv")) out.origin = columns->t.front();
  }
  return out;
}

Json data_json(const StudyFolder& study, const std::string& data, const DataTruth& truth) {
  Json json = {{"name", data}};
  if (truth.truth) json["truth"] = path_json(truth.truth->samples(), truth.origin, {});
  const std::filesystem::path file = study.folder / "data" / data / "overlap.csv";
  CsvTable table;
  try {
    table = parse_csv(read_file(file).value_or(""), file);
  } catch (const DataError& error) {
    json["unreadable"] = error.what();
    return json;
  }
  const auto at = [&](const char* name) {
    return static_cast<std::size_t>(std::find(table.header.begin(), table.header.end(), name) - table.header.begin());
  };
  const std::size_t time = at("t"), overlap = at("true_overlap");
  if (time == table.header.size() || overlap == table.header.size()) return json;
  Channel channel;
  for (const auto& row : table.rows) {
    const double t = std::strtod(row[time].c_str(), nullptr) - to_seconds(truth.origin);
    if (std::isfinite(t) && (channel.t.empty() || t > channel.t.back()))
      channel.add(t, std::strtod(row[overlap].c_str(), nullptr));
  }
  if (!channel.t.empty()) json["overlap"] = packed(channel);
  return json;
}

Json series_json(const FolderRun& run, const DataTruth& truth) {
  Json json = {{"channels", Json::object()}};
  std::vector<std::string> notes;
  const auto placed = place(run, truth);
  if (placed && !placed->unreadable.empty()) {
    notes.push_back(within_run(placed->unreadable, run) + "; the trajectory is left out");
  } else if (placed) {
    json["path"] = path_json(placed->poses, truth.origin, placed->errors);
    json["aligned"] = placed->aligned;
    Channel channel;
    for (std::size_t i = 0; i < placed->errors.size(); ++i) {
      channel.add(seconds_from(truth.origin, placed->poses[i].t), 100 * placed->errors[i].norm());
    }
    put(json["channels"], "error_cm", channel);
  }
  put_telemetry(json, run.folder / "updates.csv", truth.origin, notes);
  put_timings(json, run.folder / "timings.csv", truth.origin, notes);
  if (!notes.empty()) json["notes"] = notes;
  if (json["channels"].empty() && !json.contains("path") && notes.empty()) return nullptr;
  return json;
}

}  // namespace aslio::report
