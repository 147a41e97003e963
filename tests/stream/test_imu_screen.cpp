// Readings of the IMU that are refused or marked, and those that must pass as they are.
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>

#include "aslio/stream/imu_screen.hpp"
#include "stream/stream_data.hpp"

using namespace aslio;
using namespace aslio::test;
using Catch::Matchers::Contains;
using stream::ImuRange;
using stream::ImuScreen;

namespace {

constexpr double kG = kStandardGravity;

/// A walk without anything odd: turns, steps and noise, at `rate` [Hz].
std::vector<ImuSample> walk(std::uint64_t seed, int count, double rate = 200) {
  std::mt19937_64 random(seed);
  const auto noise = [&](double size) {
    return size * 1e-6 * static_cast<double>(pick(random, -1'000'000, 1'000'000));
  };
  std::vector<ImuSample> out;
  for (int i = 0; i < count; ++i) {
    const double t = i / rate;
    ImuSample s{kEpoch + to_ns(t)};
    s.gyro = Vec3(0.3 * std::sin(7 * t), 0.2 * std::cos(5 * t), 2.5 * std::sin(1.5 * t));
    s.acc = Vec3(1.5 * std::sin(12 * t), 1.0 * std::cos(11 * t), kG + 3.0 * std::sin(12.5 * t));
    for (int axis = 0; axis < 3; ++axis) {
      s.gyro[axis] += noise(0.01);
      s.acc[axis] += noise(0.1);
    }
    out.push_back(s);
  }
  return out;
}

struct Screened {
  std::vector<ImuSample> samples;
  stream::ImuFindings findings;
  std::vector<std::string> warnings;
  std::size_t most_held = 0;
};

Screened screened(const std::vector<ImuSample>& recording, const ImuRange& range = {}) {
  ImuScreen screen(range);
  Screened out;
  std::size_t pushed = 0;
  for (const ImuSample& s : recording) {
    const auto judged = screen.push(s);
    out.samples.insert(out.samples.end(), judged.begin(), judged.end());
    out.most_held = std::max(out.most_held, ++pushed - out.samples.size());
  }
  const auto rest = screen.finish();
  out.samples.insert(out.samples.end(), rest.begin(), rest.end());
  out.findings = screen.findings();
  out.warnings = screen.warnings();
  return out;
}

bool alike(const ImuSample& a, const ImuSample& b) {
  return a.t == b.t && a.gyro == b.gyro && a.acc == b.acc && a.faults == b.faults;
}

bool alike(const std::vector<ImuSample>& a, const std::vector<ImuSample>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const ImuSample& l, const ImuSample& r) { return alike(l, r); });
}

void check_passes(const std::vector<ImuSample>& recording) {
  const Screened out = screened(recording);
  CHECK(alike(out.samples, recording));
  CHECK(out.findings.spikes + out.findings.gyro_clipped + out.findings.acc_clipped + out.findings.stuck == 0);
  CHECK(out.warnings.empty());
}

std::vector<ImuSample> changed(std::vector<ImuSample> samples, std::size_t from, std::size_t count,
                               const std::function<void(ImuSample&)>& change) {
  for (std::size_t i = from; i < from + count; ++i) change(samples[i]);
  return samples;
}

std::size_t marked(const std::vector<ImuSample>& samples, std::uint8_t faults) {
  return static_cast<std::size_t>(
      std::count_if(samples.begin(), samples.end(), [=](const ImuSample& s) { return (s.faults & faults) != 0; }));
}

}  // namespace

TEST_CASE("screen: a walk passes at once and as it is, at any rate") {
  for (const double rate : {10.0, 50.0, 100.0, 200.0, 400.0, 1000.0}) {
    CAPTURE(rate);
    const auto recording = walk(1, 2000, rate);
    const Screened out = screened(recording);
    CHECK(alike(out.samples, recording));
    CHECK(out.most_held == 0);
    CHECK(out.findings.spikes == 0);
  }
}

TEST_CASE("screen: one to three samples far from their neighbours are refused, and the others are as without them") {
  for (const double rate : {10.0, 100.0, 200.0, 400.0}) {
    const auto clean = walk(2, 600, rate);
    for (const std::size_t n : {1U, 2U, 3U}) {
      if (rate < 50 && n > 1) continue;  // 0.2 s of a turn
      for (std::size_t at = 5; at + n < clean.size(); at += 23) {
        CAPTURE(rate, n, at);
        auto expected = clean;
        expected.erase(expected.begin() + static_cast<std::ptrdiff_t>(at),
                       expected.begin() + static_cast<std::ptrdiff_t>(at + n));
        for (const double sign : {-1.0, 1.0}) {
          const Screened gyro = screened(changed(clean, at, n, [=](ImuSample& s) { s.gyro.y() = sign * 20; }));
          CHECK(alike(gyro.samples, expected));
          CHECK(gyro.findings.spikes == n);
          const Screened acc = screened(changed(clean, at, n, [=](ImuSample& s) { s.acc.x() = sign * 25 * kG; }));
          CHECK(alike(acc.samples, expected));
          CHECK(acc.findings.spikes == n);
          CHECK(acc.most_held <= n);
        }
      }
    }
  }
}

TEST_CASE("screen: spikes of either sign in a row, and one at the very end") {
  const auto clean = walk(3, 300);
  auto recording = changed(clean, 100, 1, [](ImuSample& s) { s.gyro.x() = 25; });
  recording[101].gyro.x() = -25;
  recording.back().acc.z() = -30 * kG;
  const Screened out = screened(recording);
  CHECK(out.findings.spikes == 3);
  CHECK(out.samples.size() == 297);
}

TEST_CASE("screen: what a body does is no spike") {
  SECTION("heel strikes of 4 to 6 g over one or two samples") {
    for (const double strike : {4.0, 5.0, 6.0}) {
      for (const std::size_t n : {1U, 2U}) {
        auto recording = walk(4, 1000);
        for (std::size_t at = 50; at < 990; at += 100)
          recording = changed(recording, at, n, [=](ImuSample& s) { s.acc.z() += strike * kG; });
        check_passes(recording);
      }
    }
  }
  SECTION("a turn of 1500 deg/s within 60 ms and back") {
    auto recording = walk(5, 1000);
    for (std::size_t i = 0; i < 60; ++i) {
      const double share = std::sin(static_cast<double>(i) * M_PI / 60);
      recording[300 + i].gyro.z() += 26.2 * std::min(1.0, 3 * share);
    }
    check_passes(recording);
  }
  SECTION("a rate that is there at once, and stays") {
    check_passes(changed(walk(6, 600), 300, 100, [](ImuSample& s) { s.gyro.z() += 20; }));
  }
  SECTION("an accelerometer that shakes by 16 g") {
    auto recording = walk(7, 1000);
    std::mt19937_64 random(8);
    for (ImuSample& s : recording) s.acc.y() += 16 * kG * 1e-3 * static_cast<double>(pick(random, -1000, 1000));
    CHECK(screened(recording).findings.spikes < 5);  // at its begin it is not yet usual
  }
  SECTION("a slow IMU in a turn") {
    auto recording = walk(9, 200, 10);
    for (std::size_t i = 100; i < 105; ++i) recording[i].gyro.z() += 8;
    check_passes(recording);
  }
}

TEST_CASE("screen: readings at the end of a declared range are marked, by axis") {  // eq. MOT-12
  const auto recording = changed(walk(10, 600), 200, 20, [](ImuSample& s) {
    s.gyro.z() = -4.97;
    s.acc.x() = 39.9;
  });
  const Screened out = screened(recording, {5.0, 40.0});
  CHECK(out.findings.gyro_clipped == 20);
  CHECK(out.findings.acc_clipped == 20);
  CHECK(marked(out.samples, imu_fault::clipped(false, 2)) == 20);
  CHECK(marked(out.samples, imu_fault::clipped(true, 0)) == 20);
  CHECK(marked(out.samples, imu_fault::clipped(false, 0) | imu_fault::clipped(true, 1)) == 0);
  CHECK(out.most_held <= 3);  // the rate is there at once
  CHECK(out.warnings.empty());
}

TEST_CASE("screen: the end of a range that is not declared is found where an extreme reading is repeated") {
  auto recording = walk(11, 3000);
  std::size_t at_end = 0;
  for (ImuSample& s : recording) {
    at_end += std::abs(s.gyro.z()) > 2.0;
    s.gyro.z() = std::clamp(s.gyro.z(), -2.0, 2.0);
  }
  const Screened out = screened(recording);
  CHECK(out.samples.size() == recording.size());
  CHECK(out.findings.gyro_clipped + 1 >= at_end);  // the first is gone before it is known
  CHECK(out.findings.acc_clipped == 0);
  REQUIRE(out.warnings.size() == 1);
  CHECK_THAT(out.warnings[0], Contains("gyroscope") && Contains("`gyro_range: 2`"));
  CHECK(out.most_held <= 8);

  for (ImuSample& s : recording) s.acc.z() = std::min(s.acc.z(), 11.0);
  CHECK(screened(recording).findings.acc_clipped == 0);  // gravity may rest there
  for (ImuSample& s : recording) s.acc.z() = std::min(s.acc.z() + 6, 17.0);
  const Screened acc = screened(recording);
  CHECK(acc.findings.acc_clipped > 500);
  CHECK(acc.warnings.size() == 2);
}

TEST_CASE("screen: the end of a range is found at the jolts of steps, which meet it for one to four samples each") {
  for (const int length : {1, 2, 4}) {
    for (const double sign : {1.0, -1.0}) {
      CAPTURE(length, sign);
      auto recording = walk(9, 2000);
      const auto original = recording;
      std::mt19937_64 random(3);
      std::vector<std::size_t> beyond;
      for (std::size_t step = 200; step + 10 < recording.size(); step += 74) {
        const double peak = 1e-3 * static_cast<double>(pick(random, 40'000, 60'000));
        for (int i = 0; i < length; ++i) {
          const std::size_t at = step + static_cast<std::size_t>(i);
          recording[at].acc.z() = sign * std::min(peak, 3 * kG);
          beyond.push_back(at);
        }
        recording[step - 2].acc.z() = sign * 20.0;  // on the way up, at times nearly there, and down
        recording[step - 1].acc.z() = sign * (step % 4 == 0 ? 28.0 : 24.0);
        recording[step + static_cast<std::size_t>(length)].acc.z() = sign * 15.5;
      }
      const Screened out = screened(recording);
      REQUIRE(out.samples.size() == recording.size());
      std::size_t marked = 0;
      for (std::size_t i = 0; i < recording.size(); ++i) {
        const bool clipped = (out.samples[i].faults & imu_fault::acc_clipped) != 0;
        marked += clipped ? 1 : 0;
        if (clipped) REQUIRE(std::abs(recording[i].acc.z()) == 3 * kG);
      }
      CHECK(marked + 4 >= beyond.size());  // those of the first jolts may have passed
      CHECK_THAT(out.warnings.at(0), Contains("accelerometer") && Contains("`acc_range: 29.42"));
    }
  }
}

TEST_CASE("screen: what is steep depends on the time between samples, and a gap before a peak is no step") {
  // At 50 Hz a step of 6 m/s^2 from one sample to the next is no jolt, though its top is read four times.
  auto slow = walk(12, 4000, 50);
  for (std::size_t at = 100; at + 4 < slow.size(); at += 50)
    for (std::size_t i = 0; i < 4; ++i) slow[at + i].acc.z() = 16.0;
  CHECK(screened(slow).findings.acc_clipped == 0);
  const auto torn = walk(13, 8000);
  std::vector<ImuSample> gaps;
  for (std::size_t i = 0; i < torn.size(); ++i) {
    if (i % 400 >= 380) continue;
    gaps.push_back(torn[i]);
    if (i % 400 == 0) gaps.back().acc.z() = 16.0;
  }
  CHECK(screened(gaps).findings.acc_clipped == 0);
}

TEST_CASE("screen: peaks that differ, readings in coarse steps, and smooth turns have no end of a range") {
  auto recording = walk(10, 40000);
  std::mt19937_64 random(4);
  SECTION("jolts of different heights") {
    for (std::size_t step = 200; step < recording.size(); step += 74)
      recording[step].acc.z() = 1e-3 * static_cast<double>(pick(random, 16'000, 40'000));
  }
  SECTION("jolts that are read in steps of 0.05 m/s^2") {
    for (std::size_t step = 200; step < recording.size(); step += 74)
      recording[step].acc.z() = 16 + 0.05 * static_cast<double>(pick(random, 0, 480));
  }
  SECTION("turns that are read in steps of 0.02 rad/s") {
    for (ImuSample& s : recording) s.gyro = (s.gyro / 0.02).array().round() * 0.02;
  }
  SECTION("vibration of one amplitude that is read in steps of 0.2 m/s^2 and 0.05 rad/s") {
    for (std::size_t i = 0; i < recording.size(); ++i) {
      const double swing = std::sin(2.31 * static_cast<double>(i));
      const double noise = 1e-6 * static_cast<double>(pick(random, 0, 300'000));
      recording[i].acc.z() = 0.2 * std::round((kG + 10 * swing + noise) / 0.2);
      recording[i].gyro.x() = 0.05 * std::round(3 * swing / 0.05);
    }
  }
  const Screened out = screened(recording);
  CHECK(out.warnings.empty());
  CHECK(out.findings.acc_clipped == 0);
  CHECK(out.findings.gyro_clipped == 0);
}

TEST_CASE("screen: a larger reading later voids an end that was found") {
  auto recording = changed(walk(12, 2000), 100, 12, [](ImuSample& s) { s.gyro.x() = 2.9; });
  for (std::size_t i = 400; i < 420; ++i) recording[i].gyro.x() = 3 + 0.01 * static_cast<double>(i);
  const Screened out = screened(recording);
  CHECK(out.warnings.empty());
  CHECK(out.findings.gyro_clipped >= 10);
  CHECK(out.findings.gyro_clipped <= 13);
}

TEST_CASE("screen: readings that are repeated by a few, or slowly sampled ones, are as they are") {
  auto recording = walk(13, 2000);
  for (std::size_t i = 1; i < recording.size(); i += 2) {  // sampled at 100 Hz, sent at 200
    recording[i].gyro = recording[i - 1].gyro;
    recording[i].acc = recording[i - 1].acc;
  }
  check_passes(recording);
  auto coarse = walk(14, 4000);
  for (ImuSample& s : coarse) {  // of 8 bits
    for (int axis = 0; axis < 3; ++axis) {
      s.gyro[axis] = std::round(s.gyro[axis] * 50) / 50;
      s.acc[axis] = std::round(s.acc[axis] * 10) / 10;
    }
  }
  check_passes(coarse);
}

TEST_CASE("screen: a sensor that repeats itself for 0.2 s is stuck, from its first repetition on") {
  for (const double rate : {50.0, 100.0, 200.0, 400.0}) {
    CAPTURE(rate);
    const auto clean = walk(15, 1000, rate);
    const auto freeze = [&](ImuSample& s) {
      s.gyro = clean[499].gyro;
      s.acc = clean[499].acc;
    };
    const Screened out = screened(changed(clean, 500, 200, freeze));
    CHECK(out.samples.size() == clean.size());
    CHECK(out.findings.stuck == 200);
    CHECK(marked(out.samples, imu_fault::gyro_dead) == 200);
    CHECK(marked(out.samples, imu_fault::acc_dead) == 200);
    CHECK(static_cast<double>(out.most_held) <= 0.21 * rate);
    const Screened gyro = screened(changed(clean, 500, 200, [&](ImuSample& s) { s.gyro = clean[499].gyro; }));
    CHECK(marked(gyro.samples, imu_fault::gyro_dead) == 200);
    CHECK(marked(gyro.samples, imu_fault::acc_dead) == 0);
    const Screened brief = screened(changed(clean, 500, static_cast<std::size_t>(0.15 * rate), freeze));
    CHECK(brief.findings.stuck == 0);
  }
}

TEST_CASE("screen: a simulated IMU without noise may rest") {
  std::vector<ImuSample> recording;
  for (int i = 0; i < 400; ++i) recording.push_back({kEpoch + i * 5'000'000, Vec3(0.1, 0, 0), Vec3(0, 0, kG)});
  check_passes(recording);
}

TEST_CASE("screen: what reads zero, gravity included, is marked at once") {
  const auto clean = walk(16, 600);
  const Screened out = screened(changed(clean, 300, 40, [](ImuSample& s) { s.gyro = s.acc = Vec3::Zero(); }));
  CHECK(out.findings.zero == 40);
  CHECK(out.findings.stuck == 0);
  CHECK(out.most_held == 0);
  CHECK(marked(out.samples, imu_fault::gyro_dead) == 40);
}

TEST_CASE("screen: a late sample passes, whatever has come since") {
  auto recording = walk(17, 300);
  std::swap(recording[100], recording[101]);
  check_passes(recording);
}
