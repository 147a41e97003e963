// The rules of `expectation`: what they may say, and what the runs say to them.
#include "aslio/experiment/study_expectation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

namespace aslio::experiment {

namespace {

using Rule = StudyExpectationConfig;

/// How often the claim came true, and how often that is still open.
struct Count {
  std::size_t won = 0, of = 0, missing = 0;
};

std::optional<std::size_t> index_of(const std::vector<std::string>& names, const std::string& name) {
  const auto at = std::find(names.begin(), names.end(), name);
  return at != names.end() ? std::optional(static_cast<std::size_t>(at - names.begin())) : std::nullopt;
}

std::optional<std::size_t> method_of(const Study& study, const std::string& name) {
  for (std::size_t m = 0; m < study.methods.size(); ++m) {
    if (study.methods[m].name == name) return m;
  }
  return std::nullopt;
}

std::optional<std::size_t> take_number(std::string_view& text) {
  std::size_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc()) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return value;
}

bool take(std::string_view& text, std::string_view word) {
  if (!text.starts_with(word)) return false;
  text.remove_prefix(word.size());
  return true;
}

/// Names of the sequences, in the order of the study file.
std::vector<std::string> sequences_of(const Study& study) {
  std::vector<std::string> names;
  for (const StudyData& data : study.data) {
    if (!index_of(names, data.sequence)) names.push_back(data.sequence);
  }
  return names;
}

bool concerns(const Rule& rule, const std::string& sequence) {
  return rule.sequences.empty() || index_of(rule.sequences, sequence);
}

/// Sequences or pairs that a rule is about.
std::size_t extent(const Study& study, const Rule& rule, bool pairs) {
  std::size_t count = 0;
  if (!pairs) {
    for (const std::string& sequence : sequences_of(study)) count += concerns(rule, sequence) ? 1 : 0;
    return count;
  }
  for (const StudyData& data : study.data) count += concerns(rule, data.sequence) ? 1 : 0;
  return count;
}

/// What a comparison asks for.
struct Asked {
  std::string_view key;
  std::string text;
  bool lower = true, negated = false;
};

Asked asked(const Rule& rule) {
  if (!rule.lower_on.empty()) return {"lower_on", rule.lower_on, true, false};
  if (!rule.higher_on.empty()) return {"higher_on", rule.higher_on, false, false};
  if (!rule.not_lower_on.empty()) return {"not_lower_on", rule.not_lower_on, true, true};
  return {"not_higher_on", rule.not_higher_on, false, true};
}

/// "8 of 9 sequences" of a study that has another number of them.
void check_count(const Study& study, const Rule& rule, bool other_seeds,
                 const std::function<void(std::string_view, const std::string&)>& complain) {
  const Asked what = asked(rule);
  const auto count = parse_required_count(what.text);
  if (!count || count->of == 0 || (count->pairs && other_seeds)) return;
  const std::size_t there = extent(study, rule, count->pairs);
  if (count->of == there) return;
  complain(what.key, fmt::format("'{}': there are {} {}", what.text, there, count->pairs ? "pairs" : "sequences"));
}

class Judge {
 public:
  Judge(const Study& study, const std::vector<StudyRun>& runs, const std::vector<std::optional<StudyRow>>& rows,
        const StudyFigures& figures)
      : study_(study), runs_(runs), rows_(rows), figures_(figures) {}

  JudgedRule judge(const Rule& rule) const {
    JudgedRule out = rule.failures ? judge_failures(rule) : judge_lower(rule);
    if (!rule.claim.empty()) out.text = one_line(rule.claim) + ": " + out.text;
    return out;
  }

 private:
  using Wins = std::function<bool(double, double)>;

  bool good(std::size_t run) const { return rows_[run]->good(); }

  JudgedRule judge_failures(const Rule& rule) const {
    std::size_t failed = 0, missing = 0, all = 0;
    for (std::size_t i = 0; i < runs_.size(); ++i) {
      if (study_.methods[runs_[i].method].name != rule.method) continue;
      if (!concerns(rule, study_.data[runs_[i].data].sequence)) continue;
      ++all;
      missing += rows_[i] ? 0 : 1;
      failed += rows_[i] && !good(i) ? 1 : 0;
    }
    const auto most = static_cast<std::size_t>(*rule.failures);
    JudgedRule out;
    out.text = fmt::format("{} fails or diverges on {} of {} runs, {} allowed", rule.method, failed, all, most);
    if (failed > most) {
      out.verdict = Verdict::does_not_hold;
    } else if (failed + missing <= most || missing == 0) {
      out.verdict = Verdict::holds;
    } else {
      out.open = missing_runs(missing);
    }
    return out;
  }

  JudgedRule judge_lower(const Rule& rule) const {
    const Asked what = asked(rule);
    const bool negated = what.negated;
    const RequiredCount required = *parse_required_count(what.text);
    const std::size_t a = *method_of(study_, rule.method), b = *method_of(study_, rule.against);
    const auto won = [&](double mine, double other) {
      return what.lower ? mine < rule.times * other : mine > rule.times * other;
    };
    const Count count = required.pairs ? count_pairs(rule, a, b, won) : count_sequences(rule, a, b, won);
    const std::size_t needed = required.of > 0 ? required.needed : count.of / 2 + 1;
    const std::string unit = std::string(required.pairs ? "pair" : "sequence") + (count.of == 1 ? "" : "s");
    JudgedRule out;
    out.text = fmt::format(
        "{} of {} {} {}that of {} on {} of {} {}, {}", rule.metric, rule.method, what.lower ? "below" : "above",
        rule.times == 1 ? "" : fmt::format("{:g} times ", rule.times), rule.against, count.won, count.of, unit,
        negated ? fmt::format("must not on {}", needed) : fmt::format("needs {}", needed));
    if (required.of > 0 && required.of != count.of) {
      out.open = fmt::format("the rule is about {} {}", required.of, unit);
    } else if (count.won >= needed) {
      out.verdict = negated ? Verdict::does_not_hold : Verdict::holds;
    } else if (count.won + count.missing < needed) {
      out.verdict = negated ? Verdict::holds : Verdict::does_not_hold;
    } else {
      out.open = fmt::format("{} of {} {} without all figures yet", count.missing, count.of, unit);
    }
    return out;
  }

  /// By medians. A sequence with runs that are missing, or that have no such figure, is open.
  Count count_sequences(const Rule& rule, std::size_t a, std::size_t b, const Wins& won) const {
    Count count;
    const auto planned = [&](std::size_t sequence) {
      std::size_t runs = 0;
      for (const StudyData& data : study_.data) {
        runs += data.sequence == figures_.sequences()[sequence] ? study_.order_seeds.size() : 0;
      }
      return runs;
    };
    for (std::size_t s = 0; s < figures_.sequences().size(); ++s) {
      if (!concerns(rule, figures_.sequences()[s])) continue;
      ++count.of;
      const Replicates mine = figures_.replicates(s, a, rule.metric), other = figures_.replicates(s, b, rule.metric);
      if (std::min(mine.runs, other.runs) < planned(s) || no_place(rule, mine.failed + other.failed > 0)) {
        ++count.missing;
      } else {
        count.won += won(*mine.median(), *other.median()) ? 1 : 0;
      }
    }
    return count;
  }

  /// A pair is a recording, with the medians over the order seeds. It is open while any of its runs is missing.
  Count count_pairs(const Rule& rule, std::size_t a, std::size_t b, const Wins& won) const {
    Count count;
    for (std::size_t d = 0; d < study_.data.size(); ++d) {
      if (!concerns(rule, study_.data[d].sequence)) continue;
      ++count.of;
      const Pair pair = figures_.pair(d, a, b, rule.metric);
      const bool failed = pair.value == kFailedFigure || pair.baseline == kFailedFigure;
      if (pair.seeds < study_.order_seeds.size() || no_place(rule, failed)) {
        ++count.missing;
      } else {
        count.won += won(*pair.value, *pair.baseline) ? 1 : 0;
      }
    }
    return count;
  }

  /// A failed run is worse than any figure, which is larger where smaller is better; among other figures it has no
  /// place, neither as a low coverage nor as a high one.
  static bool no_place(const Rule& rule, bool failed) { return failed && !smaller_is_better(rule.metric); }

  static std::string missing_runs(std::size_t count) {
    return fmt::format("{} run{} missing", count, count == 1 ? " is" : "s are");
  }

  const Study& study_;
  const std::vector<StudyRun>& runs_;
  const std::vector<std::optional<StudyRow>>& rows_;
  const StudyFigures& figures_;
};

}  // namespace

std::optional<RequiredCount> parse_required_count(std::string_view text) {
  RequiredCount count;
  if (!take(text, "most ")) {
    const auto needed = take_number(text);
    const bool of = take(text, " of ");
    const auto all = take_number(text);
    if (!needed || !of || !all || *needed == 0 || *needed > *all || !take(text, " ")) return std::nullopt;
    count.needed = *needed;
    count.of = *all;
  }
  count.pairs = text == "pairs";
  return count.pairs || text == "sequences" ? std::optional(count) : std::nullopt;
}

std::string_view to_text(Verdict verdict) {
  switch (verdict) {
    case Verdict::holds:
      return "holds";
    case Verdict::does_not_hold:
      return "does not hold";
    case Verdict::not_decided:
      break;
  }
  return "not decided";
}

void check_expectation(
    const Study& study, bool other_seeds,
    const std::function<void(std::size_t rule, std::string_view key, const std::string& message)>& complain) {
  const std::vector<std::string> sequences = sequences_of(study);
  for (std::size_t i = 0; i < study.config.expectation.size(); ++i) {
    const Rule& rule = study.config.expectation[i];
    const auto a = method_of(study, rule.method), b = method_of(study, rule.against);
    if (!a) complain(i, "method", fmt::format("no method is called '{}'", rule.method));
    if (!rule.failures && !b) complain(i, "against", fmt::format("no method is called '{}'", rule.against));
    if (a && a == b) complain(i, "against", fmt::format("'{}' against itself", rule.method));
    for (const std::string& sequence : rule.sequences) {
      if (index_of(sequences, sequence)) continue;
      complain(i, "sequences",
               fmt::format("no sequence is called '{}'; there are: {}", sequence, fmt::join(sequences, ", ")));
    }
    check_count(study, rule, other_seeds,
                [&](std::string_view key, const std::string& message) { complain(i, key, message); });
    if (!a || !b) continue;
    const std::vector<std::string> unnamed = unnamed_keys(study.methods[*a], study.methods[*b]);
    if (unnamed.empty()) continue;
    complain(i, "against",
             fmt::format("'{}' differs from '{}' in keys that the study does not name: set these alike, or add them to "
                         "the `differs` of one of them: {}",
                         rule.method, rule.against, fmt::join(unnamed, ", ")));
  }
}

std::vector<JudgedRule> judge_expectation(const Study& study, const std::vector<StudyRun>& runs,
                                          const std::vector<std::optional<StudyRow>>& rows,
                                          const StudyFigures& figures) {
  std::vector<JudgedRule> out;
  const Judge judge(study, runs, rows, figures);
  for (const Rule& rule : study.config.expectation) out.push_back(judge.judge(rule));
  return out;
}

Verdict overall(const std::vector<JudgedRule>& rules) {
  const auto any = [&](Verdict verdict) {
    return std::any_of(rules.begin(), rules.end(), [&](const JudgedRule& rule) { return rule.verdict == verdict; });
  };
  if (any(Verdict::does_not_hold)) return Verdict::does_not_hold;
  return any(Verdict::not_decided) || rules.empty() ? Verdict::not_decided : Verdict::holds;
}

std::string one_line(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r\n\v\f";
  std::string out;
  for (std::size_t begin = text.find_first_not_of(kBlank); begin != std::string_view::npos;) {
    const std::size_t end = std::min(text.find_first_of(kBlank, begin), text.size());
    if (!out.empty()) out += ' ';
    out += text.substr(begin, end - begin);
    begin = text.find_first_not_of(kBlank, end);
  }
  return out;
}

std::string to_markdown(const JudgedRule& rule) {
  const std::string open = rule.open.empty() ? "" : fmt::format(" ({})", rule.open);
  return fmt::format("{}: **{}**{}", rule.text, to_text(rule.verdict), open);
}

}  // namespace aslio::experiment
