// The health of a run from update to update: when it is degraded, recovered, lost, and why.
#include <catch2/catch.hpp>
#include <limits>

#include "aslio/pipeline/tracking.hpp"

using namespace aslio;
using namespace aslio::pipeline;
using Catch::Matchers::Contains;

namespace {

constexpr TimeNs kEpoch = 1'700'000'000 * kSecond;
constexpr TimeNs kTenth = kSecond / 10;

/// Plays updates of 0.1 s.
struct Play {
  Tracking tracking{TrackingLimits{}, 0.1};
  TimeNs t = kEpoch;

  TrackingStatus next(const Update& update) {
    tracking.observe(update, t, t + kTenth);
    t += kTenth;
    return tracking.status();
  }
  TrackingStatus accepted(int times = 1) {
    Update update;
    update.status = UpdateStatus::ok;
    update.accepted = true;
    while (--times > 0) next(update);
    return next(update);
  }
  TrackingStatus refused(int times = 1, UpdateStatus status = UpdateStatus::few_matches) {
    Update update;
    update.status = status;
    while (--times > 0) next(update);
    return next(update);
  }
};

}  // namespace

TEST_CASE("tracking: initialising until the first accepted update") {
  Play play;
  CHECK(play.tracking.status() == TrackingStatus::initialising);
  CHECK(play.next(Update{}) == TrackingStatus::initialising);
  CHECK(play.accepted() == TrackingStatus::ok);
  CHECK_FALSE(play.tracking.divergence());
}

TEST_CASE("tracking: a map that stays empty for longer than max_silence is a divergence that names the likely cause") {
  Play play;
  for (int i = 0; i < 10; ++i) play.next(Update{});
  CHECK_FALSE(play.tracking.divergence());
  play.next(Update{});
  REQUIRE(play.tracking.divergence());
  CHECK(play.tracking.status() == TrackingStatus::lost);
  CHECK(play.tracking.divergence()->reason ==
        "the map is still empty after 1.10 s: no point passed the samplers (range limits?), or insertion 'on_exit' "
        "holds them in a longer window");
}

TEST_CASE("tracking: a refused update degrades, five accepted ones in a row recover") {
  Play play;
  play.accepted(3);
  CHECK(play.refused() == TrackingStatus::degraded);
  CHECK(play.accepted(4) == TrackingStatus::recovering);
  CHECK(play.refused() == TrackingStatus::degraded);
  CHECK(play.accepted(4) == TrackingStatus::recovering);
  CHECK(play.accepted() == TrackingStatus::ok);
  CHECK_FALSE(play.tracking.divergence());
}

TEST_CASE("tracking: a degenerate or unfinished update that was accepted is no refusal") {
  Play play;
  play.accepted();
  for (const UpdateStatus status : {UpdateStatus::degenerate, UpdateStatus::not_converged}) {
    Update update;
    update.status = status;
    update.accepted = true;
    CHECK(play.next(update) == TrackingStatus::ok);
  }
}

TEST_CASE("tracking: silence of more than max_silence is a loss, with moment and reason") {
  Play play;
  play.accepted(3);
  CHECK(play.refused(10) == TrackingStatus::degraded);  // exactly 1.0 s
  REQUIRE_FALSE(play.tracking.divergence());
  CHECK(play.refused() == TrackingStatus::lost);
  REQUIRE(play.tracking.divergence());
  CHECK(play.tracking.divergence()->t == kEpoch + 14 * kTenth);
  CHECK_THAT(play.tracking.divergence()->reason, Contains("no accepted update for 1.10 s") && Contains("few_matches"));
}

TEST_CASE("tracking: an accepted update ends the silence") {
  Play play;
  play.accepted();
  for (int k = 0; k < 5; ++k) {
    play.refused(9);
    play.accepted();
  }
  CHECK_FALSE(play.tracking.divergence());
}

TEST_CASE("tracking: a gap in the data before a refused window counts with that window alone") {
  Play play;
  play.accepted(2);
  play.t += 5 * kSecond;  // the next window begins behind the gap
  play.refused(10);
  CHECK_FALSE(play.tracking.divergence());
}

TEST_CASE("tracking: points without times of their own lie at the end of their window, and silence counts as ever") {
  for (const double period : {0.05, 0.1, 0.2}) {
    CAPTURE(period);
    Tracking tracking(TrackingLimits{}, period);
    tracking.begin(kEpoch);
    Update update;
    update.accepted = true;
    update.status = UpdateStatus::ok;
    tracking.observe(update, kEpoch + kTenth, kEpoch + kTenth);
    update.accepted = false;
    update.status = UpdateStatus::few_matches;
    const TimeNs step = to_ns(period);
    TimeNs t = kEpoch + kTenth, jitter = step / 4;
    while (!tracking.lost() && t < kEpoch + 3 * kSecond) {
      t += step + jitter;
      jitter = -jitter;
      tracking.observe(update, t, t);
    }
    REQUIRE(tracking.lost());
    CHECK(t > kEpoch + kTenth + kSecond);
    CHECK(t <= kEpoch + kTenth + kSecond + 2 * step);
  }
}

TEST_CASE("tracking: nor does a gap between two refused windows count") {
  Play play;
  play.accepted(2);
  play.refused(1);
  play.t += 5 * kSecond;
  play.refused(9);
  CHECK_FALSE(play.tracking.divergence());
  play.refused(1);
  CHECK(play.tracking.divergence());
}

TEST_CASE("tracking: a speed beyond max_speed has diverged, also before the first match") {
  Play play;
  Update update;
  update.state.v = Vec3(36, -48.1, 0);
  CHECK(play.next(update) == TrackingStatus::lost);
  REQUIRE(play.tracking.divergence());
  CHECK(play.tracking.divergence()->t == kEpoch + kTenth);
  CHECK_THAT(play.tracking.divergence()->reason, Contains("60.08 m/s") && Contains("max_speed 60 m/s"));
}

TEST_CASE("tracking: a state that is not finite has diverged, whichever part") {
  const int part = GENERATE(0, 1, 2, 3, 4);
  Play play;
  play.accepted();
  Update update;
  update.accepted = true;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  if (part == 0) update.state.R(1, 2) = nan;
  if (part == 1) update.state.p.x() = nan;
  if (part == 2) update.state.v.y() = nan;
  if (part == 3) update.state.b_w.z() = nan;
  if (part == 4) update.state.b_a.x() = nan;
  CHECK(play.next(update) == TrackingStatus::lost);
  REQUIRE(play.tracking.divergence());
  CHECK_THAT(play.tracking.divergence()->reason, Contains("not finite"));
}

TEST_CASE("tracking: the first divergence is the one that is told") {
  Play play;
  Update update;
  update.state.v = Vec3(61, 0, 0);
  play.next(update);
  update.state.v = Vec3(1e9, 0, 0);
  play.next(update);
  CHECK(play.tracking.divergence()->t == kEpoch + kTenth);
  CHECK_THAT(play.tracking.divergence()->reason, Contains("61.00 m/s"));
}

TEST_CASE("tracking: an accelerometer bias that no sensor has is a degradation, however many updates are accepted") {
  Play play;
  play.accepted(10);
  Update update;
  update.status = UpdateStatus::ok;
  update.accepted = true;
  update.state.b_a = Vec3(0, 1.6, 0);
  for (int i = 0; i < 20; ++i) CHECK(play.next(update) == TrackingStatus::degraded);
  update.state.b_a = Vec3(0, 0.2, 0);
  CHECK(play.next(update) == TrackingStatus::recovering);
  CHECK(play.accepted(4) == TrackingStatus::ok);
}

TEST_CASE("tracking: a run that begins anew is recovering until five updates in a row are accepted") {
  Play play;
  play.accepted(3);
  play.refused(11);
  REQUIRE(play.tracking.lost());
  CHECK(play.tracking.may_restart());
  play.tracking.restart(play.t + kTenth);
  CHECK_FALSE(play.tracking.lost());
  CHECK(play.next(Update{}) == TrackingStatus::recovering);  // the first window, over an empty map
  CHECK(play.accepted(4) == TrackingStatus::recovering);
  CHECK(play.accepted() == TrackingStatus::ok);
  REQUIRE(play.tracking.losses().size() == 1);  // it was lost all the same
  CHECK(play.tracking.divergence() == &play.tracking.losses().front());
  CHECK(play.tracking.divergence()->restarted == kEpoch + 15 * kTenth);
  play.refused(10);
  CHECK_FALSE(play.tracking.lost());  // the silence before does not count
  play.refused();
  CHECK(play.tracking.lost());
  REQUIRE(play.tracking.losses().size() == 2);
  CHECK_FALSE(play.tracking.losses().back().restarted);
}

TEST_CASE("tracking: without IMU readings a run is degraded, and lost where the points leave a direction open") {
  for (const bool open : {false, true}) {
    CAPTURE(open);
    Tracking tracking({}, 0.1);
    TimeNs t = 0;
    tracking.begin(t);
    Update update;
    update.accepted = true;
    update.status = UpdateStatus::ok;
    const auto observe = [&](bool unread, bool unobservable) {
      update.unobservable = unobservable;
      tracking.observe(update, t, t + kTenth, false, unread);
      t += kTenth;
    };
    for (int i = 0; i < 10; ++i) observe(false, true);  // a corridor is no trouble while the IMU reads
    CHECK(tracking.status() == TrackingStatus::ok);
    for (int i = 0; i < 5; ++i) observe(true, false);
    CHECK(tracking.status() == TrackingStatus::degraded);
    for (int i = 0; i < 2; ++i) observe(false, open);
    CHECK(tracking.lost() == open);
    if (open) continue;
    for (int i = 0; i < 5; ++i) observe(false, false);
    CHECK(tracking.status() == TrackingStatus::ok);
    for (int i = 0; i < 10; ++i) observe(false, true);
    CHECK(tracking.status() == TrackingStatus::ok);
  }
}

TEST_CASE("tracking: a gap of more than max_gap is a loss, a shorter one is none") {
  Play play;
  play.accepted(2);
  play.tracking.observe_gap(play.t, play.t + 5 * kSecond);
  CHECK(play.tracking.status() == TrackingStatus::ok);
  play.tracking.observe_gap(play.t, play.t + 5 * kSecond + 1);
  CHECK(play.tracking.lost());
  CHECK(play.tracking.may_restart());
  CHECK(play.tracking.divergence()->reason == "no points for 5.00 s, longer than max_gap 5 s");
  CHECK(play.tracking.divergence()->t == play.t + 5 * kSecond + 1);
}

TEST_CASE("tracking: an IMU that falls silent is a loss from the next moment on") {
  Play play;
  play.accepted(2);
  play.tracking.observe_silent_imu(play.t);
  CHECK(play.tracking.lost());
  CHECK(play.tracking.may_restart());
  CHECK(play.tracking.divergence()->reason == "no IMU data for more than max_gap 5 s from then on");
  CHECK(play.tracking.divergence()->t == play.t + 1);
}

TEST_CASE("tracking: no new start where it cannot help") {
  Play empty, fast, later;
  empty.next(Update{});
  for (int i = 0; i < 10; ++i) empty.next(Update{});
  REQUIRE(empty.tracking.lost());
  CHECK_FALSE(empty.tracking.may_restart());  // range limits
  Update update;
  update.state.v = Vec3(61, 0, 0);
  fast.next(update);
  REQUIRE(fast.tracking.lost());
  CHECK_FALSE(fast.tracking.may_restart());  // units
  later.accepted();
  later.next(update);
  REQUIRE(later.tracking.lost());
  CHECK(later.tracking.may_restart());
}

TEST_CASE("tracking: an update for which no points came is no refusal, but silence") {
  Tracking tracking(TrackingLimits{}, 0.1);
  Update update;
  update.accepted = true;
  update.status = UpdateStatus::ok;
  TimeNs t = kEpoch;
  const auto observe = [&](bool without_view) {
    tracking.observe(update, t, t + kTenth, without_view);
    t += kTenth;
  };
  for (int i = 0; i < 5; ++i) observe(false);
  update.accepted = false;
  update.status = UpdateStatus::few_matches;
  for (int i = 0; i < 9; ++i) {
    observe(true);
    // Longer than a blink it is told.
    CHECK(tracking.status() == (i == 0 ? TrackingStatus::ok : TrackingStatus::degraded));
  }
  for (int i = 0; i < 3; ++i) observe(true);
  CHECK(tracking.lost());
}
