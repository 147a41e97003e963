#include "study_judge.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstring>
#include <fstream>

namespace aslio::experiment {

namespace {

namespace fs = std::filesystem;

constexpr int kBadDataExit = 3, kDegradedExit = 4;
constexpr std::array<std::string_view, 6> kStatuses = {"ok",        "degraded", "diverged",
                                                       "truncated", "failed",   "interrupted"};

/// First complaint in a log; empty when there is none.
std::string complaint(const fs::path& log) {
  std::ifstream stream(log);
  for (std::string line; std::getline(stream, line);) {
    if (line.starts_with("error: ")) return line.substr(7);
  }
  return {};
}

/// The same program faults again on the same data. What came from outside (the system's own memory limit: SIGKILL) may
/// not, nor what is a matter of the machine: an instruction it does not have (SIGILL), a file that it lost (SIGBUS).
bool is_fault(int signal) { return signal == SIGSEGV || signal == SIGABRT || signal == SIGFPE || signal == SIGSYS; }

/// Outcome of a child that ended by itself.
StudyOutcome judge_exit(const ChildEnd& end, const fs::path& folder, const fs::path& log) {
  const auto failed = [](std::string reason) {
    return StudyOutcome{.status = "failed", .reason = std::move(reason), .wall_s = 0, .final = false};
  };
  const auto summary = read_summary_outcome(folder);
  std::error_code ignored;
  if (!summary && fs::exists(folder / "summary.json", ignored)) {
    return failed(fmt::format("its summary.json is none (exit code {})", end.code));
  }
  if (!summary) return failed(exit_text(end, log));
  if (std::find(kStatuses.begin(), kStatuses.end(), summary->status) == kStatuses.end()) {
    return failed(fmt::format("its summary.json has the unknown status '{}'", summary->status));
  }
  const bool good = summary->good();
  if (good && end.code == kBadDataExit) {
    // It ran, and there is nothing to compare it by.
    return failed("it could not be measured: " + (summary->reason.empty() ? exit_text(end, log) : summary->reason));
  }
  if (good && end.code != (summary->status == "ok" ? 0 : kDegradedExit)) {
    return failed(fmt::format("its summary.json says {}, its exit code is {}", summary->status, end.code));
  }
  StudyOutcome outcome = *summary;
  // What could not be read or written may be a matter of this machine, today.
  outcome.final = end.code != kBadDataExit || outcome.status != "failed";
  return outcome;
}

}  // namespace

std::string exit_text(const ChildEnd& end, const fs::path& log) {
  if (end.cause == ChildEnd::Cause::signal) {
    const char* name = ::sigdescr_np(end.code);
    return fmt::format("ended by signal {} ({})", end.code, name != nullptr ? name : "unknown");
  }
  const std::string text = complaint(log);
  return text.empty() ? fmt::format("exit code {} without a complaint", end.code) : text;
}

StudyOutcome judge_run(const ChildEnd& end, const fs::path& folder, const fs::path& log, const StudyConfig& config) {
  StudyOutcome outcome;
  switch (end.cause) {
    case ChildEnd::Cause::time_limit:
      outcome.status = "timeout";
      outcome.reason = fmt::format("longer than {:g} s", config.time_limit);
      outcome.limit = config.time_limit;
      outcome.final = true;
      break;
    case ChildEnd::Cause::memory_limit:
      outcome.status = "memory";
      outcome.reason = fmt::format("more than {:g} MB", config.memory_limit);
      outcome.limit = config.memory_limit;
      outcome.final = true;
      break;
    case ChildEnd::Cause::signal:
      outcome.status = "crashed";
      outcome.reason = exit_text(end, log);
      outcome.final = is_fault(end.code);
      break;
    case ChildEnd::Cause::exit:
      outcome = judge_exit(end, folder, log);
      break;
  }
  outcome.wall_s = end.wall_s;
  return outcome;
}

}  // namespace aslio::experiment
