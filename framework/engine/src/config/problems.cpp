#include "aslio/config/problems.hpp"

#include <algorithm>
#include <tuple>

#include "aslio/core/errors.hpp"
#include "scalars.hpp"

namespace aslio::config {

void Problems::add(const Location& at, const std::string& message) { found_.push_back({at, message}); }

void Problems::raise() const {
  if (!found_.empty()) throw ConfigError(text());
}

std::string Problems::text() const {
  std::vector<Problem> sorted = found_;
  std::stable_sort(sorted.begin(), sorted.end(), [](const Problem& a, const Problem& b) {
    return std::tie(a.at.order, a.at.line, a.at.column) < std::tie(b.at.order, b.at.line, b.at.column);
  });
  std::string text;
  for (const Problem& problem : sorted) {
    if (!text.empty()) text += '\n';
    text += printable(problem.at.text() + ": " + problem.message);
  }
  return text;
}

}  // namespace aslio::config
