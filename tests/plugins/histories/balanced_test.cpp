#include "histories/balanced.hpp"

#include <catch2/catch.hpp>
#include <optional>
#include <set>

#include "histories/none.hpp"
#include "plugins/allocation_count.hpp"
#include "plugins/build_environment.hpp"
#include "plugins/histories/update_loop.hpp"

namespace aslio {
namespace {

using plugins::BalancedHistory;
using plugins::Refused;
using test::kFrame;
using test::kMs;
using test::UpdateLoop;

BalancedHistory balanced(const BalancedHistory::Params& params = {}) {
  test::BuildEnvironment environment;
  return {params, environment.context()};
}

BalancedHistory uncapped() { return balanced({.cap = 1000}); }

}  // namespace

TEST_CASE("with two segments there is no history") {
  BalancedHistory policy = balanced();
  UpdateLoop loop(policy);
  for (int k = 0; k < 5; ++k) CHECK(loop.step(kFrame).points.empty());
}

TEST_CASE("the history is the part of the window before the fresh interval, each point once") {
  BalancedHistory policy = uncapped();
  UpdateLoop loop(policy);
  for (const TimeNs shift : {100, 50, 20, 20, 8, 8, 8, 100, 25, 60, 10}) {
    loop.step(shift * kMs);
    const WindowPlan& plan = loop.window.plan;
    CAPTURE(plan.end);
    const bool first = loop.window.sequence == 1;
    CHECK(loop.selected.size() ==
          (first ? 0U : static_cast<std::size_t>((plan.fresh_begin - plan.history_begin) / kMs)));
    std::set<TimeNs> times;
    for (const HistoryPoint& point : loop.selected) {
      CHECK(point.t > plan.history_begin);
      CHECK(point.t <= plan.fresh_begin);
      CHECK(point.p_W == Vec3(to_seconds(point.t), 1, 2));
      CHECK(point.range == 7.0f);
      CHECK(point.residual == 0.01f);
      CHECK(point.age_weight == 1.0f);
      CHECK(times.insert(point.t).second);
    }
  }
}

TEST_CASE("the weight of the whole history is rho times that of the fresh points") {  // eq. HIS-2
  const BalancedHistory policy = balanced({.rho = 0.5});
  // n = 9: the window is m = 4.5 shifts long, so there are 3.5 history residuals per fresh one and w = rho / (m - 1).
  CHECK(policy.weight(200, 700) == Approx(0.5 / 3.5).epsilon(1e-12));
  CHECK(policy.weight(200, 700) == Approx(0.143).margin(5e-4));
  // n = 3: half as many history points as fresh ones, the clamp acts.
  CHECK(policy.weight(300, 150) == 1.0);
  CHECK(policy.weight(300, 100) == 1.0);
  for (const std::size_t history : {500U, 700U, 5000U}) {
    CHECK(policy.weight(400, history) * static_cast<double>(history) == Approx(0.5 * 400));
  }
  CHECK(policy.weight(100, 0) == 0.0);
  CHECK(policy.weight(0, 100) == 0.0);
}

TEST_CASE("rho = 0 leaves the history out") {
  BalancedHistory policy = balanced({.rho = 0.0});
  UpdateLoop loop(policy);
  for (int k = 0; k < 12; ++k) CHECK(loop.step(20 * kMs).points.empty());
  CHECK(policy.weight(100, 100) == 0.0);
}

TEST_CASE("a history point may match only what was in the map before its window began") {  // eq. HIS-1
  BalancedHistory policy = uncapped();
  UpdateLoop loop(policy);
  std::vector<TimeNs> ends = {0};  // by sequence
  for (const TimeNs shift : {100, 50, 20, 20, 8, 8, 8, 8, 8, 100, 25, 60, 10, 8, 8, 8}) {
    const HistorySelection selection = loop.step(shift * kMs);
    ends.push_back(loop.window.plan.end);
    CAPTURE(loop.window.sequence);
    REQUIRE(selection.max_stamp < loop.window.sequence);
    CHECK(ends[selection.max_stamp] <= std::max<TimeNs>(loop.window.plan.history_begin, 0));
    CHECK(ends[selection.max_stamp + 1] > loop.window.plan.history_begin);
    // So neither the point itself nor a sibling of its slice is ever among its neighbours.
    for (const HistoryPoint& point : loop.selected) CHECK(point.sequence > selection.max_stamp);
  }
}

TEST_CASE("in a new room without old neighbours nothing is admissible to the history") {
  BalancedHistory policy = balanced();
  UpdateLoop loop(policy);
  for (int k = 0; k < 4; ++k) CHECK(loop.step(20 * kMs).max_stamp == 0);
}

TEST_CASE("a refused step forgets the points but not what is in the map") {
  BalancedHistory policy = uncapped();
  UpdateLoop loop(policy);
  for (int k = 0; k < 10; ++k) loop.step(20 * kMs);
  REQUIRE(loop.selected.size() == 80);
  loop.step(20 * kMs, false);
  CHECK(loop.step(20 * kMs).points.empty());
  loop.step(20 * kMs);
  REQUIRE(loop.selected.size() == 20);
  // Window 9 ended when this one begins at 180 ms; three windows later the refused one, number 11, counts too: its
  // points may have entered the map all the same.
  CHECK(loop.step(20 * kMs).max_stamp == 9);
  CHECK(loop.step(20 * kMs).max_stamp == 10);
  CHECK(loop.step(20 * kMs).max_stamp == 11);
}

TEST_CASE("the cap bounds the history per fresh point, spread over all of its time") {
  BalancedHistory policy = balanced({.cap = 2.0});
  UpdateLoop loop(policy);
  for (int k = 0; k < 20; ++k) loop.step(10 * kMs);
  REQUIRE(loop.selected.size() == 20);
  CHECK(loop.selected.front().t <= loop.window.plan.history_begin + 5 * kMs);
  CHECK(loop.selected.back().t > loop.window.plan.fresh_begin - 5 * kMs);
  for (std::size_t i = 1; i < loop.selected.size(); ++i) {
    const TimeNs step = loop.selected[i].t - loop.selected[i - 1].t;
    CHECK(step >= 4 * kMs);
    CHECK(step <= 5 * kMs);
  }
}

TEST_CASE("points with a large residual at their own update are left out, those that found no surface are not") {
  const auto refused = GENERATE(Refused::enter, Refused::by_residual);
  BalancedHistory policy = balanced({.cap = 1000, .max_residual = 0.1, .refused = refused});
  UpdateLoop loop(policy);
  loop.begin(50 * kMs);
  loop.matches_[3].residual = 0.2f;
  loop.matches_[4].residual = -0.2f;
  loop.matches_[5].accepted = false;  // by a gate; by its residual it is as good as any
  loop.matches_[6] = {.accepted = false, .residual = 5.0f, .matched = true};
  loop.matches_[7] = {};
  policy.commit(loop.window, loop.update());
  loop.step(50 * kMs);
  const auto residual_at = [&](TimeNs t) -> std::optional<float> {
    for (const HistoryPoint& point : loop.selected) {
      if (point.t == t) return point.residual;
    }
    return std::nullopt;
  };
  const bool enters = refused == Refused::enter;
  REQUIRE(loop.selected.size() == (enters ? 48 : 47));
  CHECK_FALSE((residual_at(4 * kMs) || residual_at(5 * kMs)));
  CHECK(residual_at(6 * kMs) == (enters ? -1.0f : 0.01f));
  CHECK(residual_at(7 * kMs) == (enters ? std::optional(-1.0f) : std::nullopt));
  CHECK(residual_at(8 * kMs) == -1.0f);
}

TEST_CASE("an update that had nothing to match against enters the history without residuals") {
  BalancedHistory policy = uncapped();
  UpdateLoop loop(policy);
  loop.begin(50 * kMs);
  Update initial = loop.update();
  initial.matches = {};
  policy.commit(loop.window, initial);
  loop.step(50 * kMs);
  REQUIRE(loop.selected.size() == 50);
  for (const HistoryPoint& point : loop.selected) CHECK(point.residual < 0);
}

TEST_CASE("the age taper falls by e per time constant") {  // eq. HIS-4
  BalancedHistory policy = balanced({.cap = 1000, .age_taper = 0.1});
  UpdateLoop loop(policy);
  for (int k = 0; k < 10; ++k) loop.step(20 * kMs);
  for (const HistoryPoint& point : loop.selected) {
    CHECK(point.age_weight == Approx(std::exp(-to_seconds(loop.window.plan.end - point.t) / 0.1)).epsilon(1e-6));
  }
  CHECK(loop.selected.front().age_weight < loop.selected.back().age_weight);
}

TEST_CASE("the gate is three sigma, the covariance rule is handed on") {
  CHECK(balanced().gate(0.03) == Approx(0.09));
  BalancedHistory policy = balanced({.covariance = HistoryCovariance::new_only});
  UpdateLoop loop(policy);
  CHECK(loop.step(20 * kMs).covariance == HistoryCovariance::new_only);
}

TEST_CASE("the history does not allocate after warm-up") {
  BalancedHistory policy = balanced();
  UpdateLoop loop(policy);
  for (int k = 0; k < 60; ++k) loop.step(8 * kMs);
  const std::size_t before = test::allocation_count();
  for (int k = 0; k < 200; ++k) loop.step(8 * kMs);
  CHECK(test::allocation_count() == before);
}

TEST_CASE("none: no points, no weight") {
  test::BuildEnvironment environment;
  plugins::NoHistory policy({}, environment.context());
  UpdateLoop loop(policy);
  for (int k = 0; k < 5; ++k) CHECK(loop.step(20 * kMs).points.empty());
  CHECK(policy.weight(100, 100) == 0.0);
  CHECK(policy.gate(1.0) == 0.0);
}

}  // namespace aslio
