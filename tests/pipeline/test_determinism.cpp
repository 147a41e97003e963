// Same input, same bits: for any number of threads, run after run, alone or interleaved, however it was packed.
#include <algorithm>
#include <catch2/catch.hpp>

#include "aslio/simulator/analytic_world.hpp"
#include "pipeline/runs.hpp"

using namespace aslio;
using namespace aslio::test;

namespace {

/// The first seconds of the walk at twice the usual speed: at rest, then into the first sharp turn.
struct World {
  World() {
    const auto source = world.source();
    recording = record(*source, world.begin_time() + to_ns(4.0));
  }
  simulator::AnalyticWorld world{{.duration_scale = 0.5}};
  Recording recording;
};

std::vector<std::uint64_t> digests(const World& w, const std::string& name, int threads = 1,
                                   const std::vector<std::string>& overrides = {}) {
  Run run(shipped(name, overrides), w.world.sensor(), threads);
  return run.play(w.recording).digests();
}

}  // namespace

TEST_CASE("digests of all updates are the same for any number of threads and from run to run") {
  const World w;
  for (const char* name : {"as_lio_plus", "fixed_window"}) {
    const auto expected = digests(w, name);
    REQUIRE(expected.size() >= 35);
    for (const int threads : {1, 2, 3, 8}) {
      CAPTURE(name, threads);
      CHECK((digests(w, name, threads) == expected));
    }
  }
}

TEST_CASE("two pipelines interleaved in one process give the same digests as each alone") {
  const World w;
  Run first(shipped("as_lio_plus"), w.world.sensor()), second(shipped("fixed_window"), w.world.sensor()),
      third(shipped("as_lio_plus"), w.world.sensor());
  for (const Measurement& m : w.recording) {
    for (Run* run : {&first, &second, &third}) run->push(m);
  }
  for (Run* run : {&third, &second, &first}) run->finish();
  CHECK((first.digests() == digests(w, "as_lio_plus")));
  CHECK((third.digests() == first.digests()));
  CHECK((second.digests() == digests(w, "fixed_window")));
}

TEST_CASE("digests do not depend on how the stream was cut into packets") {
  World w;
  const auto expected = digests(w, "as_lio_plus");
  const auto ahead = digests(w, "as_lio_plus", 1, {"window.lookahead=true"});
  REQUIRE(ahead.size() >= 35);
  for (const TimeNs period : {100'000'000, 20'000'000, 7'000'000}) {
    CAPTURE(period);
    World other = w;
    other.recording = repacked(w.recording, period);
    CHECK((digests(other, "as_lio_plus") == expected));
    CHECK((digests(other, "as_lio_plus", 1, {"window.lookahead=true"}) == ahead));
  }
}

TEST_CASE("other data gives other digests") {
  World w;
  const auto expected = digests(w, "fixed_window");
  for (Measurement& m : w.recording) {
    if (auto* imu = std::get_if<ImuSample>(&m)) imu->gyro.z() += 1e-12;
  }
  CHECK((digests(w, "fixed_window") != expected));
}

TEST_CASE("a first message with a wild stamp does not end a run, whichever sensor comes first") {
  const World w;
  const auto packet = std::find_if(w.recording.begin(), w.recording.end(),
                                   [](const Measurement& m) { return std::holds_alternative<LidarPacket>(m); });
  const auto reading = std::find_if(w.recording.begin(), w.recording.end(),
                                    [](const Measurement& m) { return std::holds_alternative<ImuSample>(m); });
  const TimeNs begin = std::get<ImuSample>(*reading).t;
  for (const char* name : {"as_lio_plus", "kiss_icp"}) {
    const std::size_t usual = digests(w, name).size();
    for (const TimeNs by : {-begin, 5 * kSecond, 3600 * kSecond}) {
      for (const bool of_imu : {true, false}) {
        CAPTURE(name, by, of_imu);
        World other = w;
        Measurement wild = of_imu ? *reading : *packet;
        if (auto* imu = std::get_if<ImuSample>(&wild)) imu->t += by;
        if (auto* points = std::get_if<LidarPacket>(&wild)) {
          points->stamp += by;
          for (TimedPoint& p : points->points) p.t += by;
        }
        other.recording.insert(other.recording.begin(), std::move(wild));
        CHECK(digests(other, name).size() + 10 >= usual);
      }
    }
  }
}
