#include <catch2/catch.hpp>
#include <limits>

#include "io/bag_fixture.hpp"

namespace aslio::io::test {
namespace {

struct Judged {
  std::string refusal;
  SourceNotes notes;
  ImuSample sample;
};

Judged judge(const Vec3& acc, const Vec3& gyro, AccUnit acc_unit, GyroUnit gyro_unit) {
  TemporaryFolder folder;
  Recording recording;
  recording.acc = acc;
  recording.gyro = gyro;
  recording.write(folder / "a.bag");
  SensorConfig sensor;
  sensor.acc_unit = acc_unit;
  sensor.gyro_unit = gyro_unit;
  Judged judged;
  judged.refusal = data_error([&] {
    const auto source = open_source(folder / "a.bag", sensor);
    judged.notes = source->notes();
    while (const auto measurement = source->next()) {
      if (const auto* sample = std::get_if<ImuSample>(&*measurement)) {
        judged.sample = *sample;
        break;
      }
    }
  });
  return judged;
}

const Vec3 kSlow(0.1, 0, 0);

struct Whole {
  SourceNotes first, last;  ///< once opened, once read
  std::string inspected;
};

/// Of a recording that stands still, with its rate at 0.01, longer than units are judged at the start, then turns.
Whole read_whole(GyroUnit declared, double fastest, int samples = 100) {
  TemporaryFolder folder;
  Recording recording;
  recording.seconds = 8;
  recording.turn = [=](int i) { return Vec3(i >= 600 && i < 600 + samples ? fastest : 0.01, 0, 0); };
  recording.write(folder / "a.bag");
  SensorConfig sensor;
  sensor.gyro_unit = declared;
  const auto source = open_source(folder / "a.bag", sensor);
  Whole whole;
  whole.first = source->notes();
  drain(*source);
  CHECK_FALSE(source->next());  // the end may be asked for again
  whole.last = source->notes();
  whole.inspected = render(inspect(folder / "a.bag", sensor));
  return whole;
}

}  // namespace

TEST_CASE("acceleration in g or m/s^2 is told by its norm") {
  const Judged g = judge({0, 0, 1.0}, kSlow, AccUnit::automatic, GyroUnit::automatic);
  CHECK(g.refusal.empty());
  CHECK(contains(g.notes.verdicts, "g (found; norm 1.000 at the start), multiplied by 9.80665"));
  CHECK(g.sample.acc.z() == Approx(9.80665));
  const Judged si = judge({0, 0, 9.8}, kSlow, AccUnit::automatic, GyroUnit::automatic);
  CHECK(contains(si.notes.verdicts, "m/s^2 (found"));
  CHECK(si.sample.acc.z() == 9.8);
}

TEST_CASE("a declared unit that the data contradict is refused with factor and remedy") {
  const std::string in_g = judge({0, 0, 1.0}, kSlow, AccUnit::mps2, GyroUnit::automatic).refusal;
  CHECK(contains(in_g, "9.80665"));
  CHECK(contains(in_g, "`acc_unit: g`"));
  CHECK(contains(in_g, "/livox/imu"));
  const std::string in_si = judge({0, 0, 9.8}, kSlow, AccUnit::g, GyroUnit::automatic).refusal;
  CHECK(contains(in_si, "9.80665"));
  CHECK(contains(in_si, "`acc_unit: mps2`"));
}

TEST_CASE("an acceleration that is neither is refused, unless its unit is declared") {
  for (const double norm : {0.0, 3.0, 30.0}) {
    const std::string text = judge({0, 0, norm}, kSlow, AccUnit::automatic, GyroUnit::automatic).refusal;
    CHECK(contains(text, "neither g"));
    const Judged declared = judge({0, 0, norm}, kSlow, AccUnit::mps2, GyroUnit::automatic);
    CHECK(declared.refusal.empty());
    CHECK(contains(declared.notes.warnings, "fits neither"));
  }
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(contains(judge({0, 0, nan}, kSlow, AccUnit::automatic, GyroUnit::automatic).refusal, "neither g"));
}

TEST_CASE("an angular rate too fast for any gyroscope is in degrees") {
  const Judged found = judge({0, 0, 9.8}, {90, 0, 0}, AccUnit::automatic, GyroUnit::automatic);
  CHECK(contains(found.notes.verdicts, "deg/s (found"));
  CHECK(found.sample.gyro.x() == Approx(1.5707963267948966));
  const std::string text = judge({0, 0, 9.8}, {90, 0, 0}, AccUnit::automatic, GyroUnit::rad_s).refusal;
  CHECK(contains(text, "pi/180"));
  CHECK(contains(text, "`gyro_unit: deg_s`"));
  const Judged declared = judge({0, 0, 9.8}, {9, 0, 0}, AccUnit::automatic, GyroUnit::deg_s);
  CHECK(declared.sample.gyro.x() == Approx(0.15707963267948966));
  CHECK(contains(judge({0, 0, 9.8}, kSlow, AccUnit::automatic, GyroUnit::automatic).notes.verdicts, "rad/s (assumed"));
}

TEST_CASE("degrees per second that the whole recording speaks against are doubted at its end") {
  const std::string doubt =
      "gyro_unit is deg_s, but nothing in all that was read, spikes aside, turns faster than 1.200 deg/s";
  const Whole wrong = read_whole(GyroUnit::deg_s, 1.2);
  CHECK(wrong.first.warnings.empty());
  REQUIRE(wrong.last.warnings.size() == 1);
  CHECK(contains(wrong.last.warnings, doubt));
  CHECK(contains(wrong.last.warnings, "up to 69 deg/s"));
  CHECK(contains(wrong.last.warnings, "`gyro_unit: rad_s`"));
  CHECK(contains(wrong.inspected, doubt));
  // True degrees, and a standstill from end to end.
  for (const double fastest : {45.0, 0.2}) {
    const Whole fine = read_whole(GyroUnit::deg_s, fastest);
    CHECK(fine.last.warnings.empty());
    CHECK_FALSE(contains(fine.inspected, "gyro_unit"));
  }
  for (const GyroUnit unit : {GyroUnit::rad_s, GyroUnit::automatic}) {
    CHECK(read_whole(unit, 1.2).last.warnings.empty());
  }
}

TEST_CASE("spikes do not hide degrees per second that the recording speaks against") {
  TemporaryFolder folder;
  Recording recording;
  recording.seconds = 8;
  recording.turn = [](int i) {
    if (i % 100 == 50 || i % 100 == 52) return Vec3(50, 0, 0);
    return Vec3(i >= 600 && i < 700 ? 1.2 : 0.01, 0, 0);
  };
  recording.write(folder / "a.bag");
  SensorConfig sensor;
  sensor.gyro_unit = GyroUnit::deg_s;
  const auto source = open_source(folder / "a.bag", sensor);
  drain(*source);
  CHECK(contains(source->notes().warnings, "spikes aside, turns faster than 1.200 deg/s"));
  // What turns for a twentieth of a second once in an hour is a turn.
  recording.turn = [](int i) { return Vec3(i >= 600 && i < 605 ? 45 : 1.2, 0, 0); };
  recording.write(folder / "b.bag");
  const auto turning = open_source(folder / "b.bag", sensor);
  drain(*turning);
  CHECK(turning->notes().warnings.empty());
}

TEST_CASE("degrees per second are doubted by what was read when the reading is ended early") {
  TemporaryFolder folder;
  Recording recording;
  recording.seconds = 8;
  recording.turn = [](int i) { return Vec3(i >= 100 && i < 200 ? 1.2 : i >= 700 ? 45 : 0.01, 0, 0); };
  recording.write(folder / "a.bag");
  SensorConfig sensor;
  sensor.gyro_unit = GyroUnit::deg_s;
  const auto source = open_source(folder / "a.bag", sensor);
  for (int i = 0; i < 300; ++i) REQUIRE(source->next());
  CHECK(source->notes().warnings.empty());
  source->conclude();
  source->conclude();
  REQUIRE(source->notes().warnings.size() == 1);
  CHECK(contains(source->notes().warnings, "turns faster than 1.200 deg/s"));
}

TEST_CASE("rates beyond any gyroscope are counted over the whole recording") {
  const Whole fast = read_whole(GyroUnit::rad_s, 90, 3);
  CHECK(fast.first.warnings.empty());
  REQUIRE(fast.last.warnings.size() == 1);
  for (const std::string& text : {fast.last.warnings.front(), fast.inspected}) {
    CHECK(contains(text, "3 sample(s) turn faster than 40 rad/s (the fastest 90.0), beyond any gyroscope"));
    CHECK(contains(text, "`gyro_unit: deg_s`"));
  }
  CHECK(read_whole(GyroUnit::deg_s, 90, 3).last.warnings.empty());
  CHECK(
      contains(read_whole(GyroUnit::deg_s, 3000, 3).last.warnings, "(the fastest 52.4), beyond any gyroscope; check"));
}

TEST_CASE("what a sensor file knows of the IMU is taken out of every sample, and said") {  // eq. MOT-11
  TemporaryFolder folder;
  Recording recording;
  recording.turn = [](int i) { return Vec3(30 + i, -40, 20); };  // deg/s
  recording.write(folder / "a.bag");
  const auto samples = [&](const SensorConfig& sensor, std::vector<std::string>& verdicts) {
    const auto source = open_source(folder / "a.bag", sensor);
    std::vector<ImuSample> out;
    while (const auto measurement = source->next()) {
      if (const auto* sample = std::get_if<ImuSample>(&*measurement)) out.push_back(*sample);
    }
    verdicts = source->notes().verdicts;
    return out;
  };
  SensorConfig sensor;
  sensor.gyro_unit = GyroUnit::deg_s;
  std::vector<std::string> verdicts;
  const auto raw = samples(sensor, verdicts);
  CHECK_FALSE(contains(verdicts, "of the sensor file"));
  sensor.gyro_sensitivity << 0.01, 0.002, 0, -0.003, -0.008, 0.001, 0.004, 0, 0.006;
  sensor.imu_delay = 0.002;
  const auto taken = samples(sensor, verdicts);
  REQUIRE(taken.size() == raw.size());
  REQUIRE(raw.size() > 100);
  for (std::size_t i = 0; i < raw.size(); ++i) {
    CHECK((taken[i].gyro + sensor.gyro_sensitivity * taken[i].gyro - raw[i].gyro).norm() < 1e-14);
    CHECK(taken[i].t == raw[i].t - 2 * kSecond / 1000);
    CHECK(taken[i].acc == raw[i].acc);
  }
  CHECK(contains(verdicts, "(scale up to 1.00 %, cross-axis up to 0.40 %)"));
  CHECK(contains(verdicts, "2.000 ms earlier than sent, by the imu_delay of the sensor file"));
  // A section is one of the motion, not of stamps.
  const auto part = open_source(folder / "a.bag", sensor, {.start = 1.0, .duration = 0.5});
  while (const auto measurement = part->next()) {
    const auto* sample = std::get_if<ImuSample>(&*measurement);
    if (sample != nullptr) CHECK((sample->t >= *part->begin_time() && sample->t < *part->end_time()));
  }
  sensor.imu_delay = -0.001;
  CHECK(samples(sensor, verdicts).front().t == raw.front().t + kSecond / 1000);
  CHECK(contains(verdicts, "1.000 ms later than sent"));
}

}  // namespace aslio::io::test
