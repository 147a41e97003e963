// What the odometry has to reach on the recordings in ASLIO_RECORDINGS_DIR. Missing data fail the tests.
#include <algorithm>
#include <catch2/catch.hpp>

#include "aslio/evaluation/evaluation.hpp"
#include "aslio/experiment/measure.hpp"
#include "aslio/io/writers.hpp"
#include "recordings/recorded_run.hpp"
#include "recordings/unpacked.hpp"

namespace aslio::test {
namespace {

/// Turn rates [rad/s] of the reference at its samples.
std::vector<double> turn_rates(const Trajectory& truth) {
  std::vector<double> rates;
  rates.reserve(truth.size());
  for (const StampedPose& sample : truth.samples()) rates.push_back(evaluation::turn_rate(truth, sample.t));
  return rates;
}

/// Times of the maxima above 1.2 rad/s that are more than 1 s apart.
std::vector<TimeNs> sharp_turns(const Trajectory& truth, const std::vector<double>& rates) {
  std::vector<std::size_t> order(rates.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return rates[a] > rates[b]; });
  std::vector<TimeNs> found;
  for (const std::size_t i : order) {
    if (rates[i] <= 1.2) break;
    const TimeNs t = truth.samples()[i].t;
    if (std::all_of(found.begin(), found.end(), [t](TimeNs f) { return std::abs(f - t) > kSecond; }))
      found.push_back(t);
  }
  return found;
}

double median(std::vector<double> values) {
  REQUIRE_FALSE(values.empty());
  std::sort(values.begin(), values.end());
  return 0.5 * (values[(values.size() - 1) / 2] + values[values.size() / 2]);
}

/// An update and the rate it stands for.
struct Step {
  TimeNs t = 0;
  double rate_hz = 0;
};

std::vector<Step> steps_of(const RecordedRun& run) {
  std::vector<Step> steps;
  for (std::size_t i = 1; i < run.update_times.size(); ++i) {
    steps.push_back({run.update_times[i], 1e9 / static_cast<double>(run.update_times[i] - run.update_times[i - 1])});
  }
  return steps;
}

/// Rates of the updates before which the reference turned slower than 0.3 rad/s for a second.
std::vector<double> calm_rates(const std::vector<Step>& steps, const Trajectory& truth,
                               const std::vector<double>& turning) {
  std::vector<double> calm;
  for (const Step& step : steps) {
    bool slow = truth.begin_time() <= step.t - kSecond;
    for (std::size_t i = 0; i < turning.size() && slow; ++i) {
      const TimeNs t = truth.samples()[i].t;
      slow = t < step.t - kSecond || t > step.t || turning[i] < 0.3;
    }
    if (slow) calm.push_back(step.rate_hz);
  }
  return calm;
}

/// Where a near wall fills the view of a sharp turn, updates are refused, and the status says so.
void check_whole(const RecordedRun& run) {
  INFO(run.summary.reason);
  const pipeline::RunStatus status = run.summary.status;
  CHECK((status == pipeline::RunStatus::ok || status == pipeline::RunStatus::degraded));
  CHECK(run.summary.evaluation.value().matched_share > 0.99);
}

/// Of the whole process: within one run of this program later cases also see the peaks of earlier ones. Scans of an
/// HDL-64 have ten times the points of an Avia's windows, and buffers to match.
void check_memory(const RecordedRun& run, double limit_mb = 150) {
  CHECK(run.summary.peak_rss_mb > 0);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  CHECK(run.summary.peak_rss_mb <= limit_mb);
#endif
}

}  // namespace

// The corridor was simulated by an independent simulator, with an ideal IMU.
TEST_CASE("as_lio_plus stays within 6 mm on the corridor that an independent simulator simulated") {
  const RecordedRun run = run_on_avia("as_lio_plus");
  check_whole(run);
  CHECK(run.ate_m() <= 0.006);                       // measured 0.0024
  CHECK(run.summary.end_to_end_m.value() <= 0.006);  // measured 0.0015
  check_memory(run);
}

TEST_CASE("fixed_window stays within 6 mm on the corridor that an independent simulator simulated") {
  const RecordedRun run = run_on_avia("fixed_window");
  check_whole(run);
  CHECK(run.ate_m() <= 0.006);                       // measured 0.0024
  CHECK(run.summary.end_to_end_m.value() <= 0.006);  // measured 0.0019
  check_memory(run);
}

TEST_CASE("as_lio_plus_fast stays within 1 cm on the simulated corridor without a false alarm, from four beginnings") {
  for (const std::uint64_t phase : {0, 1, 2, 3}) {
    INFO(phase);
    const RecordedRun run = run_on_avia("as_lio_plus_fast", 1, {}, phase);
    INFO(run.summary.reason);
    CHECK(run.summary.status == pipeline::RunStatus::ok);
    CHECK(run.ate_m() <= 0.010);  // measured 0.0028 to 0.0047
  }
}

namespace {

/// Of the four sharp turns of the corridor, those in which the rate reaches 30 Hz; in calm it is 10 to 20 Hz, for the
/// noise of a narrow room costs some overlap.
std::size_t fast_turns(const std::vector<Step>& steps) {
  const Trajectory truth(io::read_tum(recorded("avia_corridor.gt.tum")));
  const std::vector<double> turning = turn_rates(truth);
  const std::vector<TimeNs> turns = sharp_turns(truth, turning);
  REQUIRE(turns.size() == 4);
  std::size_t fast = 0;
  for (const TimeNs turn : turns) {
    double fastest = 0;
    for (const Step& step : steps) {
      if (std::abs(step.t - turn) <= kSecond / 2) fastest = std::max(fastest, step.rate_hz);
    }
    if (fastest >= 30.0) ++fast;
  }
  const std::vector<double> calm = calm_rates(steps, truth, turning);
  REQUIRE(calm.size() > 20);
  CHECK(median(calm) > 12.0);
  CHECK(median(calm) < 18.0);
  CHECK(*std::min_element(calm.begin(), calm.end()) == Approx(10.0).epsilon(0.05));
  return fast;
}

}  // namespace

TEST_CASE("as_lio_plus updates at 30 Hz and more in the sharp turns that lose the known world, and slower in calm") {
  // One of the four turns in front of a wall that is known.
  CHECK(fast_turns(steps_of(run_on_avia("as_lio_plus"))) == 3);
}

TEST_CASE("weak_segments: 8 updates at 30 Hz and more in front of a wall that fills the view, too") {
  CHECK(fast_turns(steps_of(run_on_avia("as_lio_plus", 1, {"window.weak_segments=8"}))) == 4);
}

TEST_CASE("fixed_window follows FAST-LIO2 within 10 cm on the KITTI drive, with one thread as with two") {
  const RecordedRun run = run_on_kitti("fixed_window");
  CHECK(run.summary.status == pipeline::RunStatus::ok);
  CHECK(run.summary.reason.empty());
  CHECK(run.summary.counters.points_late == 0);
  CHECK(run.ate_m() <= 0.10);
  check_memory(run, 220);  // of which 45 are the second grid of planes; seen: 210.3
  CHECK(same_bits_on_kitti("fixed_window"));
}

TEST_CASE("as_lio_plus follows FAST-LIO2 within 6 cm on the KITTI drive, at 10 Hz, where its IMU has 9.7") {
  const RecordedRun run = run_on_kitti("as_lio_plus");
  CHECK(run.summary.status == pipeline::RunStatus::ok);
  CHECK(run.ate_m() <= 0.060);
  CHECK(run.summary.updates < 170);  // 125 Hz, which the overlap asks for, had 0.45 m
  CHECK(same_bits_on_kitti("as_lio_plus"));
}

TEST_CASE("the trajectory is the same in every bit with one thread, again, and with two") {
  for (const char* pipeline : {"as_lio_plus", "fixed_window"}) {
    INFO(pipeline);
    const RecordedRun run = run_on_avia(pipeline);
    CHECK(run.summary.updates > 200);
    CHECK(run_on_avia(pipeline).trajectory_sha256 == run.trajectory_sha256);
    const RecordedRun two = run_on_avia(pipeline, 2);
    CHECK(two.trajectory_sha256 == run.trajectory_sha256);
    check_memory(two);
  }
}

namespace {

/// A system of the literature: at most 25 % or 1 cm above the published program on the corridor, and next to its
/// trajectory on the drive.
struct Published {
  const char* pipeline;
  double ate_m;
};
constexpr Published kFastLio2{"fast_lio2", 0.0775}, kFasterLio{"faster_lio", 0.0525}, kPointLio{"point_lio", 0.0663};

void check_published(const Published& system) {
  const RecordedRun run = run_on_avia(system.pipeline);
  check_whole(run);
  std::vector<double> ates{run.ate_m()};
  for (const std::uint64_t phase : {1, 2}) ates.push_back(run_on_avia(system.pipeline, 1, {}, phase).ate_m());
  CHECK(median(ates) <= system.ate_m);  // a single phase of the stride may miss it (docs/systems.md)
  check_memory(run);
  CHECK(same_bits_on_avia(system.pipeline));
  const RecordedRun drive =
      run_on_kitti(system.pipeline, 1, "reference/kitti_0005/" + std::string(system.pipeline) + ".tum");
  CHECK(drive.summary.status == pipeline::RunStatus::ok);
  CHECK(drive.ate_m() <= 0.08);
}

}  // namespace

TEST_CASE("fast_lio2 does as well as the published program") { check_published(kFastLio2); }

TEST_CASE("fast_lio2 blind to 4 m does as well as the published program's run with that range") {
  const std::vector<std::string> blind{"samplers.0.min=4"};
  std::vector<double> ates;
  for (const std::uint64_t phase : {0, 1, 2}) {
    const RecordedRun run = run_on_avia("fast_lio2", 1, blind, phase);
    check_whole(run);
    ates.push_back(run.ate_m());
  }
  CHECK(median(ates) <= 0.125);  // a quarter more than the 0.100 m of its published run
}

TEST_CASE("faster_lio does as well as the published program") { check_published(kFasterLio); }

TEST_CASE("point_lio does as well as the published program") { check_published(kPointLio); }

TEST_CASE(
    "kiss_icp follows the published program within 15 cm on the KITTI drive, and is lost on the corridor, which it "
    "says") {
  const RecordedRun drive = run_on_kitti("kiss_icp");
  CHECK(drive.summary.status == pipeline::RunStatus::ok);
  const Trajectory published(io::read_tum(recorded("reference/kitti_0005/kiss_icp.tum")));
  const auto options = experiment::measuring_options(published, evaluation::Rule::interpolated);
  CHECK(evaluation::evaluate(drive.lidar, published, options).ate.translation.rmse <= 0.15);
  CHECK(same_bits_on_kitti("kiss_icp"));

  const RecordedRun corridor = run_on_avia("kiss_icp");
  CHECK(corridor.summary.status == pipeline::RunStatus::diverged);
  CHECK_FALSE(corridor.summary.reason.empty());
}

namespace {

struct Limits {
  const char* pipeline;
  double corridor, drive;  ///< ATE [m]
};

/// Whole on the corridor, and next to FAST-LIO2 on the KITTI drive.
void check_limits(std::initializer_list<Limits> systems) {
  for (const Limits& limits : systems) {
    INFO(limits.pipeline);
    const RecordedRun run = run_on_avia(limits.pipeline);
    check_whole(run);
    CHECK(run.ate_m() <= limits.corridor);
    CHECK(same_bits_on_avia(limits.pipeline));
    const RecordedRun drive = run_on_kitti(limits.pipeline);
    CHECK((drive.summary.status == pipeline::RunStatus::ok || drive.summary.status == pipeline::RunStatus::degraded));
    CHECK(drive.ate_m() <= limits.drive);
  }
}

}  // namespace

TEST_CASE("the systems without a published run stay whole on the corridor and next to FAST-LIO2 on the KITTI drive") {
  // As docs/systems.md has them, and a quarter or 1 cm more, whichever is larger.
  check_limits({{"ct_icp_imu", 0.031, 0.037}, {"sr_lio", 0.073, 0.041}, {"fr_lio", 0.029, 0.047}});
}

TEST_CASE("as_lio_plus with other estimators and maps stays whole on the corridor and the KITTI drive") {
  check_limits({{"as_lio_plus_on_ct_icp", 0.019, 0.055},
                {"as_lio_plus_on_ivox", 0.017, 0.035},
                {"as_lio_plus_on_pointwise_eskf", 0.026, 0.032},
                {"as_lio_plus_on_smoother", 0.015, 0.034}});
}

TEST_CASE("ct_icp stays next to FAST-LIO2 on the KITTI drive, and holds the turns of the corridor without an IMU") {
  const RecordedRun drive = run_on_kitti("ct_icp");
  CHECK((drive.summary.status == pipeline::RunStatus::ok || drive.summary.status == pipeline::RunStatus::degraded));
  CHECK(drive.ate_m() <= 0.04);
  const RecordedRun corridor = run_on_avia("ct_icp");
  check_whole(corridor);
  CHECK(corridor.ate_m() <= 0.09);  // 0.05 to 0.07 m from six beginnings
  CHECK(same_bits_on_avia("ct_icp"));
}

TEST_CASE("loam and lio_sam stay within 5 cm of FAST-LIO2 on the KITTI drive, with one thread as with two") {
  for (const char* pipeline : {"loam", "lio_sam"}) {
    INFO(pipeline);
    const RecordedRun drive = run_on_kitti(pipeline);
    CHECK(drive.summary.status == pipeline::RunStatus::ok);
    CHECK(drive.ate_m() <= 0.05);
    CHECK(same_bits_on_kitti(pipeline));
  }
}

TEST_CASE("loam stays whole on the corridor, and lio_sam is right there or the monitor stops it") {
  const RecordedRun loam = run_on_avia("loam");
  check_whole(loam);
  CHECK(loam.ate_m() <= 0.48);
  // In the narrow view of an Avia features leave the direction of the corridor open. It is lost by 1.5 m and more.
  for (const std::uint64_t phase : {0, 1, 2, 3}) {
    const RecordedRun run = run_on_avia("lio_sam", 1, {}, phase);
    CAPTURE(phase, run.summary.reason, run.ate_m());
    CHECK(run.summary.evaluation.value().matched_share > 0.99);
    // Losses are those that the run finds itself: the reference takes no part.
    CHECK((run.ate_m() <= 0.29 || !run.summary.losses.empty()));
  }
}

}  // namespace aslio::test
