/// The studies of this repository.

#include <algorithm>
#include <catch2/catch.hpp>

#include "cli/child.hpp"

using namespace aslio::test;

namespace fs = std::filesystem;

TEST_CASE("every shipped study is valid, with all its scenes, pipelines and overrides") {
  std::vector<std::string> files;
  for (const auto& entry : fs::directory_iterator(fs::path(ASLIO_SOURCE_DIR) / "experiments")) {
    if (entry.path().extension() == ".yaml") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  REQUIRE(files.size() >= 10);
  std::vector<std::string> arguments = {"check"};
  arguments.insert(arguments.end(), files.begin(), files.end());
  const Ended ended = run_aslio(arguments);
  INFO(ended.err);
  CHECK(ended.code == 0);
  CHECK(line_count(files.front()) > 10);
}
