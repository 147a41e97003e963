// Medians over replicates, ranks and comparisons.
#include "aslio/report/table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "aslio/core/length_unit.hpp"
#include "aslio/experiment/study_results.hpp"

namespace aslio::report {

namespace {

constexpr double kFailed = std::numeric_limits<double>::infinity();

enum class Kind : unsigned char { length, share, other };

struct KnownMetric {
  std::string_view name, title, unit;
  Kind kind;
  bool smaller_is_better;
};

constexpr std::array<KnownMetric, 15> kKnown = {{
    {"ate_m", "ATE", "m", Kind::length, true},
    {"ate_deg", "ATE, rotation", "deg", Kind::other, true},
    {"rpe", "RPE", "m", Kind::length, true},
    {"rpe_distance_m", "RPE distance", "m", Kind::other, false},
    {"end_to_end_m", "End to end", "m", Kind::length, true},
    {"matched", "Matched", "%", Kind::share, false},
    {"coverage", "Coverage", "%", Kind::share, false},
    {"updates", "Updates", "", Kind::other, false},
    {"weak_share", "Weak updates", "% of time", Kind::share, false},
    {"peak_rss_mb", "Memory", "MB", Kind::other, true},
    {"path_length_m", "Path", "m", Kind::other, false},
    {"rate_hz", "Update rate", "Hz", Kind::other, false},
    {"cpu_s_per_s", "CPU", "s per s of data", Kind::other, true},
    {"wall_s", "Wall time", "s", Kind::other, true},
    {"mean_rate_hz", "Mean rate", "Hz", Kind::other, false},
}};

double median_of(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

std::optional<double> failed_at(const StudyFolder& study, const FolderRun& run) {
  const auto figure = study.figure("failed_at");
  return figure ? run.figures[*figure] : std::nullopt;
}

/// Figure of a run, infinite for a failure; nothing when a good run has no such figure. The end-to-end error fails on
/// the way, too: a run may come back to its beginning from anywhere.
std::optional<double> value_of(const StudyFolder& study, const FolderRun& run, std::size_t figure) {
  if (study.figures[figure] == "end_to_end_m" && failed_at(study, run)) return kFailed;
  return run.good() ? run.figures[figure] : std::optional(kFailed);
}

Cell cell_of(const StudyFolder& study, const std::string& sequence, const std::string& method, std::size_t figure) {
  Cell cell;
  std::map<std::string, std::vector<double>> orders;  // by recording, of its order seeds
  for (const FolderRun& run : study.runs) {
    if (run.method != method || run.sequence != sequence) continue;
    const auto value = value_of(study, run, figure);
    if (!value) continue;
    orders[run.data].push_back(*value);
    ++cell.runs;
    if (*value == kFailed) ++(experiment::failed_late(run.status, failed_at(study, run)) ? cell.diverged : cell.failed);
  }
  std::vector<double> values;
  for (auto& [data, of] : orders) values.push_back(median_of(of));
  if (values.empty()) return cell;
  std::sort(values.begin(), values.end());
  const double median = median_of(values);
  const auto good = static_cast<std::size_t>(std::lower_bound(values.begin(), values.end(), kFailed) - values.begin());
  cell.recordings = values.size();
  cell.with_figure = good;
  if (good > 0) {
    cell.min = values[0];
    cell.max = values[good - 1];
  }
  if (median != kFailed) {
    cell.mark = Mark::value;
    cell.median = median;
  } else {
    cell.mark = cell.diverged > cell.failed ? Mark::diverged : Mark::failed;
  }
  return cell;
}

/// Best and second among the figures of a line; equal figures share a rank.
void rank(Line& line) {
  std::vector<double> values;
  for (const Cell& cell : line.cells) {
    if (cell.mark == Mark::value) values.push_back(cell.median);
  }
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
  if (line.cells.size() < 2) return;
  for (Cell& cell : line.cells) {
    if (cell.mark != Mark::value) continue;
    if (cell.median == values[0]) cell.rank = Rank::best;
    if (values.size() > 1 && cell.median == values[1]) cell.rank = Rank::second;
  }
}

void count(Tally& tally, double value, double baseline) {
  ++(value < baseline ? tally.won : value > baseline ? tally.lost : tally.tied);
}

/// Two methods on the same recordings of a sequence, by the medians over the order seeds that both have.
std::vector<std::pair<double, double>> pairs_of(const StudyFolder& study, const std::string& sequence,
                                                std::size_t method, std::size_t other, std::size_t figure) {
  std::map<std::string, std::pair<std::vector<double>, std::vector<double>>> orders;  // by recording
  for (const FolderRun& a : study.runs) {
    if (a.method != study.methods[method] || a.sequence != sequence) continue;
    for (const FolderRun& b : study.runs) {
      if (b.method != study.methods[other] || b.data != a.data || b.order_seed != a.order_seed) continue;
      const auto x = value_of(study, a, figure), y = value_of(study, b, figure);
      if (!x || !y) continue;
      orders[a.data].first.push_back(*x);
      orders[a.data].second.push_back(*y);
    }
  }
  std::vector<std::pair<double, double>> found;
  for (const auto& [data, both] : orders) found.emplace_back(median_of(both.first), median_of(both.second));
  return found;
}

/// Median of a / b, as in table.md: 1 for two that are equal, two failures among them.
std::optional<double> ratio_of(const std::vector<std::pair<double, double>>& pairs) {
  std::vector<double> ratios;
  for (const auto& [a, b] : pairs) {
    ratios.push_back(a == b ? 1 : b == 0 ? kFailed : b == kFailed ? 0 : a / b);
  }
  if (ratios.empty()) return std::nullopt;
  return median_of(ratios);
}

/// What statistics.csv adds.
std::vector<Statistic> statistics_of(const StudyFolder& study, const std::string& metric, const std::string& method) {
  const auto at = std::find_if(study.statistics.begin(), study.statistics.end(),
                               [&](const FolderStatistic& s) { return s.metric == metric && s.method == method; });
  if (at == study.statistics.end()) return {};
  const auto ratio = [](double v) { return std::isfinite(v) ? fmt::format("{:.3g}", v) : std::string("x"); };
  const auto p = [](const std::optional<double>& v) {
    return !v ? std::string() : *v < 0.001 ? std::string("< 0.001") : fmt::format("{:.3f}", *v);
  };
  return {{"95 % of ratio", at->low && at->high ? fmt::format("{} to {}", ratio(*at->low), ratio(*at->high)) : ""},
          {"effect", at->effect ? fmt::format("{:+.2f}", *at->effect) : ""},
          {"p", p(at->p)},
          {"p (Holm)", p(at->p_holm)},
          {"p (sequences)", p(at->p_sequences)}};
}

Comparison compare(const StudyFolder& study, std::size_t method, std::size_t figure) {
  Comparison out{
      .method = method, .baseline = *study.baseline[method], .sequences = {}, .pairs = {}, .ratio = {}, .more = {}};
  std::vector<std::pair<double, double>> pairs;
  for (const std::string& sequence : study.sequences) {
    const auto here = pairs_of(study, sequence, method, out.baseline, figure);
    if (here.empty()) continue;
    std::vector<double> values, others;
    for (const auto& [a, b] : here) {
      count(out.pairs, a, b);
      values.push_back(a);
      others.push_back(b);
    }
    count(out.sequences, median_of(std::move(values)), median_of(std::move(others)));
    pairs.insert(pairs.end(), here.begin(), here.end());
  }
  out.ratio = ratio_of(pairs);
  return out;
}

Metric describe(const std::string& name, const std::vector<Line>& lines) {
  std::vector<double> medians;
  for (const Line& line : lines) {
    for (const Cell& cell : line.cells) {
      if (cell.mark == Mark::value) medians.push_back(std::abs(cell.median));
    }
  }
  std::sort(medians.begin(), medians.end());
  Metric metric{.name = name, .title = name, .unit = "", .smaller_is_better = false};
  const auto known = std::find_if(kKnown.begin(), kKnown.end(), [&](const KnownMetric& m) { return m.name == name; });
  if (known != kKnown.end()) {
    metric.title = known->title;
    metric.unit = known->unit;
    metric.smaller_is_better = known->smaller_is_better;
    if (known->kind == Kind::share) metric.scale = 100;
    if (known->kind == Kind::length && !medians.empty()) {
      const LengthUnit unit = length_unit(medians.back());
      metric.scale = unit.scale;
      metric.unit = unit.name;
    }
  }
  // Three digits of a typical value, so that the points of a column stand below each other.
  const double typical = medians.empty() ? 0 : metric.scale * medians[medians.size() / 2];
  metric.decimals = typical > 0 ? std::clamp(2 - static_cast<int>(std::floor(std::log10(typical))), 0, 6) : 3;
  return metric;
}

}  // namespace

std::vector<MetricTable> make_tables(const StudyFolder& study, const std::vector<std::string>& metrics) {
  std::vector<MetricTable> tables;
  for (const std::string& name : metrics) {
    const auto figure = study.figure(name);
    if (!figure) continue;
    MetricTable table;
    for (const std::string& sequence : study.sequences) {
      Line line{.sequence = sequence, .cells = {}};
      for (const std::string& method : study.methods) line.cells.push_back(cell_of(study, sequence, method, *figure));
      table.lines.push_back(std::move(line));
    }
    table.metric = describe(name, table.lines);
    if (table.metric.smaller_is_better) {
      for (Line& line : table.lines) rank(line);
      for (std::size_t m = 0; m < study.methods.size(); ++m) {
        if (!study.baseline[m]) continue;
        table.comparisons.push_back(compare(study, m, *figure));
        table.comparisons.back().more = statistics_of(study, name, study.methods[m]);
      }
    }
    tables.push_back(std::move(table));
  }
  return tables;
}

std::string number(const Metric& metric, double value) {
  return fmt::format("{:.{}f}", metric.scale * value, metric.decimals);
}

}  // namespace aslio::report
