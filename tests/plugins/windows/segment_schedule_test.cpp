#include "windows/segment_schedule.hpp"

#include <catch2/catch.hpp>

using aslio::TimeNs;
using aslio::plugins::Recover;
using aslio::plugins::SegmentSchedule;

namespace {

constexpr TimeNs kFrame = 100'000'000;
constexpr std::int64_t kNoLimit = 1000;

}  // namespace

TEST_CASE("the worked table of overlap, segments, shift and echo") {  // eqs. WIN-1, WIN-2
  struct Row {
    double seg_step, overlap;
    std::int64_t n;
    double shift_ms, hz;
    std::int64_t echo;
  };
  const auto row = GENERATE(values<Row>({{0.1, 1.00, 2, 100.0, 10, 1},
                                         {0.1, 0.95, 2, 100.0, 10, 1},
                                         {0.1, 0.90, 2, 100.0, 10, 1},
                                         {0.1, 0.80, 3, 66.7, 15, 3},
                                         {0.1, 0.50, 6, 33.3, 30, 6},
                                         {0.1, 0.20, 9, 22.2, 45, 9},
                                         {0.1, 0.00, 11, 18.2, 55, 11},
                                         {0.2, 0.95, 2, 100.0, 10, 1},
                                         {0.2, 0.80, 2, 100.0, 10, 1},
                                         {0.2, 0.50, 4, 50.0, 20, 4},
                                         {0.2, 0.20, 5, 40.0, 25, 5},
                                         {0.2, 0.00, 6, 33.3, 30, 6}}));
  CAPTURE(row.seg_step, row.overlap);
  SegmentSchedule schedule(row.seg_step, 2, kNoLimit, Recover::step);
  schedule.observe(row.overlap);
  CHECK(schedule.n() == row.n);
  CHECK(schedule.echo() == row.echo);
  CHECK(1e-6 * static_cast<double>(schedule.shift(kFrame)) == Approx(row.shift_ms).margin(0.05));
  CHECK(1e9 / static_cast<double>(schedule.shift(kFrame)) == Approx(row.hz).epsilon(1e-6));
}

TEST_CASE("the rates of the paper: 10 to 125 Hz") {
  const SegmentSchedule schedule(0.04, 2, 25, Recover::step);
  CHECK(schedule.wanted(0.05) == 25);
  CHECK(schedule.wanted(0.0) == 25);
  CHECK(schedule.wanted(0.97) == 2);
  SegmentSchedule fast(0.04, 2, 25, Recover::step);
  fast.observe(0.05);
  CHECK(fast.shift(kFrame) == 8'000'000);
}

TEST_CASE("rounding does not add a segment") {
  for (int tenths = 0; tenths <= 9; ++tenths) {
    CAPTURE(tenths);
    const SegmentSchedule schedule(0.1, 2, kNoLimit, Recover::step);
    const double overlap = tenths / 10.0;  // (1 - 0.7) / 0.1 is 3.0000000000000004
    CHECK(schedule.wanted(overlap) == std::max(2, 11 - tenths));
    CHECK(schedule.wanted(overlap + 1e-6) == std::max(2, 11 - tenths));
    CHECK(schedule.wanted(overlap - 1e-6) == 12 - tenths);
  }
}

TEST_CASE("an echo spans two frame lengths of stream whatever n") {
  for (std::int64_t n = 3; n <= 25; ++n) {
    CAPTURE(n);
    SegmentSchedule schedule(0.04, 2, n, Recover::step);
    schedule.observe(0.0);
    REQUIRE(schedule.n() == n);
    TimeNs span = 0;
    while (schedule.n() == n) {  // full overlap from now on: only the echo holds n
      span += schedule.shift(kFrame);
      schedule.observe(1.0);
    }
    CHECK(span <= 2 * kFrame);
    CHECK(span > 2 * kFrame - n);
    CHECK(schedule.n() == 2);
  }
}

TEST_CASE("a further drop interrupts the echo at once and re-arms it") {
  SegmentSchedule schedule(0.1, 2, kNoLimit, Recover::step);
  schedule.observe(0.75);
  schedule.observe(0.75);
  REQUIRE(schedule.n() == 4);
  REQUIRE(schedule.echo() == 3);
  schedule.observe(0.35);
  CHECK(schedule.n() == 8);
  CHECK(schedule.echo() == 8);
  schedule.observe(0.25);  // by the least step, too
  CHECK(schedule.n() == 9);
  CHECK(schedule.echo() == 9);
}

TEST_CASE("a drop to the same n neither restarts nor shortens the echo, and a lasting one re-arms it") {
  SegmentSchedule schedule(0.1, 2, kNoLimit, Recover::step);
  for (const std::int64_t echo : {4, 3, 2, 1, 4, 3}) {
    schedule.observe(0.75);
    CHECK(schedule.n() == 4);
    CHECK(schedule.echo() == echo);
  }
}

TEST_CASE("other evidence may ask for a least n, whatever the overlap says") {
  SegmentSchedule schedule(0.1, 2, 5, Recover::step);
  schedule.observe(1.0, 4);
  CHECK(schedule.n() == 4);
  CHECK(schedule.echo() == 4);
  schedule.observe(std::nullopt, 4);  // an undefined overlap asks for nothing: the echo runs on
  CHECK(schedule.n() == 4);
  CHECK(schedule.echo() == 3);
  schedule.observe(0.65, 4);  // the overlap asks for more
  CHECK(schedule.n() == 5);
  SegmentSchedule limited(0.1, 2, 3, Recover::step);
  limited.observe(std::nullopt, 9);
  CHECK(limited.n() == 3);
}

TEST_CASE("a smallest n above two leaves old points in every window, and nothing falls below it") {
  SegmentSchedule schedule(0.1, 4, 9, Recover::step);
  CHECK(schedule.n() == 4);
  CHECK(schedule.shift(aslio::kSecond / 10) == aslio::kSecond / 20);
  schedule.observe(1.0);
  CHECK(schedule.n() == 4);
  schedule.observe(0.5);
  CHECK(schedule.n() == 6);
  for (int i = 0; i < 6; ++i) schedule.observe(1.0);
  CHECK(schedule.n() == 4);
  schedule.observe(0.0);
  CHECK(schedule.n() == 9);
  schedule.restart();
  CHECK(schedule.n() == 4);
  schedule.observe(1.0, 3);  // other evidence asks for less than that
  CHECK(schedule.n() == 4);
}

TEST_CASE("a limit takes n down at once, whoever asks for more, and lets it rise again, with n_min at least") {
  SegmentSchedule schedule(0.1, 2, 25, Recover::step);
  schedule.observe(0.2);  // 9
  schedule.observe(0.2);
  REQUIRE(schedule.n() == 9);
  schedule.limit(6);
  CHECK(schedule.n() == 6);
  CHECK(schedule.echo() == 6);
  CHECK_FALSE(schedule.anticipate(0.0));
  schedule.observe(0.0, 8);
  CHECK(schedule.n() == 6);
  CHECK(schedule.echo() == 5);
  schedule.limit(100);
  schedule.observe(0.0, 8);
  CHECK(schedule.n() == 11);
  schedule.limit(0);
  CHECK(schedule.n() == 2);
  CHECK(schedule.echo() == 1);
}

TEST_CASE("a limit that comes down while an echo runs out does not begin another") {
  SegmentSchedule schedule(0.1, 2, 25, Recover::step);
  schedule.observe(0.2);  // 9
  for (int i = 0; i < 7; ++i) schedule.observe(1.0);
  REQUIRE(schedule.n() == 9);
  REQUIRE(schedule.echo() == 2);
  schedule.limit(8);
  CHECK(schedule.n() == 8);
  CHECK(schedule.echo() == 2);
  schedule.observe(1.0);
  schedule.observe(1.0);
  CHECK(schedule.n() == 2);
}

TEST_CASE("ramp: n falls by one per echo, never below what the overlap asks for") {
  SegmentSchedule schedule(0.1, 2, kNoLimit, Recover::ramp);
  schedule.observe(0.55);
  REQUIRE(schedule.n() == 6);
  for (const std::int64_t n : {5, 4}) {
    const std::int64_t echo = schedule.echo();
    for (std::int64_t k = 0; k < echo; ++k) {
      CHECK(schedule.n() == n + 1);
      schedule.observe(0.75);
    }
    CHECK(schedule.n() == n);
  }
  for (int k = 0; k < 8; ++k) schedule.observe(0.75);
  CHECK(schedule.n() == 4);
}

TEST_CASE("an undefined overlap keeps n while the echo runs on") {
  SegmentSchedule schedule(0.1, 2, kNoLimit, Recover::step);
  schedule.observe(0.75);
  for (int k = 0; k < 10; ++k) {
    schedule.observe(k % 2 == 0 ? std::optional<double>() : std::nan(""));
    CHECK(schedule.n() == 4);
  }
  CHECK(schedule.echo() == 0);
  schedule.observe(0.95);
  CHECK(schedule.n() == 2);
}

TEST_CASE("anticipation can only raise n") {
  SegmentSchedule schedule(0.1, 2, kNoLimit, Recover::step);
  schedule.observe(0.75);
  CHECK_FALSE(schedule.anticipate(std::nullopt));
  CHECK_FALSE(schedule.anticipate(1.0));
  CHECK_FALSE(schedule.anticipate(0.75));
  CHECK(schedule.echo() == 4);
  CHECK(schedule.anticipate(0.45));
  CHECK(schedule.n() == 7);
  CHECK(schedule.echo() == 7);
}

TEST_CASE("without the echo n follows the latest overlap at once, up and down") {
  SegmentSchedule schedule(0.1, 2, kNoLimit, Recover::step, false);
  for (const auto& [overlap, n] :
       {std::pair{0.25, 9}, {0.55, 6}, {0.95, 2}, {0.0, 11}, {0.75, 4}, {0.75, 4}, {1.0, 2}}) {
    schedule.observe(overlap);
    CHECK(schedule.n() == n);
    CHECK(schedule.echo() == 1);
  }
}

TEST_CASE("without the echo, undefined overlaps keep n and a ramp falls by one per update") {
  SegmentSchedule schedule(0.1, 2, kNoLimit, Recover::ramp, false);
  schedule.observe(0.55);
  REQUIRE(schedule.n() == 6);
  schedule.observe(std::nullopt);
  CHECK(schedule.n() == 6);
  for (const std::int64_t n : {5, 4, 3, 2, 2}) {
    schedule.observe(1.0);
    CHECK(schedule.n() == n);
  }
}
