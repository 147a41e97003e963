// `literal` and `full`: all old points of the window, at a weight that does not depend on their number.
#include <catch2/catch.hpp>
#include <cmath>

#include "histories/full.hpp"
#include "histories/literal.hpp"
#include "plugins/build_environment.hpp"
#include "plugins/histories/update_loop.hpp"

namespace aslio {
namespace {

using plugins::FullHistory;
using plugins::LiteralHistory;
using test::kMs;
using test::UpdateLoop;

template <class History>
History make(const typename History::Params& params = {}) {
  test::BuildEnvironment environment;
  return {params, environment.context()};
}

/// All points of the window before the fresh interval, whatever became of them, may match everything in the map.
template <class History>
void check_takes_all(History policy) {
  UpdateLoop loop(policy);
  loop.begin(100 * kMs);
  policy.select(loop.window);
  loop.matches_[95].residual = 0.5f;
  loop.matches_[96].accepted = false;
  policy.commit(loop.window, loop.update());
  for (const TimeNs shift : {8, 8, 20, 8, 50, 8, 8, 8}) {
    const HistorySelection selection = loop.step(shift * kMs);
    const WindowPlan& plan = loop.window.plan;
    CHECK(loop.selected.size() == static_cast<std::size_t>((plan.fresh_begin - plan.history_begin) / kMs));
    CHECK(selection.max_stamp == 0xffffffff);
    CHECK(selection.covariance == HistoryCovariance::all);
    for (const HistoryPoint& point : loop.selected) CHECK(point.age_weight == 1.0f);
  }
  CHECK(std::isinf(policy.gate(0.03)));
}

}  // namespace

TEST_CASE("literal: every old point at half the weight of a fresh one, all counted as evidence, self-matches allowed") {
  check_takes_all(make<LiteralHistory>());
  const auto policy = make<LiteralHistory>();
  for (const std::size_t history : {1U, 100U, 5000U}) CHECK(policy.weight(100, history) == 0.5);
  CHECK(policy.weight(100, 0) == 0.0);
  CHECK(make<LiteralHistory>({.weight = 0.2, .reuse = {}}).weight(100, 100) == 0.2);
}

TEST_CASE("full: every old point like a fresh one") {  // eq. HIS-4
  check_takes_all(make<FullHistory>());
  const auto policy = make<FullHistory>();
  for (const std::size_t history : {1U, 100U, 5000U}) CHECK(policy.weight(100, history) == 1.0);
  CHECK(policy.weight(100, 0) == 0.0);
}

TEST_CASE("literal and full take the rules of balanced where they are asked to") {
  const plugins::Reuse rules{.self_match_exclusion = true,
                             .covariance = HistoryCovariance::joseph,
                             .cap = 1.0,
                             .age_taper = 0.1,
                             .gate = 3.0,
                             .max_residual = 0.005};
  auto full = make<FullHistory>(rules);
  CHECK(full.gate(0.02) == Approx(0.06));
  UpdateLoop strict(full);
  for (int k = 0; k < 20; ++k) CHECK(strict.step(10 * kMs).points.empty());  // all residuals are 1 cm

  auto literal =
      make<LiteralHistory>({.weight = 0.5, .reuse = {.self_match_exclusion = true, .cap = 1.0, .age_taper = 0.1}});
  UpdateLoop loop(literal);
  HistorySelection selection;
  for (int k = 0; k < 20; ++k) selection = loop.step(10 * kMs);
  CHECK(loop.selected.size() == 10);
  CHECK(selection.max_stamp == 10);  // its end is the begin of the window
  CHECK(loop.selected.front().age_weight < loop.selected.back().age_weight);
}

}  // namespace aslio
