#include "progress.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

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

std::string progress_line(const Standing& s, bool bar) {
  std::string line;
  if (bar && s.duration_s && *s.duration_s > 0) line += bar_of(s.data_s / *s.duration_s) + " ";
  line += s.duration_s ? fmt::format("{:.1f} / {:.1f} s", s.data_s, *s.duration_s) : fmt::format("{:.1f} s", s.data_s);
  if (s.wall_s > 0) line += fmt::format("   {:.1f}x real time", s.data_s / s.wall_s);
  return line + s.more;
}

void ProgressBar::show(const Standing& s) {
  if (quiet_) return;
  if (terminal_) return show_bar(progress_line(s, true));
  const double tenth = s.duration_s && *s.duration_s > 0 ? *s.duration_s / 10.0 : kUnknownTenth;
  const int reached = static_cast<int>(s.data_s / tenth);
  if (reached <= tenths_) return;
  tenths_ = reached;
  tell(progress_line(s, false));
}

void ProgressBar::clear() const {
  if (!quiet_ && terminal_) clear_bar();
}

void ProgressDisplay::on_notice(const std::string& notice) {
  if (!quiet_) tell("note: " + notice);
}

void ProgressDisplay::on_start(const io::SourceNotes& notes) {
  if (!quiet_) {
    for (const std::string& verdict : notes.verdicts) tell_once(verdict);
  }
  for (const std::string& warning : notes.warnings) tell_once("warning: " + warning);
}

void ProgressDisplay::tell_once(const std::string& line) {
  if (told_.insert(line).second) tell(line);
}

void ProgressDisplay::on_progress(const experiment::Progress& p) {
  std::string more = p.overlap ? fmt::format("   SOD {:.2f}", *p.overlap) : "   SOD -";
  if (p.rate_hz > 0) more += fmt::format("   {:.1f} Hz", p.rate_hz);
  bar_.show({p.data_s, p.duration_s, p.wall_s, std::move(more)});
}

bool ProgressDisplay::stop_requested() { return interrupted(); }

}  // namespace aslio::cli
