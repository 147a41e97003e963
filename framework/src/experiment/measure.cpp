#include "aslio/experiment/measure.hpp"

#include <algorithm>

namespace aslio::experiment {

evaluation::Options measuring_options(const Trajectory& reference, evaluation::Rule rule) {
  evaluation::Options options;
  options.rule = rule;
  const auto samples = reference.samples();
  if (samples.size() < 2) return options;
  std::vector<TimeNs> steps;
  steps.reserve(samples.size() - 1);
  for (std::size_t i = 1; i < samples.size(); ++i) steps.push_back(samples[i].t - samples[i - 1].t);
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  options.max_reference_gap = std::max(options.max_reference_gap, 2.5 * to_seconds(*middle));
  return options;
}

std::optional<HeadlineRpe> headline_rpe(const evaluation::Evaluation& evaluation) {
  std::optional<HeadlineRpe> shortest;
  for (const auto& error : evaluation.rpe) {
    if (error.unit != evaluation::DeltaUnit::metres || error.pairs == 0) continue;
    if (!shortest || error.delta < shortest->distance_m) shortest = {error.translation_rmse, error.delta};
  }
  return shortest;
}

}  // namespace aslio::experiment
