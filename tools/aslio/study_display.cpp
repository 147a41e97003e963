#include "study_display.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "console.hpp"
#include "interrupt.hpp"

namespace aslio::cli {

namespace {

constexpr std::size_t kBar = 24;
constexpr std::size_t kMostShown = 12;  // of what is at work

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
  for (std::size_t i = 0; i < std::min(p.active.size(), kMostShown); ++i) {
    add(fmt::format("  {:>7}  {}", duration(p.active[i].since_s), p.active[i].name));
  }
  if (p.active.size() > kMostShown) add(fmt::format("           and {} more", p.active.size() - kMostShown));
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
