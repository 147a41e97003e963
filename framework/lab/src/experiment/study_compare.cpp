#include "aslio/experiment/study_compare.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <iterator>
#include <map>
#include <set>

#include "aslio/config/diff.hpp"
#include "aslio/config/document.hpp"
#include "aslio/core/csv.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/statistics/order.hpp"
#include "aslio/statistics/signed_rank.hpp"
#include "read_json.hpp"

namespace aslio::experiment {

namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 2> kMeasured = {"cpu_s_per_s", "peak_rss_mb"};
constexpr std::size_t kShown = 20;  // lines of a list

bool measured(const std::string& figure) {
  return std::find(kMeasured.begin(), kMeasured.end(), figure) != kMeasured.end();
}

/// A line of results.csv.
struct Run {
  std::string data, method, order_seed, status;
  std::map<std::string, std::string> figures;  ///< those there are, as written

  std::string name() const { return data + "/" + method + (order_seed == "0" ? "" : "/" + order_seed); }
  fs::path folder(const fs::path& output) const {
    return output / "runs" / data / (order_seed == "0" ? method : method + "_order_" + order_seed);
  }
  bool good() const { return status == "ok" || status == "degraded"; }
  std::optional<double> value(const std::string& figure) const {
    if (!good()) return kFailedFigure;
    const auto at = figures.find(figure);
    double out = 0;
    if (at == figures.end()) return std::nullopt;
    const auto [end, error] = std::from_chars(at->second.data(), at->second.data() + at->second.size(), out);
    return error == std::errc() ? std::optional(out) : std::nullopt;
  }
};

struct Folder {
  fs::path path;
  std::vector<std::string> figures;
  std::vector<Run> runs;
  std::map<std::string, std::string> identities;  ///< by data

  const Run* find(const Run& like) const {
    const auto at = std::lower_bound(by_name_.begin(), by_name_.end(), like.name(),
                                     [&](std::size_t i, const std::string& name) { return runs[i].name() < name; });
    return at != by_name_.end() && runs[*at].name() == like.name() ? &runs[*at] : nullptr;
  }
  void sort() {
    for (std::size_t i = 0; i < runs.size(); ++i) by_name_.push_back(i);
    std::sort(by_name_.begin(), by_name_.end(),
              [&](std::size_t a, std::size_t b) { return runs[a].name() < runs[b].name(); });
  }

 private:
  std::vector<std::size_t> by_name_;
};

Folder read_folder(const fs::path& path) {
  std::error_code ignored;
  if (!fs::exists(path / "results.csv", ignored)) {
    throw ConfigError(
        fmt::format("{}: there is no results.csv; name the --output of `aslio experiment`", path.string()));
  }
  const CsvTable table = read_csv(path / "results.csv");
  Folder folder;
  folder.path = path;
  const std::size_t first = table.column("reason") + 1;
  folder.figures.assign(table.header.begin() + static_cast<std::ptrdiff_t>(first), table.header.end());
  for (const auto& row : table.rows) {
    Run run{row[table.column("data")],
            row[table.column("method")],
            row[table.column("order_seed")],
            row[table.column("status")],
            {}};
    for (std::size_t k = first; k < row.size(); ++k) {
      if (!row[k].empty()) run.figures.emplace(table.header[k], row[k]);
    }
    folder.runs.push_back(std::move(run));
  }
  folder.sort();
  if (!fs::exists(path / "plan.csv", ignored)) return folder;
  const CsvTable plan = read_csv(path / "plan.csv");
  for (const auto& row : plan.rows) folder.identities[row[plan.column("data")]] = row[plan.column("identity")];
  return folder;
}

/// The output folder of a run's study, with a slash at its end, as the run knew it: by its manifest, for the folder may
/// have been moved since.
std::string origin_of(const Folder& folder, const Run& run) {
  const auto manifest = read_json(run.folder(folder.path) / "manifest.json");
  const std::string inside = run.folder({}).string();
  if (manifest && manifest->contains("command_line") && manifest->at("command_line").is_array()) {
    const auto& command = manifest->at("command_line");
    for (std::size_t i = 1; i < command.size(); ++i) {
      if (command[i - 1] != "--output" || !command[i].is_string()) continue;
      const auto output = command[i].get<std::string>();
      if (output.ends_with("/" + inside)) return output.substr(0, output.size() - inside.size());
    }
  }
  return fs::absolute(folder.path / "").lexically_normal().string();
}

/// resolved.yaml of a run in which files of its own study ({run:NAME} and {data}) are named from the output folder on:
/// where that lies is no difference of configuration.
std::string configuration_of(const Folder& folder, const Run& run) {
  constexpr std::string_view kBefore = " \"'[{";  // of a value
  std::string origin;
  for (const char c : origin_of(folder, run)) {
    if (c == '"' || c == '\\') origin += '\\';
    origin += c;
  }
  std::string text = config::read_text(run.folder(folder.path) / "resolved.yaml");
  for (std::size_t at = text.find(origin); at != std::string::npos; at = text.find(origin, at)) {
    const std::string_view rest = std::string_view(text).substr(at + origin.size());
    const bool begins = at > 0 && kBefore.find(text[at - 1]) != std::string_view::npos;
    if (begins && (rest.starts_with("runs/") || rest.starts_with("data/"))) {
      text.erase(at, origin.size());
    } else {
      ++at;
    }
  }
  return text;
}

class Comparer {
 public:
  Comparer(const Folder& a, const Folder& b) : a_(a), b_(b) {}

  FolderComparison compare() {
    for (const Run& run : a_.runs) {
      const Run* other = b_.find(run);
      if (other == nullptr) {
        out_.only_a.push_back(run.name());
      } else {
        pairs_[run.method].emplace_back(&run, other);
        compare_runs(run, *other);
      }
    }
    for (const Run& run : b_.runs) {
      if (a_.find(run) == nullptr) out_.only_b.push_back(run.name());
    }
    for (const auto& [data, identity] : a_.identities) {
      const auto other = b_.identities.find(data);
      if (other != b_.identities.end() && other->second != identity) out_.other_data.push_back(data);
    }
    for (const auto& [method, pairs] : pairs_) compare_method(method, pairs);
    return std::move(out_);
  }

 private:
  using Pairs = std::vector<std::pair<const Run*, const Run*>>;

  void compare_runs(const Run& a, const Run& b) {
    ++out_.shared;
    if (a.status != b.status) out_.outcomes.push_back(fmt::format("{}: {} -> {}", a.name(), a.status, b.status));
    const auto digest = [](const Run& run) {
      std::string text;
      for (const auto& [name, value] : run.figures) {
        if (!measured(name)) text.append(name).append("=").append(value).append("\n");
      }
      return text;
    };
    if (digest(a) != digest(b)) out_.different.push_back(a.name());
  }

  void compare_method(const std::string& method, const Pairs& pairs) {
    compare_configurations(method, pairs);
    for (const std::string& figure : a_.figures) {
      if (std::find(b_.figures.begin(), b_.figures.end(), figure) == b_.figures.end()) continue;
      FigureComparison c;
      c.method = method;
      c.figure = figure;
      std::vector<double> a, b, differences, finite;
      for (const auto& [run_a, run_b] : pairs) {
        const auto v = run_a->value(figure), w = run_b->value(figure);
        if (!v || !w) continue;
        a.push_back(*v);
        b.push_back(*w);
        differences.push_back(*v == *w ? 0 : *w - *v);
        c.different += *v == *w ? 0 : 1;
        c.tally.count(*w, *v);
        if (*v != kFailedFigure && *w != kFailedFigure) finite.push_back(*w - *v);
      }
      c.pairs = a.size();
      if (c.pairs == 0) continue;
      c.median_a = statistics::median(a);
      c.median_b = statistics::median(b);
      c.difference = statistics::median(finite);
      c.p = statistics::signed_rank(differences).p;
      out_.figures.push_back(std::move(c));
    }
  }

  /// Of the first pair of runs that both left their resolved pipeline.
  void compare_configurations(const std::string& method, const Pairs& pairs) {
    std::error_code ignored;
    for (const auto& [a, b] : pairs) {
      const fs::path one = a->folder(a_.path) / "resolved.yaml", other = b->folder(b_.path) / "resolved.yaml";
      if (!fs::exists(one, ignored) || !fs::exists(other, ignored)) continue;
      for (const config::Difference& d : config::diff(configuration_of(a_, *a), configuration_of(b_, *b))) {
        out_.configurations.push_back(
            fmt::format("{}: {}: {} -> {}", method, d.path, d.a.value_or("none"), d.b.value_or("none")));
      }
      return;
    }
  }

  const Folder &a_, &b_;
  FolderComparison out_;
  std::map<std::string, Pairs> pairs_;
};

std::string list(const std::string& title, const std::vector<std::string>& lines) {
  if (lines.empty()) return {};
  std::string text = fmt::format("\n{} ({})\n", title, lines.size());
  for (std::size_t i = 0; i < std::min(kShown, lines.size()); ++i) text += "  " + lines[i] + "\n";
  if (lines.size() > kShown) text += fmt::format("  and {} more\n", lines.size() - kShown);
  return text;
}

std::string number(const std::optional<double>& value) {
  if (!value) return "-";
  return *value == kFailedFigure ? "x" : fmt::format("{:.5g}", *value);
}

}  // namespace

bool FolderComparison::same() const {
  return shared > 0 && only_a.empty() && only_b.empty() && outcomes.empty() && different.empty();
}

FolderComparison compare_folders(const fs::path& a, const fs::path& b) {
  const Folder first = read_folder(a), second = read_folder(b);
  return Comparer(first, second).compare();
}

std::string to_text(const FolderComparison& c) {
  std::string text = fmt::format("{} runs in both, {} of them different, {} only in A, {} only in B\n", c.shared,
                                 c.different.size(), c.only_a.size(), c.only_b.size());
  const auto out = std::back_inserter(text);
  text += list("only in A", c.only_a) + list("only in B", c.only_b);
  text += list("data of the same name that differ", c.other_data) + list("configurations", c.configurations);
  text += list("outcomes", c.outcomes) + list("runs with different figures", c.different);
  std::string lines;
  for (const FigureComparison& f : c.figures) {
    if (f.different == 0) continue;
    lines += fmt::format("{:<20} {:<14} {:>5} {:>5} {:>11} {:>11} {:>11} {:>13} {:>7}\n", f.method, f.figure, f.pairs,
                         f.different, number(f.median_a), number(f.median_b), number(f.difference),
                         fmt::format("{} / {} / {}", f.tally.won, f.tally.lost, f.tally.tied),
                         f.p ? fmt::format("{:.3f}", *f.p) : "-");
  }
  if (lines.empty()) return text + "\nall figures are equal to the last bit\n";
  fmt::format_to(out, "\n{:<20} {:<14} {:>5} {:>5} {:>11} {:>11} {:>11} {:>13} {:>7}\n{}", "method", "figure", "pairs",
                 "differ", "median A", "median B", "B - A", "less/more/eq", "p", lines);
  return text;
}

}  // namespace aslio::experiment
