#include "study_display.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "aslio/experiment/study_statistics.hpp"
#include "console.hpp"
#include "interrupt.hpp"

namespace aslio::cli {

namespace {

constexpr std::size_t kBar = 24;
constexpr std::size_t kMaxShown = 12;  // of what is at work

std::string bar_of(std::size_t done, std::size_t total) {
  const std::size_t full = total > 0 ? kBar * std::min(done, total) / total : kBar;
  std::string bar(full, '=');
  if (full < kBar) bar += '>';
  bar.resize(kBar, ' ');
  return "[" + bar + "]";
}

std::string duration(double seconds) {
  const long s = std::lround(seconds);
  return s < 3600 ? fmt::format("{}:{:02}", s / 60, s % 60)
                  : fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
}

/// "0.0312", "x" or "-" where the median run has failed, nothing where none has ended.
std::string median_text(const experiment::Replicates& replicates) {
  const auto median = replicates.median();
  if (!median) return "";
  if (*median != experiment::kFailedFigure) return fmt::format("{:.4g}", *median);
  return 2 * replicates.late > replicates.failed ? "-" : "x";
}

}  // namespace

std::string display_text(const experiment::StudyProgress& p, std::size_t width) {
  std::string text;
  const auto add = [&](const std::string& line) {
    if (!text.empty()) text += "\n";
    text.append(line, 0, width);
  };
  std::string first = fmt::format("{} {}/{} runs", bar_of(p.done, p.total), p.done, p.total);
  if (p.left_s) first += fmt::format("   {} left", duration(*p.left_s));
  if (p.failed > 0) first += fmt::format("   {} failed", p.failed);
  add(first);
  for (std::size_t i = 0; i < std::min(p.active.size(), kMaxShown); ++i) {
    add(fmt::format("  {:>7}  {}", duration(p.active[i].since_s), p.active[i].name));
  }
  if (p.active.size() > kMaxShown) add(fmt::format("           and {} more", p.active.size() - kMaxShown));
  return text;
}

std::string medians_text(const experiment::Study& study, const std::vector<experiment::StudyRun>& runs,
                         const std::vector<std::optional<experiment::StudyRow>>& rows) {
  const experiment::StudyFigures figures(study, runs, rows);
  const std::string& metric = study.config.metrics.front();
  std::vector<std::vector<std::string>> lines = {{metric}};
  for (const std::string& sequence : figures.sequences()) lines[0].push_back(sequence);
  for (std::size_t m = 0; m < study.methods.size(); ++m) {
    lines.push_back({study.methods[m].name});
    for (std::size_t s = 0; s < figures.sequences().size(); ++s) {
      lines.back().push_back(median_text(figures.replicates(s, m, metric)));
    }
  }
  std::vector<std::size_t> widths(lines[0].size(), 0);
  for (const auto& line : lines) {
    for (std::size_t i = 0; i < line.size(); ++i) widths[i] = std::max(widths[i], line[i].size());
  }
  std::string text;
  for (const auto& line : lines) {
    text += fmt::format("{:<{}}", line[0], widths[0]);
    for (std::size_t i = 1; i < line.size(); ++i) text += fmt::format("  {:>{}}", line[i], widths[i]);
    text += '\n';
  }
  return text;
}

void StudyDisplay::on_line(const std::string& line) {
  if (quiet_) return;
  clear();
  tell(line);
}

void StudyDisplay::on_progress(const experiment::StudyProgress& progress) {
  if (!terminal_) return;
  clear();
  const std::string text = display_text(progress, terminal_width() - 1);
  show_block(text);
  drawn_ = static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n')) + 1;
}

bool StudyDisplay::stop_requested() { return interrupted(); }

void StudyDisplay::clear() {
  if (drawn_ > 0) clear_block(drawn_);
  drawn_ = 0;
}

}  // namespace aslio::cli
