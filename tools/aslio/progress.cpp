#include "progress.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "console.hpp"
#include "interrupt.hpp"

namespace aslio::cli {

namespace {

constexpr int kBarWidth = 24;
/// Length of a "tenth" where the length of the data is not known [s].
constexpr double kUnknownTenth = 10.0;

std::string bar_of(double share) {
  const int full = static_cast<int>(std::clamp(share, 0.0, 1.0) * kBarWidth);
  std::string bar(static_cast<std::size_t>(full), '=');
  if (full < kBarWidth) bar += '>';
  bar.resize(kBarWidth, ' ');
  return "[" + bar + "]";
}

}  // namespace

std::string progress_line(const experiment::Progress& p, bool bar) {
  std::string line;
  if (bar && p.duration_s && *p.duration_s > 0) line += bar_of(p.data_s / *p.duration_s) + " ";
  line += p.duration_s ? fmt::format("{:.1f} / {:.1f} s", p.data_s, *p.duration_s) : fmt::format("{:.1f} s", p.data_s);
  if (p.wall_s > 0) line += fmt::format("   {:.1f}x real time", p.data_s / p.wall_s);
  line += p.overlap ? fmt::format("   SOD {:.2f}", *p.overlap) : "   SOD -";
  if (p.rate_hz > 0) line += fmt::format("   {:.1f} Hz", p.rate_hz);
  return line;
}

void ProgressDisplay::on_start(const io::SourceNotes& notes) {
  if (!quiet_) {
    for (const std::string& verdict : notes.verdicts) tell(verdict);
  }
  for (const std::string& warning : notes.warnings) tell("warning: " + warning);
}

void ProgressDisplay::on_progress(const experiment::Progress& p) {
  if (quiet_) return;
  if (terminal_) return show_bar(progress_line(p, true));
  const double tenth = p.duration_s && *p.duration_s > 0 ? *p.duration_s / 10.0 : kUnknownTenth;
  const int reached = static_cast<int>(p.data_s / tenth);
  if (reached <= tenths_) return;
  tenths_ = reached;
  tell(progress_line(p, false));
}

bool ProgressDisplay::stop_requested() { return interrupted(); }

}  // namespace aslio::cli
