#include "windows/replay_schedule.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <functional>
#include <random>
#include <string>

#include "aslio/core/errors.hpp"
#include "temporary_folder.hpp"

namespace aslio {
namespace {

using Catch::Contains;
using plugins::ReplaySchedule;
using Interval = std::pair<TimeNs, TimeNs>;  ///< duration, history

std::vector<TimeNs> ends(const ReplaySchedule& schedule) {
  std::vector<TimeNs> all;
  for (const auto& update : schedule.updates()) all.push_back(update.end);
  return all;
}

std::vector<Interval> intervals(const ReplaySchedule& schedule) {
  std::vector<Interval> all;
  const auto& updates = schedule.updates();
  for (std::size_t i = 1; i < updates.size(); ++i) {
    all.emplace_back(updates[i].end - updates[i - 1].end, updates[i].history);
  }
  return all;
}

/// What is wrong with a schedule that has been read.
std::string complaint(const std::string& text) {
  try {
    ReplaySchedule::parse(text, "plan.csv");
  } catch (const DataError& error) {
    return error.what();
  }
  return {};
}

/// Ends at 1000, 1010, 1030, 1060, .., of n updates, each with its duration as history.
ReplaySchedule growing(int n) {
  std::string text = "t_ns,window_begin_ns\n";
  TimeNs t = 1000;
  for (int i = 0; i < n; t += 10 * ++i) {
    text += std::to_string(t) + ',' + std::to_string(t - 20 * i) + '\n';
  }
  return ReplaySchedule::parse(text, "plan.csv");
}

}  // namespace

TEST_CASE("replay: a schedule is read by the names of its columns") {
  const auto schedule = ReplaySchedule::parse(
      "note, window_begin_ns ,x, t_ns\r\n,90,,100\r\n\r\na,60,1,130\r\nb,130,2, 150 ", "plan.csv");
  CHECK(ends(schedule) == std::vector<TimeNs>{100, 130, 150});
  CHECK(schedule.updates()[0].history == 0);   // what was before the first is not known
  CHECK(schedule.updates()[1].history == 40);  // from 60 to 100
  CHECK(schedule.updates()[2].history == 0);
  CHECK(schedule.longest_history() == 40);
}

TEST_CASE("replay: without begins of windows there is no history") {
  const auto schedule = ReplaySchedule::parse("t_ns\n-5\n7\n1700000000000000000\n", "plan.csv");
  CHECK(ends(schedule) == std::vector<TimeNs>{-5, 7, 1'700'000'000'000'000'000});
  CHECK(schedule.longest_history() == 0);
}

TEST_CASE("replay: errors of a schedule name the file, the line and the value") {
  CHECK_THAT(complaint("time,x\n1,2\n"), Contains("plan.csv:1: the header names no column 't_ns'"));
  CHECK_THAT(complaint("t_ns\n100\n0.25\n"), Contains("plan.csv:3: t_ns '0.25' is not a time in whole nanoseconds"));
  CHECK_THAT(complaint("t_ns,a\n100,1\n,1\n"), Contains("plan.csv:3: t_ns '' is not"));
  CHECK_THAT(complaint("t_ns\n99999999999999999999\n"), Contains("plan.csv:2: t_ns '99999999999999999999'"));
  CHECK_THAT(complaint("t_ns\n9000000000000000000\n"),
             Contains("plan.csv:2: t_ns 9000000000000000000 is out of range"));
  CHECK_THAT(complaint("t_ns,window_begin_ns\n100,50\n200,soon\n"), Contains("plan.csv:3: window_begin_ns 'soon'"));
  CHECK_THAT(complaint("a,t_ns\n1,100\n2\n"), Contains("plan.csv:3: the line ends before column 't_ns'"));
  CHECK_THAT(complaint("t_ns\n100\n300\n200\n"),
             Contains("plan.csv:4: t_ns 200 is not after that of the update before, 300"));
  CHECK_THAT(complaint("t_ns\n100\n100\n"), Contains("plan.csv:3: t_ns 100 is not after"));
  CHECK_THAT(complaint("t_ns\n"), Contains("plan.csv: holds no update"));
  CHECK_THAT(complaint(""), Contains("plan.csv: is empty"));
}

TEST_CASE("replay: a schedule that cannot be opened is named") {
  const test::TemporaryFolder folder;
  const std::string missing = (folder / "none.csv").string();
  CHECK_THROWS_WITH(ReplaySchedule::read(missing), Contains(missing) && Contains("No such file or directory"));
  CHECK_THROWS_AS(ReplaySchedule::read(missing), ConfigError);
  CHECK_THROWS_WITH(ReplaySchedule::read(folder.path()),
                    Contains(folder.path().string()) && Contains("is a directory"));
  CHECK_THROWS_WITH(ReplaySchedule::read(folder.write("bad.csv", "t_ns\nx\n")), Contains("bad.csv:2: t_ns 'x'"));
}

TEST_CASE("replay: a rhythm moves around the circle between its first and its last end") {
  const auto moved = [](TimeNs shift) {
    ReplaySchedule schedule = growing(5);  // 1000, 1010, 1030, 1060, 1100
    schedule.rotate(shift);
    return schedule;
  };
  CHECK(ends(moved(0)) == std::vector<TimeNs>{1000, 1010, 1030, 1060, 1100});
  CHECK(ends(moved(100)) == ends(moved(0)));
  // The last interval, of 40, goes first: no interval is cut.
  CHECK(ends(moved(40)) == std::vector<TimeNs>{1000, 1040, 1050, 1070, 1100});
  CHECK(intervals(moved(40)) == std::vector<Interval>{{40, 40}, {10, 10}, {20, 20}, {30, 30}});
  // The seam cuts the interval of 40 into 25 at its begin and 15 at its end.
  CHECK(intervals(moved(15)) == std::vector<Interval>{{15, 40}, {10, 10}, {20, 20}, {30, 30}, {25, 40}});
  CHECK(ends(moved(-85)) == ends(moved(15)));
  CHECK(ends(moved(1015)) == ends(moved(15)));
  ReplaySchedule single = growing(1);
  single.rotate(15);
  CHECK(ends(single) == std::vector<TimeNs>{1000});
}

TEST_CASE("replay: every move keeps the ends in order and within their span") {
  for (TimeNs shift = -460; shift <= 460; ++shift) {
    CAPTURE(shift);
    ReplaySchedule schedule = growing(10);
    schedule.rotate(shift);
    const auto t = ends(schedule);
    CHECK(t.front() == 1000);
    CHECK(t.back() == 1450);
    CHECK((t.size() == 10 || t.size() == 11));
    CHECK(std::adjacent_find(t.begin(), t.end(), std::greater_equal<>()) == t.end());
  }
}

TEST_CASE("replay: shuffled intervals are the same intervals, each with its history, in an order drawn from the seed") {
  const auto shuffled = [](std::uint64_t seed) {
    ReplaySchedule schedule = growing(20);
    schedule.shuffle(seed);
    return schedule;
  };
  const ReplaySchedule plain = growing(20), one = shuffled(1);
  CHECK(ends(one).front() == ends(plain).front());
  CHECK(ends(one).back() == ends(plain).back());
  CHECK(intervals(one) != intervals(plain));
  CHECK(intervals(one) == intervals(shuffled(1)));
  CHECK(intervals(one) != intervals(shuffled(2)));
  auto sorted = intervals(one);
  std::sort(sorted.begin(), sorted.end());
  CHECK(sorted == intervals(plain));
}

TEST_CASE("replay: a steady rhythm has as many updates at equal distances, and windows of the same lengths") {
  ReplaySchedule schedule = growing(5);  // intervals of 10, 20, 30, 40, as much history: windows of 20, 40, 60, 80
  schedule.steady();
  CHECK(intervals(schedule) == std::vector<Interval>{{25, 0}, {25, 15}, {25, 35}, {25, 55}});
  ReplaySchedule uneven = ReplaySchedule::parse("t_ns\n0\n1\n2\n11\n", "plan.csv");
  uneven.steady();
  CHECK(ends(uneven) == std::vector<TimeNs>{0, 3, 7, 11});
  ReplaySchedule single = growing(1);
  single.steady();
  CHECK(ends(single) == std::vector<TimeNs>{1000});
}

TEST_CASE("replay: by turn rate, the shortest intervals go where the sensor turns fastest") {
  // Four intervals of 100 with slow turns, then ten of 40 with fast ones in the first four of those.
  std::string text = "t_ns,window_begin_ns,gyro_rms_rad_s\n0,-200,0\n";
  TimeNs t = 0;
  for (int i = 0; i < 4; ++i, t += 100) {
    text += std::to_string(t + 100) + ',' + std::to_string(t - 100) + (i < 2 ? ",0.1\n" : ",0.9\n");
  }
  for (int i = 0; i < 10; ++i, t += 40) {
    text += std::to_string(t + 40) + ',' + std::to_string(t - 160) + (i < 5 ? ",0.8\n" : ",0.2\n");
  }
  ReplaySchedule schedule = ReplaySchedule::parse(text, "plan.csv");
  schedule.by_turn_rate();
  // Of 800, the fast half is from 200 to 600: there the ten of 40 are, and two of 100 before and behind. Windows of
  // 200.
  std::vector<Interval> expected(2, {100, 100});
  expected.insert(expected.end(), 10, {40, 160});
  expected.insert(expected.end(), 2, {100, 100});
  CHECK(intervals(schedule) == expected);
}

TEST_CASE("replay: by turn rate there are as many updates, whatever the schedule") {
  std::mt19937_64 random(7);
  for (int trial = 0; trial < 200; ++trial) {
    CAPTURE(trial);
    const int count = std::uniform_int_distribution(2, 60)(random);
    const bool tiny = trial % 4 == 0;  // intervals of some ns, which round to none
    std::string text = "t_ns,gyro_rms_rad_s\n";
    TimeNs t = 0;
    for (int i = 0; i < count; ++i) {
      const TimeNs step = std::uniform_int_distribution<TimeNs>(1, tiny ? 5 : 100'000'000)(random);
      t += step;
      text += std::to_string(t) + ',' + std::to_string(std::uniform_int_distribution(0, 5)(random)) + '\n';
    }
    const ReplaySchedule plain = ReplaySchedule::parse(text, "plan.csv");
    ReplaySchedule schedule = plain;
    schedule.by_turn_rate();
    const auto before = ends(plain), after = ends(schedule);
    REQUIRE(after.size() == before.size());
    CHECK(after.front() == before.front());
    CHECK(after.back() == before.back());
    CHECK(std::adjacent_find(after.begin(), after.end(), std::greater_equal<>()) == after.end());
  }
}

TEST_CASE("replay: an order by turn rate needs the turn rate of every update") {
  const auto failure = [](const std::string& text) -> std::string {
    ReplaySchedule schedule = ReplaySchedule::parse(text, "plan.csv");
    try {
      schedule.by_turn_rate();
    } catch (const DataError& error) {
      return error.what();
    }
    return {};
  };
  CHECK_THAT(failure("t_ns\n100\n200\n"), Contains("plan.csv: gyro_rms_rad_s of the update that ends at 200 ns"));
  CHECK_THAT(failure("t_ns,gyro_rms_rad_s\n100,\n200,1\n300,\n"), Contains("the update that ends at 300 ns"));
  CHECK(failure("t_ns,gyro_rms_rad_s\n100,\n200,1\n").empty());  // what was before the first end is not moved
  CHECK_THAT(failure("t_ns,gyro_rms_rad_s\n100,1\n200,fast\n"), Contains("the update that ends at 200 ns"));
  CHECK_THAT(failure("t_ns,gyro_rms_rad_s\n100,1\n200\n"), Contains("the update that ends at 200 ns"));
  ReplaySchedule other = ReplaySchedule::parse("t_ns,gyro_rms_rad_s\n100,-\n150\n300,fast\n", "plan.csv");
  other.steady();  // no other order looks at the column
  CHECK(ends(other) == std::vector<TimeNs>{100, 200, 300});
}

TEST_CASE("replay: the next update is the first that ends later") {
  ReplaySchedule schedule = growing(3);  // 1000, 1010, 1030
  CHECK(schedule.after(0)->end == 1000);
  CHECK(schedule.after(999)->end == 1000);
  CHECK(schedule.after(1000)->end == 1010);
  CHECK(schedule.after(1029)->end == 1030);
  CHECK(schedule.after(1030) == nullptr);
}

}  // namespace aslio
