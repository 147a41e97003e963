// Steps of the gyro's bias (eq. MOT-13).
#include <catch2/catch.hpp>
#include <random>

#include "../../framework/engine/src/pipeline/bias_watch.hpp"

using namespace aslio;
using namespace aslio::pipeline;

namespace {

constexpr TimeNs kBegin = 1'700'000'000 * kSecond;

/// Updates at an even pace whose predictions are turned back by a rate, with some noise.
class Pulls {
 public:
  explicit Pulls(TimeNs length) : length_(length) {}
  double step(const Vec3& pull, double gyro = 0.1, std::uint8_t faults = 0, bool accepted = true) {
    const Vec3 reading(gyro, 0, 0);
    const std::vector<ImuSample> imu = {{t_, reading, Vec3::Zero(), faults},
                                        {t_ + length_, reading, Vec3::Zero(), faults}};
    Window window;
    window.plan.fresh_begin = t_;
    window.plan.end = t_ += length_;
    window.imu = imu;
    Update update;
    update.accepted = accepted;
    update.status = UpdateStatus::ok;
    const Vec3 noise = 0.002 * Vec3(normal_(engine_), normal_(engine_), normal_(engine_));
    update.state.R = exp_so3(to_seconds(length_) * (pull + noise));
    return watch_.observe(window, update);
  }
  /// Time until a step is found within `most` seconds [s]; and what it says.
  std::optional<std::pair<double, double>> until_found(const Vec3& pull, double most, double gyro = 0.1,
                                                       std::uint8_t faults = 0) {
    for (double time = 0; time < most; time += to_seconds(length_)) {
      const double found = step(pull, gyro, faults);
      if (found > 0) return std::pair(time, found);
    }
    return std::nullopt;
  }

 private:
  TimeNs length_, t_ = kBegin;
  BiasWatch watch_;
  std::mt19937 engine_{100};
  std::normal_distribution<double> normal_;
};

}  // namespace

TEST_CASE("bias watch: a step is found within a second, at any rate of updates, and a quiet run has none") {
  for (const TimeNs length : {kSecond / 10, kSecond / 50, kSecond / 125}) {
    CAPTURE(length);
    Pulls play(length);
    CHECK_FALSE(play.until_found(Vec3::Zero(), 10));
    const auto found = play.until_found(Vec3(0, 0, 0.02), 1);
    REQUIRE(found);
    CHECK(found->second > 0.005);
    CHECK(found->second < 0.03);
    // It is learnt now; the watch has to see what is usual before it speaks again.
    CHECK_FALSE(play.until_found(Vec3::Zero(), 10));
  }
}

TEST_CASE("bias watch: a sharp turn, marked samples, refused updates and a small step say nothing") {
  Pulls play(kSecond / 10);
  CHECK_FALSE(play.until_found(Vec3::Zero(), 10));
  CHECK_FALSE(play.until_found(Vec3(0, 0, 0.02), 3, 2.0));
  CHECK_FALSE(play.until_found(Vec3(0, 0, 0.02), 3, 0.1, imu_fault::clipped(false, 1)));
  for (int i = 0; i < 30; ++i) CHECK(play.step(Vec3(0, 0, 0.02), 0.1, 0, false) == 0);
  CHECK_FALSE(play.until_found(Vec3(0, 0, 0.001), 10));
  CHECK(play.until_found(Vec3(0, 0, 0.02), 1));
}
