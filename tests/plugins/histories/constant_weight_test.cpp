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

TEST_CASE("redeskew: between two updates the IMU moves old points, not the correction") {  // eq. HIS-5
  for (const bool redeskew : {false, true}) {
    CAPTURE(redeskew);
    auto policy = make<LiteralHistory>({.weight = 0.5, .reuse = {.redeskew = redeskew}});
    UpdateLoop loop(policy);
    // The IMU moves 1 m in each of three windows; each update finds the end 0.1 m farther and turned by 0.2 rad.
    NavState before;
    std::vector<Pose> posteriors;
    const Vec3 seen(5, 1, 0.5);  // in W, of every point when it is placed
    for (int k = 0; k < 3; ++k) {
      loop.begin(20 * kMs);
      policy.select(loop.window);
      Update update = loop.update();
      update.prior = before;
      update.prior.p += before.R * Vec3(1, 0, 0);
      update.state = update.prior;
      update.state.p.x() += 0.1;
      update.state.R = update.prior.R * exp_so3(Vec3(0, 0, 0.2));
      std::vector<WorldPoint> points(update.match_points.begin(), update.match_points.end());
      for (WorldPoint& point : points) point.p_W = seen;
      update.match_points = points;
      policy.commit(loop.window, update);
      before = update.state;
      posteriors.push_back(update.state.pose());
    }
    loop.begin(20 * kMs);
    const HistorySelection selection = policy.select(loop.window);
    REQUIRE(selection.points.size() == 60);
    // From the newest posterior one metre back for each window, whatever the corrections were.
    Pose end = posteriors[2];
    for (int k = 2; k >= 0; --k) {
      const auto at = static_cast<std::size_t>(k);
      const Vec3 body = posteriors[at].inverse() * seen;
      const Vec3 expected = redeskew ? end * body : seen;
      CHECK((selection.points[20 * at + 5].p_W - expected).norm() < 1e-12);
      end = end * Pose{Mat3::Identity(), Vec3(-1, 0, 0)};
    }
  }
}

TEST_CASE("redeskew: a refused update begins a chain of its own") {
  auto policy = make<LiteralHistory>({.weight = 0.5, .reuse = {.redeskew = true}});
  UpdateLoop loop(policy);
  const auto update_at = [&](double predicted, double found) {
    loop.begin(20 * kMs);
    policy.select(loop.window);
    Update update = loop.update();
    update.prior.p = Vec3(predicted, 0, 0);
    update.state.p = Vec3(found, 0, 0);
    policy.commit(loop.window, update);
  };
  update_at(1, 1.5);
  loop.step(20 * kMs, false);
  update_at(3, 3);
  update_at(4, 4.25);  // 0.25 m farther than the IMU
  const HistorySelection selection = loop.step(20 * kMs);
  REQUIRE(selection.points.size() == 40);
  for (std::size_t i = 0; i < 40; ++i) {
    const HistoryPoint& point = selection.points[i];
    CHECK(point.p_W.x() == Approx(to_seconds(point.t) + (i < 20 ? 0.25 : 0)));
  }
}

}  // namespace aslio
