/// `aslio new-plugin`. That what it writes builds, for every family, is tests/plugin/author_test.py.

#include <catch2/catch.hpp>
#include <regex>

#include "child.hpp"

using namespace aslio::test;
using Catch::Matchers::Contains;

namespace fs = std::filesystem;

TEST_CASE("the class of a new plugin has a name of its own") {
  const TemporaryFolder folder;
  const std::vector<std::pair<std::string, std::string>> cases = {{"my_window", "MyWindowStage"},
                                                                  {"params", "ParamsStage"},
                                                                  {"window_plan", "WindowPlanStage"},
                                                                  {"stage", "StageStage"},
                                                                  {"first_stage", "FirstStage"}};
  for (const auto& [name, type] : cases) {
    const Ended ended = run_aslio({"new-plugin", "windows/" + name, folder / name});
    INFO(name << ": " << ended.err);
    REQUIRE(ended.code == 0);
    const std::string header = content(folder / name / (name + ".hpp")),
                      source = content(folder / name / (name + ".cpp"));
    CHECK_THAT(header, Contains("class " + type + " final : public aslio::WindowStrategy {") &&
                           Contains("\n  " + type + "(const Params& params") && Contains("\n  struct Params {"));
    CHECK_THAT(source, Contains(".add<" + type + ">(\"" + name + "\"") && Contains("#include \"" + name + ".hpp\""));
    CHECK(source.find("MyStage") == std::string::npos);
  }
}

TEST_CASE("no type that a plugin sees has the end of the classes of new plugins") {
  const std::regex declared(R"((?:class|struct|enum|union|concept|using)\s+(\w+Stage)\b)");
  std::size_t files = 0;
  for (const char* part : {"framework/engine/include", "framework/toolkit/include", "tools/templates/plugin"}) {
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(ASLIO_SOURCE_DIR) / part)) {
      if (entry.path().extension() != ".hpp" && entry.path().extension() != ".cpp") continue;
      ++files;
      const std::string text = content(entry.path());
      for (auto at = std::sregex_iterator(text.begin(), text.end(), declared); at != std::sregex_iterator(); ++at) {
        INFO(entry.path() << ": " << at->str());
        CHECK((*at)[1] == "MyStage");  // which is replaced
      }
    }
  }
  CHECK(files > 50);
}

TEST_CASE("a new plugin without a folder is refused") {
  const Ended ended = run_aslio({"new-plugin", "windows/x", ""});
  INFO(ended.err);
  CHECK(ended.code == 2);
  CHECK_THAT(ended.err, Contains("the argument after 'windows/x' is empty: give a value"));
}
