// What two methods differ in, and whether the study names it.
#include <algorithm>

#include "aslio/config/diff.hpp"
#include "aslio/experiment/study.hpp"

namespace aslio::experiment {

namespace {

bool within(const std::string& path, const std::string& block) {
  return path.starts_with(block) && (path.size() == block.size() || path[block.size()] == '.');
}

/// A key names what lies below it; the type of a block names the change of the block that comes with it.
bool names(const std::vector<std::string>& keys, const std::string& path) {
  return std::any_of(keys.begin(), keys.end(),
                     [&](const std::string& key) { return within(path, key) || key == path + ".type"; });
}

void append_keys(const StudyMethod& method, std::vector<std::string>& keys) {
  for (const std::string& assignment : method.set) keys.push_back(assignment.substr(0, assignment.find('=')));
  keys.insert(keys.end(), method.differs.begin(), method.differs.end());
}

}  // namespace

std::vector<std::string> differing_keys(const StudyMethod& method, const StudyMethod& baseline) {
  std::vector<std::string> keys;
  for (const config::Difference& difference : config::diff(baseline.resolved, method.resolved)) {
    keys.push_back(difference.path);
  }
  return keys;
}

std::vector<std::string> unnamed_keys(const StudyMethod& method, const StudyMethod& baseline) {
  std::vector<std::string> named, out;
  append_keys(method, named);
  append_keys(baseline, named);
  for (const std::string& key : differing_keys(method, baseline)) {
    if (!names(named, key)) out.push_back(key);
  }
  return out;
}

}  // namespace aslio::experiment
