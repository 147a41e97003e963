// The runs of a study, what identifies each, and which a glob selects.
#include <fmt/format.h>
#include <fnmatch.h>

#include "aslio/core/sha256.hpp"
#include "aslio/experiment/study.hpp"

namespace aslio::experiment {

namespace {

std::string folder_of(const StudyMethod& method, std::uint64_t order_seed) {
  return order_seed == 0 ? method.name : fmt::format("{}_order_{}", method.name, order_seed);
}

/// Where a run reads files of other runs, their keys stand for those: a change there is a change here.
std::string key_of(const Study& study, const std::vector<StudyRun>& runs, const StudyRun& run,
                   std::string_view program) {
  std::string text = fmt::format("aslio run\n{}\n{}\norder seed {}\n{}\n", program, study.data[run.data].identity,
                                 run.order_seed, study.methods[run.method].resolved);
  for (const std::size_t used : run.uses) text += runs[used].key + "\n";
  return sha256_of(text);
}

/// `path` inside a double-quoted YAML text.
std::string escaped(const std::filesystem::path& path) {
  std::string out;
  for (const char c : path.string()) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out;
}

void replace_all(std::vector<std::string>& texts, const std::string& placeholder, const std::string& value) {
  for (std::string& text : texts) {
    for (std::size_t at = text.find(placeholder); at != std::string::npos;
         at = text.find(placeholder, at + value.size())) {
      text.replace(at, placeholder.size(), value);
    }
  }
}

bool matches(const std::string& glob, const std::string& text) { return ::fnmatch(glob.c_str(), text.c_str(), 0) == 0; }

}  // namespace

std::vector<StudyRun> plan_runs(const Study& study, std::string_view program) {
  std::vector<StudyRun> runs;
  for (std::size_t d = 0; d < study.data.size(); ++d) {
    for (const std::uint64_t order_seed : study.order_seeds) {
      const std::size_t first = runs.size();
      for (std::size_t m = 0; m < study.methods.size(); ++m) {
        StudyRun run{.data = d, .method = m, .order_seed = order_seed, .folder = {}, .key = {}, .uses = {}};
        run.folder = folder_of(study.methods[m], order_seed);
        for (const auto& [name, used] : study.methods[m].uses) run.uses.push_back(first + used);
        run.key = key_of(study, runs, run, program);
        runs.push_back(std::move(run));
      }
    }
  }
  return runs;
}

std::vector<std::string> overrides_of(const Study& study, const std::vector<StudyRun>& runs, const StudyRun& run,
                                      const std::filesystem::path& runs_folder) {
  std::vector<std::string> overrides = study.methods[run.method].set;
  const std::string& data = study.data[run.data].name;
  replace_all(overrides, "{data}", escaped(runs_folder.parent_path() / "data" / data));
  const auto& uses = study.methods[run.method].uses;
  for (std::size_t k = 0; k < uses.size(); ++k) {
    replace_all(overrides, fmt::format("{{run:{}}}", uses[k].first),
                escaped(runs_folder / data / runs[run.uses[k]].folder));
  }
  return overrides;
}

std::vector<bool> select_runs(const Study& study, const std::vector<StudyRun>& runs, const std::string& glob) {
  std::vector<bool> selected(runs.size(), glob.empty());
  if (glob.empty()) return selected;
  // What a run uses stands before it.
  for (std::size_t i = runs.size(); i-- > 0;) {
    const StudyRun& run = runs[i];
    const std::string& data = study.data[run.data].name;
    selected[i] = selected[i] || matches(glob, data + "/" + run.folder) || matches(glob, data) ||
                  matches(glob, study.methods[run.method].name);
    if (!selected[i]) continue;
    for (const std::size_t used : run.uses) selected[used] = true;
  }
  return selected;
}

}  // namespace aslio::experiment
