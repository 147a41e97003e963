// On the recordings in ASLIO_RECORDINGS_DIR, unpacked once into the build folder. Missing data fail the test.
#include <catch2/catch.hpp>
#include <ctime>

#include "io/bag_fixture.hpp"
#include "recordings/unpacked.hpp"

namespace aslio::io::test {

TEST_CASE("the whole corridor of the Avia is read, fast") {
  const std::filesystem::path bag = aslio::test::unpacked_avia();
  const std::clock_t begin = std::clock();
  const auto source = open_source(bag, {});
  const Counts counts = drain(*source);
  const double cpu = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  CHECK(counts.packets == 265);
  CHECK(counts.imu == 5313);
  CHECK(counts.points == 5'967'664);
  CHECK(counts.dropped == 0);
  CHECK(source->status() == InputStatus::complete);
  CHECK(contains(source->notes().verdicts, "g (found"));
  CHECK(cpu < 26.6 * 0.02);  // a sanitizer build takes several times the 2 ms per second of data of a release build
}

TEST_CASE("the corridor is understood by inspection") {
  const InputReport report = inspect(aslio::test::unpacked_avia());
  CHECK(report.usable);
  REQUIRE(report.topics.size() == 2);
  CHECK(report.topics[0].rate == Approx(200).epsilon(1e-4));
  CHECK(report.topics[1].rate == Approx(10).epsilon(1e-4));
  CHECK(report.duration() == Approx(26.56));
}

TEST_CASE("the KITTI drive is read whole") {
  SensorConfig sensor;
  const auto source = open_source(aslio::test::unpacked_kitti(), sensor);
  const TimeNs begin = *source->begin_time();
  const Counts counts = drain(*source);
  CHECK(counts.packets == 154);
  CHECK(counts.imu == 154);
  CHECK(counts.points > 18'000'000);
  CHECK(begin == 1'317'042'272'283'701'593);
  CHECK(contains(source->notes().verdicts, "interpolated"));
}

}  // namespace aslio::io::test
