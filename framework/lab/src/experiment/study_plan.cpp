// The runs of a study, what identifies each, and which a glob selects.
#include <fmt/format.h>
#include <fnmatch.h>

#include <algorithm>
#include <cctype>

#include "aslio/config/document.hpp"
#include "aslio/config/node.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/core/sha256.hpp"
#include "aslio/experiment/study.hpp"

namespace aslio::experiment {

namespace {

constexpr const char* kData = "{data}";

/// `path` inside a double-quoted YAML text.
std::string escaped(const std::filesystem::path& path) {
  std::string out;
  for (const char c : path.string()) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out;
}

void replace_all(std::string& text, const std::string& placeholder, const std::string& value) {
  for (std::size_t at = text.find(placeholder); at != std::string::npos;
       at = text.find(placeholder, at + value.size())) {
    text.replace(at, placeholder.size(), value);
  }
}

std::filesystem::path data_folder(const Study& study, const StudyRun& run, const std::filesystem::path& runs_folder) {
  return runs_folder.parent_path() / "data" / study.data[run.data].name;
}

/// Might this value be the path of a file? Numbers and names of types are not.
bool like_a_path(const std::string& text) {
  const bool letter = std::any_of(text.begin(), text.end(), [](unsigned char c) { return std::isalpha(c) != 0; });
  return letter && text.find_first_of("./") != std::string::npos;
}

void append_paths(const config::Node& node, std::vector<std::string>& paths) {
  for (const config::Node& item : node.items()) append_paths(item, paths);
  for (const config::Member& member : node.members()) append_paths(member.value, paths);
  if (node.is_scalar() && like_a_path(node.text())) paths.push_back(node.text());
}

bool matches(const std::string& glob, const std::string& text) { return ::fnmatch(glob.c_str(), text.c_str(), 0) == 0; }

/// By this program, which measures the run, and by the files of the other one.
std::string external_key(const Study& study, const StudyRun& run, std::string_view program) {
  const StudyMethod& method = study.methods[run.method];
  const StudyData& data = study.data[run.data];
  std::string text = fmt::format("aslio external\n{}\n{}\norder seed {}\n{}\n", program, data.identity, run.order_seed,
                                 method.resolved);
  ExternalPlaces places;
  places.data = data.name;
  places.sequence = data.sequence;
  places.seed = fmt::to_string(run.order_seed);
  for (const std::filesystem::path& file : files_of(*method.external, places))
    text += "file " + sha256_of_file(file) + "\n";
  std::error_code error;
  const auto size = std::filesystem::file_size(method.external->image, error);
  if (!error) {
    const auto written = std::filesystem::last_write_time(method.external->image, error).time_since_epoch().count();
    text += fmt::format("image {} {}\n", size, written);
  }
  return sha256_of(text);
}

}  // namespace

std::string run_folder(const std::string& method, std::uint64_t order_seed) {
  return order_seed == 0 ? method : fmt::format("{}_order_{}", method, order_seed);
}

std::vector<std::string> paths_in(const std::string& resolved) {
  std::vector<std::string> paths;
  append_paths(config::parse_document(resolved, "resolved"), paths);
  return paths;
}

void require_unchanged(const Study& study, const std::vector<std::filesystem::path>& sources) {
  for (const std::filesystem::path& source : sources) {
    const auto read = study.sources.find(source);
    if (read == study.sources.end() || sha256_of_file(source) == read->second) continue;
    throw DataError(
        fmt::format("{}: has changed while its study was at work. Call the study again: it keeps the finished runs "
                    "that do not differ and repeats the others",
                    source.string()));
  }
}

std::string run_key(const Study& study, const std::vector<StudyRun>& runs, const StudyRun& run,
                    std::string_view program, const std::filesystem::path& runs_folder) {
  const StudyMethod& method = study.methods[run.method];
  if (method.external) return external_key(study, run, program);
  std::string text = fmt::format("aslio run\n{}\n{}\norder seed {}\n{}\n", program, study.data[run.data].identity,
                                 run.order_seed, method.resolved);
  // Where a run reads files of other runs, their keys stand for those: a change there is a change here.
  for (const std::size_t used : run.uses) text += runs[used].key + "\n";
  if (study.config.stop_when_diverged) text += "stop when diverged\n";
  for (const std::string& output : study.config.outputs) text += "output " + output + "\n";
  for (std::string path : method.paths) {
    replace_all(path, kData, data_folder(study, run, runs_folder).string());
    std::error_code ignored;
    if (std::filesystem::is_regular_file(path, ignored)) text += "file " + sha256_of_file(path) + "\n";
  }
  return sha256_of(text);
}

void append_runs(const Study& study, std::string_view program, const std::filesystem::path& runs_folder,
                 std::size_t data, std::vector<StudyRun>& runs) {
  for (const std::uint64_t order_seed : study.order_seeds) {
    const std::size_t first = runs.size();
    for (std::size_t m = 0; m < study.methods.size(); ++m) {
      StudyRun run{.data = data, .method = m, .order_seed = order_seed, .folder = {}, .key = {}, .uses = {}};
      run.folder = run_folder(study.methods[m].name, order_seed);
      for (const auto& [name, used] : study.methods[m].uses) run.uses.push_back(first + used);
      run.key = run_key(study, runs, run, program, runs_folder);
      runs.push_back(std::move(run));
    }
  }
}

std::vector<StudyRun> plan_runs(const Study& study, std::string_view program,
                                const std::filesystem::path& runs_folder) {
  std::vector<StudyRun> runs;
  for (std::size_t d = 0; d < study.data.size(); ++d) append_runs(study, program, runs_folder, d, runs);
  return runs;
}

std::vector<std::string> overrides_of(const Study& study, const std::vector<StudyRun>& runs, const StudyRun& run,
                                      const std::filesystem::path& runs_folder) {
  std::vector<std::string> overrides = study.methods[run.method].set;
  const std::string& data = study.data[run.data].name;
  const auto& uses = study.methods[run.method].uses;
  for (std::string& text : overrides) {
    replace_all(text, kData, escaped(data_folder(study, run, runs_folder)));
    for (std::size_t k = 0; k < uses.size(); ++k) {
      replace_all(text, fmt::format("{{run:{}}}", uses[k].first),
                  escaped(runs_folder / data / runs[run.uses[k]].folder));
    }
  }
  return overrides;
}

void require_selection(const Study& study, const std::string& glob) {
  if (glob.empty()) return;
  for (const StudyData& data : study.data) {
    if (matches(glob, data.name)) return;
    for (const StudyMethod& method : study.methods) {
      if (matches(glob, method.name)) return;
      for (const std::uint64_t seed : study.order_seeds) {
        if (matches(glob, data.name + "/" + run_folder(method.name, seed))) return;
      }
    }
  }
  throw ConfigError(fmt::format("--only {}: matches none of {} runs; --dry-run without it lists them", glob,
                                study.data.size() * study.methods.size() * study.order_seeds.size()));
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
