// Faults 21 to 40: the points.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "faults/table.hpp"

namespace aslio::test::faults {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr double kAt = 6;  ///< [s] in the middle of the walk

std::function<Outcome()> with(Fault fault, How how = {}) {
  return [fault = std::move(fault), how = std::move(how)] { return run_with(fault, how); };
}

using Choice = std::function<bool(const TimedPoint&, std::size_t index)>;

/// Changes those points of each packet that are chosen.
Fault spoil(Choice chosen, std::function<void(TimedPoint&)> change) {
  return alter_packets({}, [=](LidarPacket& packet, std::size_t) {
    for (std::size_t i = 0; i < packet.points.size(); ++i) {
      if (chosen(packet.points[i], i)) change(packet.points[i]);
    }
  });
}

/// The run with these points spoilt must be that without them: what is filtered leaves no trace.
std::function<void(const Outcome&)> same_as_without(const Choice& chosen) {
  return [chosen](const Outcome& o) {
    const Outcome without = run_with(alter_packets({}, [&](LidarPacket& packet, std::size_t) {
      std::vector<TimedPoint> left;
      for (std::size_t i = 0; i < packet.points.size(); ++i) {
        if (!chosen(packet.points[i], i)) left.push_back(packet.points[i]);
      }
      packet.points = std::move(left);
    }));
    REQUIRE_FALSE(without.trajectory.empty());
    CHECK((o.trajectory == without.trajectory));
  };
}

Fault set_position(const Choice& chosen, float value) {
  return spoil(chosen, [value](TimedPoint& p) { p.x = p.y = p.z = value; });
}

bool every_second(const TimedPoint&, std::size_t index) { return index % 2 == 0; }
bool of_line_0(const TimedPoint& point, std::size_t) { return point.line == 0; }
bool every_tenth(const TimedPoint&, std::size_t index) { return index % 10 == 0; }

/// Points in the order of falling time; those of one firing keep theirs.
Fault unsorted() {
  return alter_packets({}, [](LidarPacket& packet, std::size_t) {
    std::stable_sort(packet.points.begin(), packet.points.end(),
                     [](const TimedPoint& a, const TimedPoint& b) { return a.t > b.t; });
  });
}

/// A wall that moves, 3 m away and nearer, before two fifths of the view.
Fault moving_things() {
  return [](Measurements& m) {
    const TimeNs begin = stamp_of(m.front());
    alter_points({}, [begin](TimedPoint& p) {
      const double azimuth = std::atan2(p.y, p.x), t = to_seconds(p.t - begin);
      const double range = std::hypot(double{p.x}, double{p.y}), at = 2 + std::sin(2 * t + azimuth);
      if (std::abs(azimuth) > 0.4 * 3.14159 || range < at) return;
      const auto by = static_cast<float>(at / range);
      p.x *= by;
      p.y *= by;
      p.z *= by;
    })(m);
  };
}

const char* const kFiltered =
    "a run without those points is the reference, bit for bit, in place of a share of the error.";

std::vector<Row> empty_and_spoilt() {
  std::vector<Row> rows;
  rows.push_back(
      {.number = 21,
       .name = "empty_scan",
       .injected = "one LiDAR message without points",
       .expected = {.status = {"ok"}, .counters = {{"empty_packets", 1}}, .ate_times = 1.1, .ate_plus = 0.002},
       .run = with(empty_packets({kAt, 0.1})),
       .also = "`fixed_window` ends `ok`, too",
       .check = [](const Outcome&) {
         const Outcome fixed = run_with(empty_packets({kAt, 0.1}), {.pipeline = "fixed_window"});
         INFO(fixed.reason());
         CHECK(fixed.status() == "ok");
       }});
  rows.push_back({.number = 22,
                  .name = "one_point_scan",
                  .injected = "one LiDAR message with a single point",
                  .expected = {.status = {"ok"}, .ate_times = 1.1, .ate_plus = 0.002},
                  .run = with(thin_packets({kAt, 0.1}, 1))});
  rows.push_back({.number = 23,
                  .name = "nan_points_50pct",
                  .injected = "every second point is not a number",
                  .expected = {.status = {"ok", "degraded"}, .counters = {{"points_invalid", 200'000}}},
                  .run = with(set_position(&every_second, kNaN)),
                  .also = "the trajectory of a run without them, to the last byte",
                  .check = same_as_without(&every_second),
                  .note = kFiltered});
  rows.push_back({.number = 24,
                  .name = "all_nan_scan",
                  .injected = "all points of one LiDAR message are not numbers",
                  .expected = {.status = {"ok"},
                               .counters = {{"empty_packets", 1}, {"points_invalid", 3000}},
                               .ate_times = 1.1,
                               .ate_plus = 0.002},
                  .run = with(alter_points({kAt, 0.1}, [](TimedPoint& p) { p.x = kNaN; }))});
  rows.push_back({.number = 25,
                  .name = "zero_range_blind_ring",
                  .injected = "one scan line of four reports the origin",
                  .expected = {.status = {"ok", "degraded"}, .counters = {{"points_invalid", 50'000}}},
                  .run = with(set_position(&of_line_0, 0.0F)),
                  .also = "the trajectory of a run without them, to the last byte",
                  .check = same_as_without(&of_line_0)});
  rows.push_back({.number = 26,
                  .name = "huge_coords_1e30",
                  .injected = "every tenth point lies at 1e30 m",
                  .expected = {.status = {"ok", "degraded"}, .counters = {{"points_invalid", 40'000}}},
                  .run = with(set_position(&every_tenth, 1e30F)),
                  .also = "the trajectory of a run without them, to the last byte",
                  .check = same_as_without(&every_tenth)});
  rows.push_back({.number = 27,
                  .name = "origin_at_1e6_m",
                  .injected = "all points lie 1e6 m away",
                  .expected = {.status = {"failed"}, .exit = {3}, .counters = {{"points_invalid", 400'000}}},
                  .run = with(alter_points({}, [](TimedPoint& p) { p.x += 1e6F; })),
                  .note = "the origin of the world is the start of the run, so only points can be that far away."});
  return rows;
}

std::vector<Row> missing_and_repeated() {
  std::vector<Row> rows;
  rows.push_back({.number = 28,
                  .name = "lidar_dropout_1_scan",
                  .injected = "one LiDAR message is missing",
                  .expected = {.status = {"ok"}, .ate_times = 1.1, .ate_plus = 0.002},
                  .run = with(drop_packets({kAt, 0.1}))});
  rows.push_back({.number = 29,
                  .name = "lidar_dropout_2s",
                  .injected = "2 s without points",
                  .expected = {.status = {"degraded"}, .ate_times = 2, .ate_plus = 0.05, .says = {"s without points"}},
                  .run = with(drop_packets({kAt, 2})),
                  .also = "ok again within 3 s",
                  .check = [](const Outcome& o) { check_recovered(o, kAt + 2, 3); }});
  rows.push_back({.number = 30,
                  .name = "lidar_dropout_30s",
                  .injected = "5.5 s without points, more than `max_gap` (5 s)",
                  .expected = {.status = {"diverged"}, .exit = {1}, .says = {"points"}},
                  .run = with(drop_packets({4, 5.5})),
                  .also = "a new segment, with a map of its own, that ends ok",
                  .check =
                      [](const Outcome& o) {
                        REQUIRE(o.summary.at("losses").size() == 1);
                        CHECK(o.updates.at("segment").back() == "1");
                        CHECK(o.tracking.back() == "ok");
                      },
                  .note = "`max_gap` is the limit, so a little more than that is the harder case."});
  rows.push_back({.number = 31,
                  .name = "duplicate_scan",
                  .injected = "every LiDAR message of 2 s comes twice",
                  .expected = {.status = {"ok"}, .counters = {{"duplicate_packets", 20}}},
                  .run = with(repeat_packets({kAt, 2})),
                  .also = "the clean trajectory, to the last byte",
                  .check = &check_same_as_clean});
  rows.push_back({.number = 32,
                  .name = "scan_time_back",
                  .injected = "both clocks jump back by 3 s at 6 s",
                  .expected = {.status = {"diverged"}, .exit = {1}, .says = {"clock"}},
                  .run = with(shift_stamps({kAt}, -3 * kSecond)),
                  .also = "a new segment that is tracked to the end",
                  .check =
                      [](const Outcome& o) {
                        REQUIRE(o.updates.contains("segment"));
                        CHECK(o.updates.at("segment").back() == "1");
                        CHECK(o.tracking.back() == "ok");
                      },
                  .note = "as row 10, and the run has already used the times it jumps to."});
  return rows;
}

std::vector<Row> point_times() {
  std::vector<Row> rows;
  rows.push_back({.number = 33,
                  .name = "point_time_missing",
                  .injected = "clouds have no time field",
                  .expected = {.exit = {3}, .says = {"time", "require_point_times"}},
                  .run = with([](Measurements&) {}, {.form = {.point_times = false}}),
                  .also = "with `require_point_times: false` it runs",
                  .check = [](const Outcome&) {
                    const Outcome opted =
                        run_with([](Measurements&) {},
                                 {.sensor_lines = {"require_point_times: false"}, .form = {.point_times = false}});
                    INFO(opted.err);
                    CHECK(opted.summary.at("updates").get<int>() > 50);
                    CHECK(opted.err.find("malformed") == std::string::npos);
                  }});
  rows.push_back(
      {.number = 34,
       .name = "point_time_units_wrong",
       .injected = "the time field counts microseconds, others count nanoseconds",
       .expected = {.status = {"ok"}, .ate_times = 1.1, .ate_plus = 0.001},
       .run = with([](Measurements&) {}, {.form = {.time_unit = 1000}}),
       .also = "a note says so",
       .check = [](const Outcome& o) { CHECK_THAT(o.summary.at("notes").dump(), Catch::Matchers::Contains(" us")); }});
  rows.push_back({.number = 35,
                  .name = "point_times_unsorted",
                  .injected = "the points of each message come in descending order of time",
                  .expected = {.status = {"ok"}, .counters = {{"points_reordered", 1000}}},
                  .run = with(unsorted()),
                  .also = "the clean trajectory, to the last byte",
                  .check = &check_same_as_clean});
  rows.push_back({.number = 36,
                  .name = "point_time_overflow_wrap",
                  .injected = "the time of the last tenth of the points of 1 s has overflowed its 32 bits",
                  .expected = {.status = {"ok", "degraded"},
                               .counters = {{"points_invalid", 1000}},
                               .ate_times = 1.1,
                               .ate_plus = 0.005},
                  .run = with(alter_packets({kAt, 1}, [](LidarPacket& packet, std::size_t) {
                    for (std::size_t i = 9 * packet.points.size() / 10; i < packet.points.size(); ++i) {
                      packet.points[i].t += 3 * kSecond;
                    }
                  }))});
  rows.push_back({.number = 37,
                  .name = "scan_longer_than_imu",
                  .injected = "the IMU samples of 3 s arrive only after them",
                  .expected = {.status = {"ok"}},
                  .run = with(delay_imu({kAt, 3})),
                  .also = "the clean trajectory, to the last byte",
                  .check = &check_same_as_clean,
                  .note = "the run waits for late data; row 7 is the case without them."});
  return rows;
}

std::vector<Row> few_and_wrong() {
  std::vector<Row> rows;
  rows.push_back({.number = 38,
                  .name = "decimated_to_100_pts",
                  .injected = "3 s with 100 points per sweep",
                  .expected = {.status = {"ok", "degraded"}, .ate_times = 2, .ate_plus = 0.02},
                  .run = with(thin_packets({kAt, 3}, 100)),
                  .also = "recovered after 1 s",
                  .check = [](const Outcome& o) { check_recovered(o, kAt + 3, 1); },
                  .note = "a hundred matched points bind a pose; the error counts, not the number of points."});
  rows.push_back({.number = 39,
                  .name = "dynamic_objects_40pct",
                  .injected = "two fifths of the view are a wall that moves",
                  .expected = {.status = {"ok", "degraded"}, .ate_times = 2, .ate_plus = 0.005},
                  .run = with(moving_things()),
                  .pending = "monitor"});
  rows.push_back({.number = 40,
                  .name = "rain_noise_20pct",
                  .injected = "a fifth of the points lie anywhere on their rays, up to 10 m away",
                  .expected = {.status = {"ok", "degraded"}, .ate_times = 2, .ate_plus = 0.005},
                  .run = with(add_rain({}, 0.2, 10, 101))});
  return rows;
}

}  // namespace

std::vector<Row> lidar_rows() {
  std::vector<Row> rows = empty_and_spoilt();
  for (auto* more : {&missing_and_repeated, &point_times, &few_and_wrong}) {
    for (Row& row : more()) rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace aslio::test::faults
