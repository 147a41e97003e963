#include <algorithm>
#include <catch2/catch.hpp>

#include "plugins/windows/configured_window.hpp"
#include "temporary_folder.hpp"

namespace aslio {
namespace {

using test::kMs;

/// 20 points per ms over (0, ms], without those in (gap_begin, gap_end].
test::FakeStream dense_stream(TimeNs ms, TimeNs gap_begin = 0, TimeNs gap_end = 0) {
  std::vector<TimedPoint> points;
  test::add_points(points, 0, gap_begin * kMs, kMs, 20);
  test::add_points(points, gap_end * kMs, ms * kMs, kMs, 20);
  return {std::move(points), test::imu_samples(0, ms * kMs)};
}

std::string replay(const std::filesystem::path& file, const std::string& more = "") {
  return "{type: replay, file: " + file.string() + more + "}";
}

/// Lines as a run writes them.
std::string updates_csv(const std::vector<WindowPlan>& plans) {
  std::string text =
      "t_ns,window_begin_ns,status,n_fresh,n_history,sod,layer_0,layer_1,layer_2,layer_3,layer_4,layer_5,layer_6,"
      "layer_7,seg_time,shift_time_s,echo,iterations,n_matches,eig_1,eig_2,eig_3,eig_4,eig_5,eig_6,digest,extended,"
      "partial,n_fresh_matches,n_history_matches,residual_rms_m,inserted,tracking,gyro_rms_rad_s\n";
  for (const WindowPlan& plan : plans) {
    text +=
        std::to_string(plan.end) + ',' + std::to_string(plan.history_begin) +
        ",initialising,24000,0,,0,0,0,0,0,0,0,0,2,0.1,1,0,0,,,,,,,00c5cf4b7f0d0d1f,0,0,0,0,,3211,initialising,0.01\n";
  }
  return text;
}

std::string failure(const std::string& window, test::FakeStream stream, TimeNs start) {
  try {
    test::plans_of(window, std::move(stream), start);
  } catch (const DataError& error) {
    return error.what();
  }
  return {};
}

}  // namespace

TEST_CASE("replay: the updates of a run give the same windows again, across a gap and to the end of the data") {
  const test::TemporaryFolder folder;
  test::BuildEnvironment environment;
  test::FakeStream stream = dense_stream(1733, 600, 1100);
  stream.finish();
  const auto adaptive = test::WindowCatalog().read("{type: sod_adaptive, warmup: 0.2}").make(environment.context());
  test::FakeProbe probe = test::blind_probe();
  test::WindowLoop loop(*adaptive, probe, 0, [](const WindowPlan& plan) -> std::optional<double> {
    return static_cast<double>(plan.end / kMs % 300) / 300.0;
  });
  loop.run(stream);
  REQUIRE(loop.plans.size() > 15);

  const auto again = test::plans_of(replay(folder.write("updates.csv", updates_csv(loop.plans))), stream);
  REQUIRE(again.size() == loop.plans.size());
  for (std::size_t i = 0; i < again.size(); ++i) {
    CAPTURE(i);
    CHECK(again[i].history_begin == loop.plans[i].history_begin);
    CHECK(again[i].fresh_begin == loop.plans[i].fresh_begin);
    CHECK(again[i].end == loop.plans[i].end);
  }
}

TEST_CASE("replay: history stays with its update, and reach is that of the longest") {
  const test::TemporaryFolder folder;
  const auto file =
      folder.write("plan.csv", "t_ns,window_begin_ns\n100000000,0\n130000000,40000000\n150000000,50000000\n");
  const auto plans = test::plans_of(replay(file), dense_stream(200));
  REQUIRE(plans.size() == 4);
  CHECK(plans[1].history_begin == 40 * kMs);
  CHECK(plans[2].history_begin == 50 * kMs);
  CHECK(plans[2].shift_time == 0.02);
  test::BuildEnvironment environment;
  CHECK(test::WindowCatalog().read(replay(file)).make(environment.context())->reach() == 80 * kMs);
}

TEST_CASE("replay: no window reaches back further than the one before it") {  // what histories rely on
  const test::TemporaryFolder folder;
  // As at the seam of a shifted schedule: a long interval without history, a short piece of it, a short window.
  const auto file = folder.write(
      "plan.csv", "t_ns,window_begin_ns\n100000000,0\n200000000,100000000\n205000000,200000000\n213000000,113000000\n");
  const auto plans = test::plans_of(replay(file), dense_stream(300));
  REQUIRE(plans.size() >= 4);
  CHECK(plans[3].fresh_begin == 205 * kMs);
  CHECK(plans[3].history_begin == 200 * kMs);
  for (std::size_t i = 1; i < plans.size(); ++i) CHECK(plans[i].history_begin >= plans[i - 1].history_begin);
}

TEST_CASE("replay: beyond the schedule updates come every period, without history") {
  const test::TemporaryFolder folder;
  const auto file = folder.write("plan.csv", "t_ns,window_begin_ns\n70000000,0\n90000000,10000000\n");
  const auto plans = test::plans_of(replay(file, ", period: 0.04"), dense_stream(200));
  REQUIRE(plans.size() == 5);
  CHECK(plans[2].end == 130 * kMs);
  CHECK(plans[2].history_begin == plans[2].fresh_begin);
  CHECK(plans[3].end == 170 * kMs);
  CHECK(plans[4].partial);
}

TEST_CASE("replay: updates that a gap has swallowed are left out") {
  const test::TemporaryFolder folder;
  std::string text = "t_ns\n";
  for (TimeNs t = 50; t <= 1000; t += 50) text += std::to_string(t * kMs) + '\n';
  const auto plans = test::plans_of(replay(folder.write("plan.csv", text)), dense_stream(1000, 200, 720));
  REQUIRE(plans.size() == 10);
  CHECK(plans[4].fresh_begin == 200 * kMs);
  CHECK(plans[4].end == 771 * kMs - 1);
  CHECK(plans[4].partial);
  CHECK(plans[5].end == 800 * kMs);
  CHECK(plans[6].end == 850 * kMs);
}

TEST_CASE("replay: the yoked controls keep the number of updates and their pace") {  // eq. WIN-7
  const test::TemporaryFolder folder;
  std::string text = "t_ns\n";
  for (TimeNs t = 100, i = 0; t <= 1500; t += i++ < 10 ? 20 : 100) text += std::to_string(t * kMs) + '\n';
  const auto file = folder.write("plan.csv", text);
  const auto count_fast = [&](const std::string& more, TimeNs begin, TimeNs end) {
    const auto plans = test::plans_of(replay(file, more), dense_stream(1500));
    return std::count_if(plans.begin(), plans.end(), [&](const WindowPlan& plan) {
      return plan.end - plan.fresh_begin == 20 * kMs && plan.fresh_begin >= begin * kMs && plan.end <= end * kMs;
    });
  };
  CHECK(count_fast("", 100, 300) == 10);
  CHECK(count_fast(", shift: 0.6, warmup: 0", 700, 900) == 10);
  CHECK(count_fast(", shift: 0.6, warmup: 0", 0, 700) == 0);
  CHECK(count_fast(", order: shuffled, warmup: 0", 0, 1500) == 10);
  CHECK(count_fast(", order: shuffled, warmup: 0", 100, 300) < 10);
  CHECK(count_fast(", order: steady, warmup: 0", 0, 1500) == 0);
  CHECK(test::plans_of(replay(file, ", order: steady, warmup: 0"), dense_stream(1500)).size() ==
        test::plans_of(replay(file), dense_stream(1500)).size());
  CHECK_THROWS_WITH(test::plans_of(replay(file, ", order: turn_rate, warmup: 0"), dense_stream(1500)),
                    Catch::Contains("plan.csv: gyro_rms_rad_s of the update"));
  CHECK_THROWS_WITH(test::plans_of(replay(file, ", order: steady, shift: 1"), dense_stream(1500)),
                    Catch::Contains("it does not go with order 'steady'"));
  CHECK(test::plans_of(replay(file, ", order: shuffled, seed: 2"), dense_stream(1500)).size() ==
        test::plans_of(replay(file), dense_stream(1500)).size());
}

TEST_CASE("replay: the warm-up keeps its place, whatever becomes of the rest") {  // eq. WIN-7
  const test::TemporaryFolder folder;
  std::string text = "t_ns\n";  // ten windows of 100 ms, ten of 20, then of 100 again
  for (TimeNs t = 100, i = 0; t <= 2200; t += i++ / 10 == 1 ? 20 : 100) text += std::to_string(t * kMs) + '\n';
  const auto file = folder.write("plan.csv", text);
  const auto ends_of = [&](const std::string& more) {
    std::vector<TimeNs> ends;
    for (const auto& plan : test::plans_of(replay(file, more), dense_stream(2200))) ends.push_back(plan.end / kMs);
    return ends;
  };
  const auto plain = ends_of("");
  const std::vector<TimeNs> head(plain.begin(), plain.begin() + 11);  // 100 .. 1100: a second after the first
  for (const std::string more : {", shift: 1.2", ", order: shuffled", ", order: steady"}) {
    CAPTURE(more);
    const auto ends = ends_of(more), cold = ends_of(more + ", warmup: 0");
    CHECK(std::vector<TimeNs>(ends.begin(), ends.begin() + 11) == head);
    CHECK(ends != plain);
    CHECK(std::vector<TimeNs>(cold.begin(), cold.begin() + 11) != head);
    CHECK(ends.back() == plain.back());
    CHECK(ends.size() <= plain.size() + 1);
    CHECK(ends.size() >= plain.size());
  }
  CHECK(ends_of(", shift: 0.6, warmup: 1000") == plain);
}

TEST_CASE("replay: a schedule of other data is refused") {
  const test::TemporaryFolder folder;
  const auto file = folder.write("plan.csv", "t_ns\n20000000000\n20100000000\n");
  CHECK_THAT(failure(replay(file), dense_stream(300), 0),
             Catch::Contains("plan.csv: the schedule begins at 20000000000 ns, 20 s after the data"));
  std::vector<TimedPoint> points;
  test::add_points(points, 30 * kSecond, 31 * kSecond, kMs);
  CHECK_THAT(failure(replay(file), {std::move(points), {}}, 30 * kSecond),
             Catch::Contains("plan.csv: the schedule ends at 20100000000 ns, the data begin at 30000000000 ns"));
}

TEST_CASE("replay: a run that begins anew may do so before its schedule or after its end") {
  const test::TemporaryFolder folder;
  const auto file = folder.write("plan.csv", "t_ns\n20000000000\n20100000000\n");
  test::BuildEnvironment environment;
  BuildContext context = environment.context();
  context.anew = true;
  for (const TimeNs begin : {0 * kSecond, 30 * kSecond}) {
    const auto window = test::WindowCatalog().read(replay(file, ", period: 0.05")).make(context);
    std::vector<TimedPoint> points;
    test::add_points(points, begin, begin + kSecond, kMs);
    test::FakeStream stream(std::move(points), test::imu_samples(begin, begin + kSecond));
    stream.finish();
    test::FakeProbe probe = test::blind_probe();
    test::WindowLoop loop(*window, probe, begin, [](const WindowPlan&) { return std::optional<double>(); });
    loop.run(stream);
    REQUIRE(loop.plans.size() >= 19);
    CHECK(loop.plans.front().end - loop.plans.front().fresh_begin == 50 * kMs);
  }
}

TEST_CASE("replay: a file must be named, and can be one that exists") {
  const test::WindowCatalog catalog;
  CHECK_THAT(catalog.complaint("replay"), Catch::Contains("window.yaml:2") && Catch::Contains("window.file") &&
                                              Catch::Contains("is missing: name a schedule"));
  test::BuildEnvironment environment;
  const auto window = catalog.read("{type: replay, file: nowhere/updates.csv}");
  CHECK_THROWS_WITH(window.make(environment.context()),
                    Catch::Contains("nowhere/updates.csv: cannot open the schedule: No such file"));
}

}  // namespace aslio
