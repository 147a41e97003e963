// The order of the loop and its traps, seen by stages that watch the real ones.
#include <algorithm>
#include <catch2/catch.hpp>
#include <set>

#include "aslio/core/cpu_clock.hpp"
#include "aslio/simulator/analytic_world.hpp"
#include "pipeline/runs.hpp"
#include "pipeline/spies.hpp"

using namespace aslio;
using namespace aslio::test;

namespace {

using Calls = std::vector<std::string>;

/// Calls per update, and what went into map and history.
class Journal final : public Observer {
 public:
  void before(const std::string& call) override {
    if (call == "select") steps.emplace_back();
    if (call != "next") steps.back().push_back(call);
  }
  void after(const std::string&) override {}
  void on_select(const HistorySelection& past) override {
    history_points += past.points.size();
    for (const HistoryPoint& p : past.points) younger_than_neighbours += p.sequence <= past.max_stamp ? 0U : 1U;
    oldest_first = oldest_first && past.max_stamp < steps.size();
  }
  void on_insert(const Window& window, const Update& update) override {
    for (const WorldPoint& p : update.points(PointUse::map)) {
      const TimedPoint& raw = window.fresh[p.index];
      in_window = in_window && p.t > window.plan.fresh_begin && p.t <= window.plan.end && raw.t == p.t;
      inserted_twice += inserted.insert({p.t, p.line}).second ? 0U : 1U;
    }
  }

  std::vector<Calls> steps;
  std::size_t history_points = 0, younger_than_neighbours = 0, inserted_twice = 0;
  bool oldest_first = true, in_window = true;
  std::set<std::pair<TimeNs, int>> inserted;
};

struct Watched {
  Watched(const std::vector<std::string>& overrides, double seconds) {
    const simulator::AnalyticWorld world({.duration_scale = 0.5});
    const auto source = world.source();
    const plugin::Catalog catalog = spied(built_in_stages(), journal);
    Run watched(shipped("as_lio_plus", overrides, catalog), world.sensor());
    watched.play(record(*source, world.begin_time() + to_ns(seconds)));
    updates = watched.updates;
  }
  Journal journal;
  std::vector<pipeline::UpdateRecord> updates;
};

/// What the overlap is asked to score.
class Scored final : public Observer {
 public:
  void before(const std::string& call) override {
    evaluations += call == "evaluate" ? 1 : 0;
    ahead_ = ahead_ || call == "next";
  }
  void after(const std::string& call) override { ahead_ = ahead_ && call != "next"; }
  void on_evaluate(std::span<const WorldPoint> points) override {
    for (const WorldPoint& p : points) beyond += p.range > 4.0F ? 1 : 0;
    scored += points.size();
    if (ahead_) most_ahead = std::max(most_ahead, points.size());
  }
  std::size_t evaluations = 0, beyond = 0, scored = 0, most_ahead = 0;

 private:
  bool ahead_ = false;  ///< a window is being decided
};

/// What the history lends after the map began anew, and the updates with which it did.
class AfterRestarts final : public Observer {
 public:
  void before(const std::string&) override {}
  void after(const std::string&) override {}
  void on_select(const HistorySelection& past) override {
    for (const HistoryPoint& p : past.points) (p.sequence < restarted_ ? of_before : of_after) += 1;
  }
  void on_insert(const Window& window, const Update& update) override {
    if (!update.restart_map) return;
    restarted_ = window.sequence;
    restarts.insert(restarted_);
  }

  std::size_t of_before = 0, of_after = 0;
  std::set<std::uint32_t> restarts;  ///< by sequence

 private:
  std::uint32_t restarted_ = 0;
};

/// A start in motion at 50 Hz with old points: the map begins anew until the velocity is known.
struct StartInMotion {
  explicit StartInMotion(std::vector<std::string> overrides) {
    overrides.insert(overrides.end(), {"window={type: fixed, period: 0.02, frame_length: 0.1}",
                                       "initialisation.mode=dynamic", "initialisation.register_sweeps=false"});
    const simulator::AnalyticWorld world({.duration_scale = 0.5});
    const auto source = world.source();
    const plugin::Catalog catalog = spied(built_in_stages(), observer);
    Run run(shipped("as_lio_plus", overrides, catalog), world.sensor());
    run.play(record(*source, world.begin_time() + to_ns(1.5)));
    updates = run.updates;
  }
  AfterRestarts observer;
  std::vector<pipeline::UpdateRecord> updates;
};

/// Takes 10 ms of CPU in every call of one name.
class Burner final : public Observer {
 public:
  explicit Burner(std::string call) : call_(std::move(call)) {}
  void before(const std::string& call) override {
    if (call != call_) return;
    const double end = thread_cpu_seconds() + 0.01;
    while (thread_cpu_seconds() < end) {
    }
    burnt += 0.01;
    ++calls;
  }
  void after(const std::string&) override {}

  double burnt = 0;
  std::size_t calls = 0;

 private:
  std::string call_;
};

const Calls kWhole = {"select", "update", "evaluate", "insert", "extend", "commit"};
const Calls kInsertedUnmatched = {"select", "update", "evaluate", "insert", "extend", "reset"};
const Calls kRefused = {"select", "update", "evaluate", "reset"};

}  // namespace

TEST_CASE("the overlap is measured after the update and before the points are merged, each once") {
  const Watched run({}, 4.0);
  REQUIRE(run.updates.size() == run.journal.steps.size());
  REQUIRE(run.updates.size() > 40);
  for (std::size_t k = 0; k < run.updates.size(); ++k) {
    const UpdateStatus status = run.updates[k].status;
    if (status == UpdateStatus::few_matches || status == UpdateStatus::non_finite) continue;
    CHECK(run.journal.steps[k] == kWhole);
  }
  // Each fresh point enters at most once, at its own update; what the history lends may never match its own slice.
  CHECK(run.journal.inserted.size() > 5000);
  CHECK(run.journal.inserted_twice == 0);
  CHECK(run.journal.in_window);
  CHECK(run.journal.history_points > 1000);
  CHECK(run.journal.younger_than_neighbours == run.journal.history_points);
  CHECK(run.journal.oldest_first);
}

TEST_CASE("a refused step forgets the history, and inserts only while dead reckoning is good") {
  const Watched run(
      {"estimator.min_matches=1000000", "estimator.noise=fastlio", "insertion.type=on_new", "when_lost=end"}, 2.0);
  REQUIRE(run.updates.size() == run.journal.steps.size());
  REQUIRE(run.updates.front().status == UpdateStatus::initialising);
  CHECK(run.journal.steps.front() == kWhole);
  std::size_t inserted = 0, refused = 0;
  for (std::size_t k = 1; k < run.updates.size(); ++k) {
    REQUIRE(run.updates[k].status == UpdateStatus::few_matches);
    const bool insert = run.journal.steps[k].size() == kInsertedUnmatched.size();
    CHECK(run.journal.steps[k] == (insert ? kInsertedUnmatched : kRefused));
    if (!insert) CHECK(run.updates[k].map_points == run.updates[k - 1].map_points);
    if (k > 1) CHECK(run.updates[k].n_history == 0);  // the first one is offered points of the initial window
    (insert ? inserted : refused) += 1;
  }
  CHECK(inserted >= 4);
  CHECK(refused >= 2);
}

TEST_CASE("what was placed before the map began anew is not matched against it") {
  const StartInMotion run({"history={type: full}"});
  CHECK(run.observer.restarts.size() > 5);
  CHECK(run.observer.of_after > 10000);
  CHECK(run.observer.of_before == 0);
}

TEST_CASE("samplers know what the update before told") {
  constexpr double known = 0.97;
  const Watched run({"samplers=[{type: stride, keep_every: 4, known: 0.97, warmup: 0}]", "overlap.max_points=0"}, 8.0);
  REQUIRE(run.updates.size() > 100);
  std::size_t thinned = 0, whole = 0;
  for (std::size_t k = 0; k < run.updates.size(); ++k) {
    const pipeline::UpdateRecord& update = run.updates[k];
    const bool thins = k > 0 && run.updates[k - 1].overlap.value.value_or(0.0) >= known &&
                       run.updates[k - 1].status == UpdateStatus::ok;
    CAPTURE(k, thins, update.n_fresh);
    // The index of a point counts over the stream, so that a window has a quarter of its points, rounded either way.
    CHECK(std::abs(4.0 * update.overlap.points - (thins ? 1.0 : 4.0) * update.n_fresh) < 4.0);
    (thins ? thinned : whole) += 1;
  }
  CHECK(thinned > 20);
  CHECK(whole > 20);
}

TEST_CASE("a look ahead asks for the points that the samplers leave to the overlap") {
  Scored ranges;
  const simulator::AnalyticWorld world({.duration_scale = 0.5});
  const auto source = world.source();
  const plugin::Catalog catalog = spied(built_in_stages(), ranges);
  Run run(shipped("as_lio_plus", {"window.lookahead=true", "window.seg_step=0.9", "samplers.0.max=4"}, catalog),
          world.sensor());
  run.play(record(*source, world.begin_time() + to_ns(2.0)));
  CHECK(ranges.evaluations > 2 * run.updates.size());
  CHECK(ranges.scored > 1000);
  CHECK(ranges.beyond == 0);
}

TEST_CASE(
    "a look ahead into a frame that reaches back takes all points: fewer would count for less than the old ones") {
  const simulator::AnalyticWorld world({.duration_scale = 0.5});
  const Recording recording = record(*world.source(), world.begin_time() + to_ns(2.0));
  const auto most = [&](const std::string& points) {
    Scored scored;
    const plugin::Catalog catalog = spied(built_in_stages(), scored);
    Run run(
        shipped("as_lio_plus", {"window.lookahead=true", "window.seg_step=0.9", "overlap.points=" + points}, catalog),
        world.sensor());
    run.play(recording);
    return scored.most_ahead;
  };
  CHECK(most("latest") == 2000);
  CHECK(most("window") > 2000);
}

TEST_CASE("a map that has begun anew knows no view") {
  constexpr double known = 0.001;
  const StartInMotion run(
      {"samplers=[{type: stride, keep_every: 4, known: 0.001, warmup: 0}]", "overlap.max_points=0"});
  std::size_t after_restart = 0, thinned = 0;
  for (std::size_t k = 1; k < run.updates.size(); ++k) {
    const pipeline::UpdateRecord& before = run.updates[k - 1];
    // What would be thinned after, had its map lasted.
    if (before.status != UpdateStatus::ok || before.overlap.value.value_or(0.0) < known) continue;
    const bool whole = run.updates[k].overlap.points == run.updates[k].n_fresh;
    const bool restarted = run.observer.restarts.contains(before.sequence);
    CHECK(whole == restarted);
    (restarted ? after_restart : thinned) += 1;
  }
  CHECK(after_restart > 0);
  CHECK(thinned > 10);
}

TEST_CASE("what the overlap learns is on its account, what enters the map on the map's") {
  const simulator::AnalyticWorld world({.duration_scale = 0.5});
  const auto source = world.source();
  const auto recording = record(*source, world.begin_time() + to_ns(1.5));
  for (const std::string call : {"evaluate", "extend", "insert"}) {
    CAPTURE(call);
    Burner burner(call);
    const plugin::Catalog catalog = spied(built_in_stages(), burner);
    Run run(shipped("as_lio_plus", {}, catalog), world.sensor());
    run.play(recording);
    double overlap = 0, insert = 0;
    for (const pipeline::UpdateRecord& update : run.updates) {
      overlap += update.times.overlap;
      insert += update.times.insert;
    }
    REQUIRE(burner.burnt > 0.1);
    CHECK((call == "insert" ? insert : overlap) >= burner.burnt);
    CHECK((call == "insert" ? overlap : insert) < burner.burnt);
  }
}

TEST_CASE("what it takes to decide on a window is told, also where it is found that more data is needed") {
  const simulator::AnalyticWorld world({.duration_scale = 0.5});
  const auto source = world.source();
  Burner burner("next");
  const plugin::Catalog catalog = spied(built_in_stages(), burner);
  Run run(shipped("as_lio_plus", {}, catalog), world.sensor());
  run.play(record(*source, world.begin_time() + to_ns(1.5)));
  double window = 0;
  for (const pipeline::UpdateRecord& update : run.updates) window += update.times.window;
  REQUIRE(burner.calls > 2 * run.updates.size());
  CHECK(window > burner.burnt - 0.05);  // the last ones decide on no window any more
}

TEST_CASE("the digest of a state tells every part of it") {
  NavState state;
  std::set<std::uint64_t> digests = {pipeline::state_digest(state)};
  const auto changed = [&](auto change) {
    NavState other = state;
    change(other);
    return digests.insert(pipeline::state_digest(other)).second;
  };
  CHECK(changed([](NavState& s) { s.t = 1; }));
  CHECK(changed([](NavState& s) { s.R(2, 1) = 1e-300; }));
  CHECK(changed([](NavState& s) { s.p.z() = 1e-300; }));
  CHECK(changed([](NavState& s) { s.v.z() = 1e-300; }));
  CHECK(changed([](NavState& s) { s.b_w.z() = 1e-300; }));
  CHECK(changed([](NavState& s) { s.b_a.z() = 1e-300; }));
  CHECK(changed([](NavState& s) { s.g.x() = 1e-300; }));
  CHECK(changed([](NavState& s) { s.S_w(2, 1) = 1e-300; }));
  CHECK(changed([](NavState& s) { s.imu_delay = 1e-300; }));
}
