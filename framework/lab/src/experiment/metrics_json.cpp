#include "metrics_json.hpp"

#include <fmt/format.h>

#include "aslio/experiment/measure.hpp"

namespace aslio::experiment {

namespace {

using Json = nlohmann::ordered_json;

Json or_null(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

}  // namespace

Json metrics_json(const std::optional<evaluation::Evaluation>& evaluation, const std::optional<double>& end_to_end_m,
                  const std::optional<double>& failed_at, const std::string& error) {
  Json out = {{"ate_m", nullptr}, {"ate_deg", nullptr}, {"rpe", nullptr}, {"rpe_distance_m", nullptr}};
  if (evaluation) {
    out["ate_m"] = evaluation->ate.translation.rmse;
    if (evaluation->ate.rotation.n > 0) out["ate_deg"] = evaluation->ate.rotation.rmse;
    if (const auto rpe = headline_rpe(*evaluation)) {
      out["rpe"] = rpe->rmse_m;
      out["rpe_distance_m"] = rpe->distance_m;
    }
  }
  out["end_to_end_m"] = or_null(end_to_end_m);
  out["failed_at"] = or_null(failed_at);
  out["matched"] = evaluation ? Json(evaluation->matched_share) : Json(nullptr);
  if (!error.empty()) out["error"] = error;
  return out;
}

std::string off_reference(const std::optional<evaluation::Evaluation>& evaluation) {
  constexpr double metres = 1.0, share = 0.01;
  if (!evaluation) return "";
  const double ate = evaluation->ate.translation.rmse;
  if (ate <= metres || ate <= share * evaluation->reference_path) return "";
  return fmt::format("off the reference by {:.2f} m (ATE) over {:.0f} m of path: more than {:g} m and {:.0f} %", ate,
                     evaluation->reference_path, metres, 100 * share);
}

}  // namespace aslio::experiment
