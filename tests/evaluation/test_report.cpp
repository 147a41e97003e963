#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <sstream>

#include "aslio/evaluation/report.hpp"
#include "evaluation/paths.hpp"

namespace {

using namespace aslio;
using namespace aslio::evaluation;
using test::kMs;
using test::sampled;

}  // namespace

TEST_CASE("the JSON holds the headline figures, and no number where there is none") {
  Options options;
  options.distances = {1.0, 500.0};
  const Evaluation e = evaluate(sampled(0, 3 * kSecond, 100 * kMs), sampled(0, 12 * kSecond, 5 * kMs), options);
  const auto json = nlohmann::json::parse(to_json(e).dump());
  CHECK(json["ate_m"].get<double>() == e.ate.translation.rmse);
  CHECK(json["ate_deg"].get<double>() == e.ate.rotation.rmse);
  CHECK(json["end_to_end_m"].get<double>() == e.end_to_end.distance);
  CHECK(json["matched"] == 1.0);
  CHECK(json["covered"].get<double>() == Approx(0.25));
  CHECK(json["counts"]["matched"] == 31);
  REQUIRE(json["rpe"].size() == 3);
  CHECK(json["rpe"][0]["unit"] == "m");
  CHECK(json["rpe"][0]["translation_m"].is_number());
  CHECK(json["rpe"][1]["pairs"] == 0);
  CHECK(json["rpe"][1]["translation_m"].is_null());
  CHECK(json["rpe"][2]["unit"] == "s");
  CHECK(json["ate_turns"].is_null());  // the turn comes at 6 s
  CHECK(json["ate_straight"]["translation_m"]["n"] == 31);
  CHECK(json["alignment"] == "se3");
  CHECK(json["rule"] == "interpolated");
  CHECK(json["warnings"].size() == 1);
}

TEST_CASE("the text is a table whose rows line up") {
  const Evaluation e = evaluate(sampled(0, 12 * kSecond, 100 * kMs), sampled(0, 12 * kSecond, 5 * kMs));
  const std::string text = to_text(e);
  CHECK_THAT(text, Catch::Contains("matched 121 of 121 poses (100.0 %), covered 100.0 %"));
  CHECK_THAT(text, Catch::Contains("end to end: "));
  CHECK(text.back() == '\n');
  std::istringstream lines(text);
  std::string line;
  int rows = 0;
  while (std::getline(lines, line) && !line.starts_with("relative error")) {
    if (line.size() < 3 || (!line.ends_with("  m") && !line.ends_with("  deg"))) continue;
    CHECK(line.find_last_of(' ') == 26 + 6 + 6 * 10 + 1);
    ++rows;
  }
  CHECK(rows == 10);
}
