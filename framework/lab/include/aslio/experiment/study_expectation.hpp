#pragma once
/// What a study expects, judged by its runs.

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "aslio/experiment/study.hpp"
#include "aslio/experiment/study_statistics.hpp"

namespace aslio::experiment {

/// "8 of 9 sequences", "7 of 10 pairs", "most pairs".
struct RequiredCount {
  std::size_t needed = 0, of = 0;  ///< both 0: more than half
  bool pairs = false;              ///< of runs over the same data with the same order seed; else of sequences
};

/// Nothing when the text is none of these.
std::optional<RequiredCount> parse_required_count(std::string_view text);

enum class Verdict : unsigned char { holds, does_not_hold, not_decided };

/// "holds", "does not hold", "not decided".
std::string_view to_text(Verdict verdict);

/// One rule of `expectation`, applied.
struct JudgedRule {
  std::string text;  ///< what is claimed, what was found, what is needed
  Verdict verdict = Verdict::not_decided;
  std::string open;  ///< what is missing; empty unless not decided
};

/// Complaints about the rules of a study whose data and methods are known: rule, key, message.
void check_expectation(
    const Study& study, bool other_seeds,
    const std::function<void(std::size_t rule, std::string_view key, const std::string& message)>& complain);

/// The rules in their order. A rule is decided when no run that is still missing could change its verdict.
std::vector<JudgedRule> judge_expectation(const Study& study, const std::vector<StudyRun>& runs,
                                          const std::vector<std::optional<StudyRow>>& rows,
                                          const StudyFigures& figures);

/// All hold, one does not, or neither can be told.
Verdict overall(const std::vector<JudgedRule>& rules);

/// "TEXT: **holds**", as a line of a Markdown list has it.
std::string to_markdown(const JudgedRule& rule);

/// A text of any number of lines on one, words one space apart: a line break would end an item or a row of a table.
std::string one_line(std::string_view text);

}  // namespace aslio::experiment
