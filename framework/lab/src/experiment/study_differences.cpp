// What two methods differ in, and whether the study names it.
#include "study_differences.hpp"

#include <fmt/format.h>
#include <fnmatch.h>

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "aslio/config/diff.hpp"
#include "aslio/config/document.hpp"
#include "aslio/config/names.hpp"

namespace aslio::experiment {

namespace {

bool within(const std::string& path, const std::string& block) {
  return path.starts_with(block) && (path.size() == block.size() || path[block.size()] == '.');
}

bool is_glob(const std::string& name) { return name.find_first_of("*?[") != std::string::npos; }

bool matches(const std::string& glob, const std::string& path) { return ::fnmatch(glob.c_str(), path.c_str(), 0) == 0; }

/// Whether the glob (`estimator.*`, `*.sigma`) matches the path or a block above it.
bool matches_above(const std::string& glob, const std::string& path) {
  for (std::size_t end = path.find('.'); end != std::string::npos; end = path.find('.', end + 1)) {
    if (matches(glob, path.substr(0, end))) return true;
  }
  return matches(glob, path);
}

/// A key names what lies below it; the type of a block names the change of the block that comes with it.
bool names(const std::vector<std::string>& keys, const std::string& path) {
  return std::any_of(keys.begin(), keys.end(), [&](const std::string& key) {
    return within(path, key) || key == path + ".type" || (is_glob(key) && matches_above(key, path));
  });
}

void append_keys(const StudyMethod& method, std::vector<std::string>& keys) {
  for (const std::string& assignment : method.set) keys.push_back(assignment.substr(0, assignment.find('=')));
  keys.insert(keys.end(), method.differs.begin(), method.differs.end());
}

/// Paths of all that lies below `path`, blocks, list elements and keys.
void append_value_paths(const config::Node& node, const std::string& path, std::set<std::string>& paths) {
  const auto append = [&](const std::string& name, const config::Node& below) {
    std::string at = path;
    if (!at.empty()) at += '.';
    at += name;
    append_value_paths(below, at, paths);
    paths.insert(std::move(at));
  };
  for (const config::Member& member : node.members()) append(member.key, member.value);
  for (std::size_t i = 0; i < node.items().size(); ++i) append(std::to_string(i), node.items()[i]);
}

/// Of `names`, those that no pipeline has, each with the key or block that was probably meant (empty: nothing is near).
std::map<std::string, std::string> strange_keys(const std::vector<StudyMethod>& methods,
                                                const std::vector<std::string>& names) {
  std::set<std::string> left(names.begin(), names.end()), paths;
  // A study may have thousands of methods, and what it names stands in the first of them.
  for (std::size_t i = 0; i < methods.size() && !left.empty(); ++i) {
    append_value_paths(config::parse_document(methods[i].resolved, "resolved"), "", paths);
    std::erase_if(left, [&](const std::string& name) {
      const auto matched = [&](const std::string& path) { return matches(name, path); };
      return paths.contains(name) || (is_glob(name) && std::any_of(paths.begin(), paths.end(), matched));
    });
  }
  const std::vector<std::string> known(paths.begin(), paths.end());
  std::map<std::string, std::string> out;
  for (const std::string& name : left) out.emplace(name, config::nearest(name, known));
  return out;
}

}  // namespace

void require_known_differences(const Study& study, const config::Node& root, config::Problems& problems) {
  std::vector<std::string> names;
  std::vector<config::Location> places;
  const auto add = [&](const config::Node& block, const std::vector<std::string>& written) {
    const config::Member* list = block.find("differs");
    for (std::size_t k = 0; k < written.size(); ++k) {
      const bool in_list = list != nullptr && k < list->value.items().size();
      places.push_back(in_list ? list->value.items()[k].at() : list != nullptr ? list->value.at() : block.at());
      names.push_back(written[k]);
    }
  };
  add(root, study.config.differs);
  const config::Member* methods = root.find("methods");
  for (std::size_t i = 0; methods != nullptr && i < study.config.methods.size(); ++i) {
    add(methods->value.items()[i], study.config.methods[i].differs);
  }
  const auto strange = strange_keys(study.methods, names);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto found = strange.find(names[i]);
    if (found == strange.end()) continue;
    const std::string& near = found->second;
    problems.add(places[i], fmt::format("'differs' names '{}', which no pipeline of the study has{}; give a key or "
                                        "a block, as in estimator.sigma or window",
                                        names[i], near.empty() ? "" : fmt::format(" (did you mean '{}'?)", near)));
  }
}

std::vector<std::string> differing_keys(const StudyMethod& method, const StudyMethod& baseline) {
  if (method.external || baseline.external) return {"program"};
  std::vector<std::string> keys;
  for (const config::Difference& difference : config::diff(baseline.resolved, method.resolved)) {
    keys.push_back(difference.path);
  }
  return keys;
}

std::vector<std::string> unnamed_keys(const StudyMethod& method, const StudyMethod& baseline) {
  if (method.external || baseline.external) return {};  // a program of others differs in all
  std::vector<std::string> named, out;
  append_keys(method, named);
  append_keys(baseline, named);
  for (const std::string& key : differing_keys(method, baseline)) {
    if (!names(named, key)) out.push_back(key);
  }
  return out;
}

}  // namespace aslio::experiment
