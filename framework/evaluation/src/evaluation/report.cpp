#include "aslio/evaluation/report.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <iterator>
#include <nlohmann/json.hpp>

namespace aslio::evaluation {

namespace {

using Json = nlohmann::ordered_json;

const char* name(Alignment alignment) {
  switch (alignment) {
    case Alignment::none:
      return "none";
    case Alignment::yaw:
      return "yaw";
    case Alignment::se3:
      return "se3";
  }
  return "?";
}

const char* name(DeltaUnit unit) { return unit == DeltaUnit::metres ? "m" : "s"; }

const char* name(Rule rule) {
  switch (rule) {
    case Rule::evo:
      return "evo";
    case Rule::at_reference:
      return "at_reference";
    case Rule::interpolated:
      break;
  }
  return "interpolated";
}

const char* name(Scoring scoring) { return scoring == Scoring::hilti_2022 ? "hilti_2022" : "hilti_2023"; }

/// Nothing for a figure that the reference cannot tell.
Json known(bool is, double value) { return is ? Json(value) : Json(nullptr); }

Json json_of(const Statistics& s) {
  return {{"n", s.n},     {"rmse", s.rmse}, {"mean", s.mean}, {"median", s.median},
          {"std", s.std}, {"min", s.min},   {"max", s.max}};
}

Json json_of(const PoseErrors& errors) {
  return {{"translation_m", json_of(errors.translation)},
          {"rotation_deg", errors.rotation.n > 0 ? json_of(errors.rotation) : Json(nullptr)}};
}

Json json_of(const std::optional<PoseErrors>& errors) { return errors ? json_of(*errors) : Json(nullptr); }

Json json_of(const RelativeError& error) {
  return {{"delta", error.delta},
          {"unit", name(error.unit)},
          {"pairs", error.pairs},
          {"translation_m", error.pairs ? Json(error.translation_rmse) : Json(nullptr)},
          {"rotation_deg", error.pairs ? Json(error.rotation_rmse) : Json(nullptr)}};
}

Json json_of(const Pose& pose) {
  Eigen::Quaterniond q(pose.R);
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  return {{"translation_m", {pose.p.x(), pose.p.y(), pose.p.z()}}, {"quaternion_xyzw", {q.x(), q.y(), q.z(), q.w()}}};
}

void add_row(std::string& text, const std::string& label, const std::optional<PoseErrors>& errors) {
  auto out = std::back_inserter(text);
  if (!errors) {
    fmt::format_to(out, "{:<26}{:>6}\n", label, "-");
    return;
  }
  for (const auto& [unit, s] : {std::pair("m", errors->translation), std::pair("deg", errors->rotation)}) {
    if (s.n == 0) continue;
    fmt::format_to(out, "{:<26}{:>6}{:>10.4f}{:>10.4f}{:>10.4f}{:>10.4f}{:>10.4f}{:>10.4f}  {}\n",
                   unit[0] == 'm' ? label : std::string(), s.n, s.rmse, s.mean, s.median, s.std, s.min, s.max, unit);
  }
}

}  // namespace

Json to_json(const Evaluation& e) {
  Json json;
  json["ate_m"] = e.ate.translation.rmse;
  const bool turned = !e.options.positions_only;
  json["ate_deg"] = known(turned, e.ate.rotation.rmse);
  json["rpe"] = Json::array();
  for (const RelativeError& error : e.rpe) json["rpe"].push_back(json_of(error));
  json["end_to_end_m"] = e.end_to_end.distance;
  json["matched"] = e.matched_share;
  json["covered"] = e.covered_share;
  json["ate_deg_rotation_aligned"] = known(turned, e.ate_deg_rotation_aligned);
  json["ate_deg_body_offset_removed"] = known(turned, e.ate_deg_body_offset_removed);
  json["end_to_end_error_m"] = known(turned, e.end_to_end.error);
  json["end_to_end_error_deg"] = known(turned, e.end_to_end.rotation_error);
  json["estimate_path_m"] = e.estimate_path;
  json["reference_path_m"] = e.reference_path;
  json["counts"] = {{"poses", e.estimate_poses}, {"matched", e.matched}, {"unmatched", e.unmatched}};
  json["rule"] = name(e.options.rule);
  json["alignment"] = name(e.options.alignment);
  json["T_reference_estimate"] = json_of(e.T_reference_estimate);
  json["ate"] = json_of(e.ate);
  json["ate_yaw"] = json_of(e.ate_yaw);
  json["ate_grid"] = json_of(e.ate_grid);
  json["ate_turns"] = json_of(e.ate_turns);
  json["ate_straight"] = json_of(e.ate_straight);
  json["positions_only"] = e.options.positions_only;
  json["score"] = e.score ? Json{{"name", name(e.options.scoring)}, {"value", *e.score}, {"most", 100}} : Json(nullptr);
  json["time_offset"] = e.time_offset
                            ? Json{{"seconds", e.time_offset->seconds}, {"position_m", e.time_offset->rmse_after}}
                            : Json(nullptr);
  json["notes"] = e.notes;
  json["warnings"] = e.warnings;
  return json;
}

std::string to_text(const Evaluation& e) {
  std::string text;
  auto out = std::back_inserter(text);
  fmt::format_to(out, "rule {}, alignment {}\n", name(e.options.rule), name(e.options.alignment));
  fmt::format_to(out, "matched {} of {} poses ({:.1f} %), covered {:.1f} % of the reference's duration\n", e.matched,
                 e.estimate_poses, 100.0 * e.matched_share, 100.0 * e.covered_share);
  fmt::format_to(out, "path {:.2f} m, reference {:.2f} m\n", e.estimate_path, e.reference_path);
  for (const std::string& note : e.notes) fmt::format_to(out, "reference: {}\n", note);
  text += '\n';
  fmt::format_to(out, "{:<26}{:>6}{:>10}{:>10}{:>10}{:>10}{:>10}{:>10}\n", "absolute error", "n", "rmse", "mean",
                 "median", "std", "min", "max");
  add_row(text, "all", e.ate);
  add_row(text, "aligned by yaw", e.ate_yaw);
  add_row(text, fmt::format("common {:g} Hz grid", 1.0 / e.options.grid_period), e.ate_grid);
  add_row(text, fmt::format("turns (> {:g} rad/s)", e.options.turn_rate), e.ate_turns);
  add_row(text, "straight", e.ate_straight);
  if (e.score) fmt::format_to(out, "score {}: {:.2f} of 100\n", name(e.options.scoring), *e.score);
  if (e.options.positions_only) {
    text += "the reference tells positions only: no rotation error, no relative error\n";
    for (const std::string& warning : e.warnings) fmt::format_to(out, "warning: {}\n", warning);
    return text;
  }
  fmt::format_to(out, "rotation, worlds aligned by orientation: {:.4f} deg; body offset removed: {:.4f} deg\n\n",
                 e.ate_deg_rotation_aligned, e.ate_deg_body_offset_removed);
  fmt::format_to(out, "{:<26}{:>6}{:>10}{:>10}\n", "relative error (rmse)", "pairs", "m", "deg");
  for (const RelativeError& error : e.rpe) {
    const std::string label = fmt::format("over {:g} {}", error.delta, name(error.unit));
    if (error.pairs == 0) {
      fmt::format_to(out, "{:<26}{:>6}{:>10}{:>10}\n", label, 0, "-", "-");
    } else {
      fmt::format_to(out, "{:<26}{:>6}{:>10.4f}{:>10.4f}\n", label, error.pairs, error.translation_rmse,
                     error.rotation_rmse);
    }
  }
  fmt::format_to(out, "\nend to end: {:.4f} m apart; against the reference {:.4f} m, {:.4f} deg\n",
                 e.end_to_end.distance, e.end_to_end.error, e.end_to_end.rotation_error);
  for (const std::string& warning : e.warnings) fmt::format_to(out, "warning: {}\n", warning);
  return text;
}

}  // namespace aslio::evaluation
