#include "aslio/experiment/study_statistics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "aslio/core/sha256.hpp"
#include "aslio/statistics/order.hpp"
#include "aslio/statistics/signed_rank.hpp"

namespace aslio::experiment {

namespace {

constexpr std::array<std::string_view, 6> kSmallerIsBetter = {"ate_m",        "ate_deg",     "rpe",
                                                              "end_to_end_m", "cpu_s_per_s", "peak_rss_mb"};
/// Figures that differ between two runs of the same thing.
constexpr std::array<std::string_view, 2> kMeasured = {"cpu_s_per_s", "peak_rss_mb"};

/// Of figures from 0 to infinity; 1 for two that are equal, two failures among them.
double ratio_of(double value, double baseline) {
  if (value == baseline) return 1;
  if (baseline == 0) return kFailedFigure;
  return baseline == kFailedFigure ? 0 : value / baseline;
}

std::string value_text(const std::optional<double>& value) { return value ? fmt::to_string(*value) : std::string(); }

/// Digest of what a run came to; empty when there is nothing to compare.
std::string digest_of(const std::optional<StudyRow>& row) {
  if (!row || !row->good()) return {};
  std::string text;
  for (const auto& [name, value] : row->figures) {
    if (std::find(kMeasured.begin(), kMeasured.end(), name) == kMeasured.end()) {
      text += fmt::format("{}={}\n", name, value);
    }
  }
  return text.empty() ? text : sha256_of(text);
}

}  // namespace

bool smaller_is_better(std::string_view metric) {
  return std::find(kSmallerIsBetter.begin(), kSmallerIsBetter.end(), metric) != kSmallerIsBetter.end();
}

std::optional<double> Replicates::median() const { return statistics::quantile_of_sorted(values, 0.5); }

void Tally::count(double value, double baseline) {
  if (value < baseline) {
    ++won;
  } else if (value > baseline) {
    ++lost;
  } else {
    ++tied;
  }
}

StudyFigures::StudyFigures(const Study& study, const std::vector<StudyRun>& runs,
                           const std::vector<std::optional<StudyRow>>& rows)
    : study_(study), rows_(rows) {
  for (std::size_t d = 0; d < study.data.size(); ++d) {
    const auto at = std::find(sequences_.begin(), sequences_.end(), study.data[d].sequence);
    const auto s = static_cast<std::size_t>(at - sequences_.begin());
    if (at == sequences_.end()) {
      sequences_.push_back(study.data[d].sequence);
      data_of_.emplace_back();
    }
    data_of_[s].push_back(d);
  }
  // The runs over the same data with the same order seed stand together, by method.
  groups_of_.resize(study.data.size());
  for (std::size_t group = 0; group < runs.size(); group += study.methods.size()) {
    groups_of_[runs[group].data].push_back(group);
  }
}

std::optional<double> StudyFigures::value(std::size_t run, const std::string& metric) const {
  if (!rows_[run]) return std::nullopt;
  if (metric == "end_to_end_m" && rows_[run]->figure("failed_at")) return kFailedFigure;
  return rows_[run]->good() ? rows_[run]->figure(metric) : std::optional(kFailedFigure);
}

Pair StudyFigures::pair(std::size_t data, std::size_t method, std::size_t baseline, const std::string& metric) const {
  std::vector<double> values, others;
  for (const std::size_t group : groups_of_[data]) {
    const auto v = value(group + method, metric), w = value(group + baseline, metric);
    if (!v || !w || std::isnan(*v) || std::isnan(*w)) continue;
    values.push_back(*v);
    others.push_back(*w);
  }
  return {statistics::median(values), statistics::median(others), values.size()};
}

Replicates StudyFigures::replicates(std::size_t sequence, std::size_t method, const std::string& metric) const {
  Replicates out;
  for (const std::size_t data : data_of_[sequence]) {
    std::vector<double> orders;
    for (const std::size_t group : groups_of_[data]) {
      const std::size_t run = group + method;
      const auto v = value(run, metric);
      if (!v || std::isnan(*v)) continue;
      orders.push_back(*v);
      if (*v != kFailedFigure) continue;
      ++out.failed;
      out.late += failed_late(rows_[run]->outcome.status, rows_[run]->figure("failed_at")) ? 1 : 0;
    }
    out.runs += orders.size();
    if (const auto median = statistics::median(orders)) out.values.push_back(*median);
  }
  std::sort(out.values.begin(), out.values.end());
  return out;
}

Comparison StudyFigures::compare(std::size_t method, std::size_t baseline, const std::string& metric) const {
  Comparison out;
  out.method = method;
  out.baseline = baseline;
  std::vector<std::vector<double>> ratios(sequences_.size());
  std::vector<double> all, logarithms, of_sequences;
  for (std::size_t s = 0; s < sequences_.size(); ++s) {
    std::vector<double> values, others;
    for (const std::size_t data : data_of_[s]) {
      const Pair both = pair(data, method, baseline, metric);
      if (!both.value) continue;
      values.push_back(*both.value);
      others.push_back(*both.baseline);
      out.pairs.count(*both.value, *both.baseline);
      out.failed += *both.value == kFailedFigure ? 1 : 0;
      out.baseline_failed += *both.baseline == kFailedFigure ? 1 : 0;
      ratios[s].push_back(ratio_of(*both.value, *both.baseline));
      all.push_back(ratios[s].back());
      logarithms.push_back(std::log(all.back()));
    }
    if (values.empty()) continue;
    out.sequences.count(*statistics::median(values), *statistics::median(others));
    of_sequences.push_back(std::log(*statistics::median(ratios[s])));
  }
  out.ratio = statistics::median(all);
  out.interval = statistics::bootstrap_median_clustered(ratios);
  const statistics::SignedRank test = statistics::signed_rank(logarithms);
  out.effect = test.effect;
  out.p = test.p;
  out.p_sequences = statistics::signed_rank(of_sequences).p;
  return out;
}

std::vector<Comparison> StudyFigures::comparisons(const std::string& metric) const {
  std::vector<Comparison> out;
  if (!smaller_is_better(metric)) return out;
  std::vector<std::optional<double>> p;
  for (std::size_t m = 0; m < study_.methods.size(); ++m) {
    if (!study_.baseline[m]) continue;
    out.push_back(compare(m, *study_.baseline[m], metric));
    p.push_back(out.back().p);
  }
  const auto corrected = statistics::holm(p);
  for (std::size_t i = 0; i < out.size(); ++i) out[i].p_holm = corrected[i];
  return out;
}

std::string statistics_csv(const Study& study, const StudyFigures& figures) {
  std::string text =
      "metric,sequence,method,baseline,runs,failed,median,quartile_1,quartile_3,low,high,baseline_failed,pairs_won,"
      "pairs_lost,pairs_tied,sequences_won,sequences_lost,sequences_tied,effect,p,p_holm,p_sequences\n";
  const auto out = std::back_inserter(text);
  for (const std::string& metric : study.config.metrics) {
    for (std::size_t s = 0; s < figures.sequences().size(); ++s) {
      for (std::size_t m = 0; m < study.methods.size(); ++m) {
        const Replicates r = figures.replicates(s, m, metric);
        if (r.values.empty()) continue;
        const auto interval = statistics::bootstrap_median(r.values);
        fmt::format_to(out, "{},{},{},,{},{},{},{},{},{},{},,,,,,,,,,,\n", metric, figures.sequences()[s],
                       study.methods[m].name, r.runs, r.failed, value_text(r.median()),
                       value_text(statistics::quantile_of_sorted(r.values, 0.25)),
                       value_text(statistics::quantile_of_sorted(r.values, 0.75)),
                       interval ? fmt::to_string(interval->low) : "", interval ? fmt::to_string(interval->high) : "");
      }
    }
    for (const Comparison& c : figures.comparisons(metric)) {
      fmt::format_to(
          out, "{},,{},{},{},{},{},,,{},{},{},{},{},{},{},{},{},{},{},{},{}\n", metric, study.methods[c.method].name,
          study.methods[c.baseline].name, c.pairs.won + c.pairs.lost + c.pairs.tied, c.failed, value_text(c.ratio),
          c.interval ? fmt::to_string(c.interval->low) : "", c.interval ? fmt::to_string(c.interval->high) : "",
          c.baseline_failed, c.pairs.won, c.pairs.lost, c.pairs.tied, c.sequences.won, c.sequences.lost,
          c.sequences.tied, value_text(c.effect), value_text(c.p), value_text(c.p_holm), value_text(c.p_sequences));
    }
  }
  return text;
}

std::vector<IdenticalMethods> identical_methods(const Study& study, const std::vector<StudyRun>& runs,
                                                const std::vector<std::optional<StudyRow>>& rows) {
  std::vector<std::string> digests;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    // A trajectory that others have made does not tell of what differs.
    digests.push_back(study.methods[runs[i].method].external ? std::string() : digest_of(rows[i]));
  }
  const std::size_t methods = study.methods.size();
  // Runs come in groups over the same data with the same order seed, by method.
  const auto compared = [&](std::size_t a, std::size_t b) {
    std::size_t same = 0;
    for (std::size_t group = 0; group < runs.size(); group += methods) {
      const std::string &one = digests[group + a], &other = digests[group + b];
      if (one.empty() || other.empty()) continue;
      if (one != other) return std::size_t{0};
      ++same;
    }
    return same;
  };
  std::vector<IdenticalMethods> out;
  std::vector<bool> taken(methods, false);  // equal to an earlier one: told once
  for (std::size_t a = 0; a < methods; ++a) {
    for (std::size_t b = a + 1; b < methods && !taken[a]; ++b) {
      const std::size_t same = taken[b] ? 0 : compared(a, b);
      if (same == 0) continue;
      out.push_back({a, b, same});
      taken[b] = true;
    }
  }
  return out;
}

std::vector<std::string> identical_orders(const Study& study, const std::vector<StudyRun>& runs,
                                          const std::vector<std::optional<StudyRow>>& rows) {
  std::vector<std::string> out;
  for (std::size_t m = 0; m < study.methods.size(); ++m) {
    if (study.methods[m].external) continue;
    std::vector<std::vector<std::string>> digests(study.data.size());
    for (std::size_t i = 0; i < runs.size(); ++i) {
      std::string digest = runs[i].method == m ? digest_of(rows[i]) : std::string();
      if (!digest.empty()) digests[runs[i].data].push_back(std::move(digest));
    }
    std::size_t same = 0, apart = 0;
    for (const std::vector<std::string>& of : digests) {
      if (of.size() < 2) continue;
      ++(std::count(of.begin(), of.end(), of.front()) == static_cast<std::ptrdiff_t>(of.size()) ? same : apart);
    }
    if (same == 0 || apart > 0) continue;
    out.push_back(
        fmt::format("{} gave the same figures to the last bit for every order seed, on {} recording{}: the order seed "
                    "has no effect on it",
                    study.methods[m].name, same, same == 1 ? "" : "s"));
  }
  return out;
}

std::string identical_text(const Study& study, const IdenticalMethods& same) {
  return fmt::format(
      "{} and {} gave the same figures to the last bit in all {} pairs: what they differ in has no effect",
      study.methods[same.first].name, study.methods[same.second].name, same.runs);
}

}  // namespace aslio::experiment
