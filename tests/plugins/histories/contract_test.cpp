// What every registered history owes the loop, over random windows with refused updates and gaps.
#include <catch2/catch.hpp>
#include <random>
#include <set>

#include "plugins/allocation_count.hpp"
#include "plugins/build_environment.hpp"
#include "plugins/histories/update_loop.hpp"
#include "plugins/overlaps/one_stage.hpp"
#include "plugins/under_test.hpp"

namespace aslio {
namespace {

using test::kMs;
using test::UpdateLoop;

struct EveryHistory {
  EveryHistory() {
    texts = test::under_test(catalog, HistoryPolicy::family);
    if (test::one_under_test(HistoryPolicy::family)) return;
    for (const std::string& type : catalog.types(HistoryPolicy::family)) {
      if (type == "none") continue;
      texts.push_back("{type: " + type +
                      ", age_taper: 0.05, cap: 1, max_residual: 0.05, refused: by_residual, gate: 2}");
      texts.push_back("{type: " + type + ", self_match_exclusion: true, covariance: new_only, cap: 1000}");
      texts.push_back("{type: " + type + ", self_match_exclusion: false, covariance: joseph}");
    }
  }
  std::unique_ptr<HistoryPolicy> make(const std::string& text) {
    return test::make_stage<HistoryPolicy>(catalog, text, environment.context());
  }
  const plugin::Catalog catalog = test::stages_under_test();
  test::BuildEnvironment environment;
  std::vector<std::string> texts;
};

TimeNs random_shift(std::mt19937_64& random) {
  const std::uint64_t kind = random() % 10;
  if (kind == 0) return static_cast<TimeNs>(100 + random() % 300) * kMs;  // a gap in the stream
  return static_cast<TimeNs>(8 + random() % 93) * kMs;
}

}  // namespace

TEST_CASE("every history: points of accepted updates inside the window, each once, never of a fresh or a left time") {
  EveryHistory every;
  for (const std::string& text : every.texts) {
    CAPTURE(text);
    const auto policy = every.make(text);
    UpdateLoop loop(*policy);
    std::mt19937_64 random(1);
    std::uint32_t forgotten = 0;  // updates up to this one
    std::vector<TimeNs> ends = {0};
    for (int k = 0; k < 400; ++k) {
      const bool accepted = random() % 8 != 0;
      const HistorySelection selection = loop.step(random_shift(random), accepted);
      const WindowPlan& plan = loop.window.plan;
      ends.push_back(plan.end);
      std::set<TimeNs> times;
      bool inside = true, once = true, remembered = true, older = true;
      for (const HistoryPoint& point : loop.selected) {
        inside = inside && point.t > plan.history_begin && point.t <= plan.fresh_begin;
        once = once && times.insert(point.t).second;
        remembered = remembered && point.sequence > forgotten && point.sequence < loop.window.sequence;
        older = older && point.sequence > selection.max_stamp;
      }
      REQUIRE(inside);
      REQUIRE(once);
      REQUIRE(remembered);
      if (selection.max_stamp != 0xffffffff) {
        REQUIRE(older);
        REQUIRE(selection.max_stamp < loop.window.sequence);
        REQUIRE(ends[selection.max_stamp] <= std::max<TimeNs>(plan.history_begin, 0));
      }
      if (!accepted) forgotten = loop.window.sequence;
    }
  }
}

TEST_CASE("every history: no weight without residuals, none below zero, a gate that grows with sigma") {
  EveryHistory every;
  for (const std::string& text : every.texts) {
    CAPTURE(text);
    const auto policy = every.make(text);
    for (const std::size_t fresh : {0U, 1U, 100U, 10000U}) {
      CHECK(policy->weight(fresh, 0) == 0.0);
      for (const std::size_t history : {1U, 50U, 20000U}) {
        CHECK(policy->weight(fresh, history) >= 0.0);
        CHECK(policy->weight(fresh, history) <= 1.0);
      }
    }
    CHECK(policy->gate(0.1) >= policy->gate(0.01));
  }
}

TEST_CASE("every history: the same windows give the same points, and none is allocated after warm-up") {
  EveryHistory every;
  for (const std::string& text : every.texts) {
    CAPTURE(text);
    const auto one = every.make(text), other = every.make(text);
    UpdateLoop first(*one), second(*other);
    for (int k = 0; k < 100; ++k) {
      first.step((8 + k % 7) * kMs, k % 30 != 29);
      second.step((8 + k % 7) * kMs, k % 30 != 29);
      REQUIRE(first.selected.size() == second.selected.size());
      for (std::size_t i = 0; i < first.selected.size(); ++i) {
        REQUIRE(first.selected[i].t == second.selected[i].t);
        REQUIRE(first.selected[i].age_weight == second.selected[i].age_weight);
      }
    }
    const std::size_t before = test::allocation_count();
    for (int k = 0; k < 200; ++k) first.step((8 + k % 7) * kMs, k % 30 != 29);
    CHECK(test::allocation_count() == before);
  }
}

}  // namespace aslio
