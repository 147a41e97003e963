// What an IMU that is too slow for the motion does not read (eq. MOT-14).
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "aslio/toolkit/imu_noise.hpp"
#include "plugins/estimators/room_filter.hpp"

using namespace aslio;
using namespace aslio::test;

namespace {

ImuSample between(const ImuSample& a, const ImuSample& b, TimeNs t) {
  const double share = to_seconds(t - a.t) / to_seconds(b.t - a.t);
  ImuSample sample = a;
  sample.t = t;
  sample.gyro = a.gyro + share * (b.gyro - a.gyro);
  sample.acc = a.acc + share * (b.acc - a.acc);
  return sample;
}

/// The stream, cut into windows of `length` whose ends are interpolated as those of Window::imu are.
UnresolvedMotion::Density after(const std::vector<ImuSample>& stream, double length) {
  UnresolvedMotion unresolved;
  const TimeNs step = to_ns(length);
  const auto at = [&](TimeNs t) {
    std::size_t i = 1;
    while (i + 1 < stream.size() && stream[i].t < t) ++i;
    return between(stream[i - 1], stream[i], t);
  };
  for (TimeNs begin = stream.front().t; begin + step <= stream.back().t; begin += step) {
    std::vector<ImuSample> window{at(begin)};
    for (const ImuSample& sample : stream) {
      if (sample.t > begin && sample.t < begin + step) window.push_back(sample);
    }
    window.push_back(at(begin + step));
    const auto is_reading = [&](const ImuSample& sample) { return sample.t == begin + step; };
    Window observed;
    observed.imu = window;
    observed.imu_read_at_end = std::any_of(stream.begin(), stream.end(), is_reading);
    unresolved.observe(observed);
  }
  return unresolved.density();
}

/// Samples that have nothing to do with each other: vibration, read too seldom.
std::vector<ImuSample> shaken(double rate, double gyro, double acc, double seconds) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  const auto vector = [&](double sigma) {
    return Vec3(sigma * normal(random), sigma * normal(random), sigma * normal(random));
  };
  std::vector<ImuSample> stream;
  for (int i = 0; i < static_cast<int>(seconds * rate); ++i) {
    ImuSample sample;
    sample.t = to_ns(1.0 + i / rate);
    sample.gyro = vector(gyro);
    sample.acc = Vec3(0, 0, 9.8) + vector(acc);
    stream.push_back(sample);
  }
  return stream;
}

}  // namespace

TEST_CASE(
    "unresolved motion: vibration at 10 Hz counts as half the noise that its integral has, wherever windows end") {
  constexpr double rate = 10.0, gyro = 0.02, acc = 0.5;
  for (const double length : {0.05, 0.07, 0.1, 0.1013, 0.21}) {
    CAPTURE(length);
    double gyro_density = 0, acc_density = 0;
    constexpr int kTimes = 40;  // each has the memory of a second: ten samples
    const auto stream = shaken(rate, gyro, acc, 4.0 * kTimes);
    for (int i = 0; i < kTimes; ++i) {
      const std::vector<ImuSample> part(stream.begin() + 40 * i, stream.begin() + 40 * (i + 1));
      const UnresolvedMotion::Density unresolved = after(part, length);
      gyro_density += unresolved.gyro / kTimes;
      acc_density += unresolved.acc / kTimes;
    }
    CHECK(gyro_density == Approx(0.5 * gyro * gyro / rate).epsilon(0.2));
    CHECK(acc_density == Approx(0.5 * acc * acc / rate).epsilon(0.2));
  }
}

TEST_CASE("unresolved motion: none of a fast IMU, of an even turn, or of a constant change of the rate") {
  for (const double rate : {51.0, 100.0, 200.0, 1000.0}) {
    CAPTURE(rate);
    const UnresolvedMotion::Density unresolved = after(shaken(rate, 0.02, 0.5, 4.0), 0.07);
    CHECK(unresolved.gyro == 0.0);
    CHECK(unresolved.acc == 0.0);
  }
  std::vector<ImuSample> stream = shaken(10.0, 0.0, 0.0, 4.0);
  for (ImuSample& sample : stream) sample.gyro = Vec3(0.1, 0.0, 0.3 * to_seconds(sample.t));
  CHECK(after(stream, 0.07).gyro == Approx(0.0).margin(1e-20));
}

TEST_CASE("unresolved motion: a smooth turn has some, and more the slower the IMU is") {
  const auto turning = [](double rate) {
    std::vector<ImuSample> stream = shaken(rate, 0.0, 0.0, 6.0);
    for (ImuSample& sample : stream) sample.gyro = Vec3(0.0, 0.0, std::sin(2.0 * to_seconds(sample.t)));
    return std::sqrt(after(stream, 0.07).gyro * rate);
  };
  // The mean rate of an interval is off by up to T^2 w'' / 12 = 3.3 mrad/s at 10 Hz.
  CHECK(turning(10.0) > 0.0023);
  CHECK(turning(10.0) < 0.012);
  CHECK(turning(20.0) == Approx(turning(10.0) / 4.0).epsilon(0.2));
}

TEST_CASE("unresolved motion: samples that are not believed, and repeated ones, do not count") {
  std::vector<ImuSample> stream = shaken(10.0, 0.0, 0.0, 4.0);
  stream[20].gyro.x() = 3.0;
  stream[20].faults = imu_fault::gyro_dead;
  Window window;
  window.imu = stream;
  UnresolvedMotion unresolved;
  unresolved.observe(window);
  CHECK(unresolved.density().gyro == 0.0);
  stream[30].gyro.x() = 3.0;
  stream[31].t = stream[30].t;
  unresolved.observe(window);  // all of it again: these readings are known
  CHECK(unresolved.density().gyro == 0.0);
  UnresolvedMotion repeated;
  repeated.observe(window);
  CHECK(std::isfinite(repeated.density().gyro));
  CHECK(repeated.density().gyro > 0.0);
}

TEST_CASE("a slow IMU: attitude and velocity are known worse by what it did not read, but under fastlio") {
  const std::string estimator =
      GENERATE(as<std::string>{}, "{type: ieskf, noise: physical}", "{type: ieskf, noise: fastlio}",
               "{type: ct_icp, prediction: imu, noise: physical}", "{type: smoother, noise: physical}");
  CAPTURE(estimator);
  const auto predicted = [&](double shake) {
    Filter filter({"estimator=" + estimator}, 0.01, true);
    filter.build_map(1);
    filter.update(RoomWindow(kRoomEpoch, kTenth, Pose{}, 2, 3000));
    RoomWindow blind(kRoomEpoch + kTenth, 2 * kSecond, Pose{}, 3, 3000);
    blind.window.fresh = {};
    std::vector<ImuSample> imu(blind.window.imu.begin(), blind.window.imu.end());
    std::vector<ImuSample> slow;
    for (std::size_t i = 0; i < imu.size(); ++i) {
      if (i == 0 || i + 1 == imu.size() || imu[i].t - slow.back().t >= kTenth) slow.push_back(imu[i]);
    }
    for (std::size_t i = 1; i + 1 < slow.size(); ++i) slow[i].acc.z() += i % 2 == 0 ? shake : -shake;
    blind.window.imu = slow;
    const Update& update = filter.update(blind);
    REQUIRE_FALSE(update.accepted);
    return update.P(block::v + 2, block::v + 2);
  };
  const double still = predicted(0.0), shaken_by = predicted(0.5);
  if (estimator.find("fastlio") != std::string::npos) {
    CHECK(shaken_by == Approx(still).epsilon(1e-3));
  } else {
    CHECK(shaken_by > 1.5 * still);
  }
}

TEST_CASE("unresolved motion: none where a fast IMU has lost samples, nor where stamps are uneven") {
  for (const double rate : {100.0, 200.0, 1000.0}) {
    CAPTURE(rate);
    std::vector<ImuSample> stream = shaken(rate, 0.02, 0.5, 4.0);
    const auto hole = [&](double at, double length) {
      std::erase_if(stream,
                    [&](const ImuSample& s) { return s.t > to_ns(1.0 + at) && s.t < to_ns(1.0 + at + length); });
    };
    hole(1.0, 0.025);
    hole(2.0, 0.1);
    hole(3.0, 0.041);
    CHECK(after(stream, 0.07).gyro == 0.0);
  }
  std::vector<ImuSample> pairs = shaken(10.0, 0.02, 0.5, 4.0);
  for (std::size_t i = 1; i < pairs.size(); i += 2) pairs[i].t = pairs[i - 1].t + to_ns(0.001);
  CHECK(after(pairs, 0.07).gyro == 0.0);
}

TEST_CASE("unresolved motion: a start trusts the IMU, and doubts it within a second") {
  const auto stream = shaken(10.0, 0.02, 0.5, 400.0);
  double early = 0, later = 0;
  for (int i = 0; i < 200; ++i) {
    const auto begin = stream.begin() + 20 * i;
    early += after({begin, begin + 4}, 0.1).gyro / 200;
    later += after({begin, begin + 20}, 0.1).gyro / 200;
  }
  CHECK(early < 0.2 * later);
  CHECK(later > 0.7 * 0.5 * 0.02 * 0.02 / 10.0);
}
