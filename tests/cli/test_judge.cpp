/// What status a run deserves, and in which words.

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <random>

#include "aslio/experiment/measure.hpp"
#include "aslio/experiment/summary.hpp"

using namespace aslio;
using Catch::Matchers::Contains;
using experiment::judge;
using experiment::RunOutcome;
using experiment::Summary;
using pipeline::RunStatus;

namespace {

constexpr auto kDegenerate = static_cast<std::size_t>(UpdateStatus::degenerate);
constexpr auto kFewMatches = static_cast<std::size_t>(UpdateStatus::few_matches);
constexpr auto kInitialising = static_cast<std::size_t>(UpdateStatus::initialising);

/// A run that is fine.
Summary good_run() {
  Summary s;
  s.updates = s.accepted = 200;
  s.updates_by_status[0] = 200;
  s.counters.points = s.counters.imu = 1000;
  s.matchable_points = 1000;
  s.coverage = 1.0;
  return s;
}

Summary with(Summary s, std::size_t status, std::uint64_t count) {
  s.updates_by_status[status] = count;
  s.updates_by_status[0] = s.updates - count;
  return s;
}

void judge_ended(Summary& s) {
  RunOutcome outcome;
  outcome.tracking = pipeline::TrackingStatus::ok;
  judge(s, outcome);
}

/// A straight walk of 1 m/s over 100 s, with a bend so that an alignment is determined.
std::vector<StampedPose> walk() {
  std::vector<StampedPose> poses;
  for (int i = 0; i <= 1000; ++i) {
    StampedPose pose;
    pose.t = i * kSecond / 10;
    const double s = 0.1 * i;
    pose.T.p = s < 50 ? Vec3(s, 0, 0) : Vec3(50, s - 50, 0);
    poses.push_back(pose);
  }
  return poses;
}

std::optional<std::pair<TimeNs, std::string>> divergence_of(const std::vector<StampedPose>& estimate) {
  const Trajectory reference(walk());
  return experiment::find_divergence(estimate, reference);
}

}  // namespace

TEST_CASE("weak updates are told, and over a quarter of the time they degrade a run, however many they are") {
  Summary some = with(good_run(), kDegenerate, 80);
  some.weak_share = 0.25;
  judge_ended(some);
  CHECK(some.status == RunStatus::ok);
  CHECK(experiment::weak_updates(some) == "80 of 200 updates degenerate");
  CHECK_THAT(to_json(some), Contains("\"weak_updates\": \"80 of 200 updates degenerate\""));
  Summary many = with(good_run(), kDegenerate, 40);
  many.weak_share = 0.31;
  judge_ended(many);
  CHECK(many.status == RunStatus::degraded);
  CHECK(many.reason == "40 of 200 updates degenerate: 31 % of the time, more than 25 %");
}

TEST_CASE("refused updates are told with their number and status") {
  Summary s = with(good_run(), kFewMatches, 7);
  s.refused_by_status[kFewMatches] = 7;
  s.accepted = 193;
  s.refused_s = 0.056;  // of windows of 8 ms: as long as half a sweep
  judge_ended(s);
  CHECK(s.status == RunStatus::ok);
  CHECK_THAT(to_json(s), Contains("\"updates_refused\": 7"));
  Summary broke = s;
  broke.refused_by_status[static_cast<std::size_t>(UpdateStatus::non_finite)] = 1;
  judge_ended(broke);
  CHECK(broke.status == RunStatus::degraded);
  s.refused_s = 0.1;
  judge_ended(s);
  CHECK(s.status == RunStatus::degraded);
  CHECK(s.reason == "7 of 200 updates were refused (7 few_matches)");
  CHECK_THAT(to_json(s), Contains("\"updates_refused\": 7"));
}

TEST_CASE("malformed messages degrade a run when they are more than one in a thousand of their sensor") {
  Summary s = good_run();
  s.counters.packets = 175;
  s.counters.imu = 3500;
  s.malformed_imu = 3;
  judge_ended(s);
  CHECK(s.status == RunStatus::ok);
  s.malformed_imu = 4;
  judge_ended(s);
  CHECK(s.status == RunStatus::degraded);
  CHECK(s.reason == "4 malformed IMU messages dropped");
  CHECK_THAT(to_json(s), Contains("\"malformed_messages\": 4"));
  s.malformed_imu = 0;
  s.malformed_lidar = 1;
  judge_ended(s);
  CHECK(s.status == RunStatus::degraded);
  CHECK(s.reason == "1 malformed LiDAR messages dropped");
  s.malformed_lidar = 0;
  s.malformed_imu = 1;
  s.counters.imu = 0;  // of an estimator that takes none
  judge_ended(s);
  CHECK(s.status == RunStatus::ok);
}

TEST_CASE("an IMU that is clipped, stuck or dead for more than a moment degrades a run") {
  const std::pair<std::uint64_t stream::ImuFindings::*, const char*> faults[] = {
      {&stream::ImuFindings::gyro_clipped, "gyroscope at the end of its range"},
      {&stream::ImuFindings::acc_clipped, "accelerometer at the end of its range"},
      {&stream::ImuFindings::stuck, "stuck"},
      {&stream::ImuFindings::zero, "dead"}};
  for (const auto& [counter, word] : faults) {
    Summary s = good_run();
    s.imu_period_s = 0.005;
    s.counters.imu_found.*counter = 20;
    judge_ended(s);
    CHECK(s.status == RunStatus::ok);
    s.counters.imu_found.*counter = 21;
    judge_ended(s);
    CHECK(s.status == RunStatus::degraded);
    CHECK_THAT(s.reason, Contains(word) && Contains("(21 samples)"));
  }
  Summary s = good_run();
  s.counters.imu_found.spikes = 1;
  judge_ended(s);
  CHECK(s.status == RunStatus::ok);
  s.counters.imu_found.spikes = 2;
  judge_ended(s);
  CHECK_THAT(s.reason, Contains("2 IMU samples that are spikes dropped"));
}

TEST_CASE("a run whose first velocity is doubted is degraded") {
  Summary s = good_run();
  s.start_doubt = "the first velocity is not known: the first sweeps do not bind it";
  judge_ended(s);
  CHECK(s.status == RunStatus::degraded);
  CHECK(s.reason == s.start_doubt);
}

TEST_CASE("an error above 1 m and 1 % of the path degrades a run, whatever it says itself") {
  const auto status_of = [](double ate, double path) {
    Summary s = good_run();
    s.evaluation.emplace();
    s.evaluation->ate.translation.rmse = ate;
    s.evaluation->reference_path = path;
    judge_ended(s);
    return std::pair(s.status, s.reason);
  };
  CHECK(status_of(0.9, 10).first == RunStatus::ok);
  CHECK(status_of(1.5, 200).first == RunStatus::ok);
  CHECK(status_of(1.5, 100).first == RunStatus::degraded);
  CHECK(status_of(1.5, 100).second == "off the reference by 1.50 m (ATE) over 100 m of path: more than 1 m and 1 %");
}

TEST_CASE("points of lines that the sensor file does not know degrade a run when they are more than one in twenty") {
  Summary s = good_run();
  s.counters.points_beyond_lines = 50;
  judge_ended(s);
  CHECK(s.status == RunStatus::ok);
  s.counters.points_beyond_lines = 60;
  judge_ended(s);
  CHECK(s.status == RunStatus::degraded);
  CHECK_THAT(s.reason, Contains("60 points of a scan line beyond `scan_lines`"));
}

TEST_CASE("a run without an accepted update has failed, and says why") {
  Summary none = with(good_run(), kInitialising, 200);
  none.accepted = 0;
  none.matchable_points = 0;
  judge_ended(none);
  CHECK(none.status == RunStatus::failed);
  CHECK_THAT(none.reason, Contains("none of 200 updates was accepted") && Contains("no point passed the samplers"));
  Summary few = with(good_run(), kFewMatches, 199);
  few.updates_by_status[0] = 0;
  few.updates_by_status[kInitialising] = 1;
  few.accepted = 0;
  judge_ended(few);
  CHECK(few.status == RunStatus::failed);
  CHECK_THAT(few.reason, Contains("1 initialising, 199 few_matches"));
}

TEST_CASE("a position far from the reference is a divergence, a small drift is none") {
  CHECK_FALSE(divergence_of(walk()).has_value());
  std::vector<StampedPose> drifting = walk();
  for (StampedPose& pose : drifting) pose.T.p *= 1.03;  // 3 % of the path, in the end 3 m
  CHECK_FALSE(divergence_of(drifting).has_value());
  std::vector<StampedPose> lost = walk();
  for (std::size_t i = 800; i < lost.size(); ++i) lost[i].T.p.z() += 0.1 * static_cast<double>(i - 800);
  const auto divergence = divergence_of(lost);
  REQUIRE(divergence.has_value());
  CHECK(to_seconds(divergence->first) > 80.0);
  CHECK(to_seconds(divergence->first) < 95.0);
  CHECK_THAT(divergence->second, Contains("m from the reference after") && Contains("more than 2 m and 5 %"));
}

TEST_CASE("the share of the way after which a run has failed") {
  const Trajectory reference(walk());
  const auto failed_after = [&](const std::vector<StampedPose>& poses, std::optional<TimeNs> other = {}) {
    return experiment::failed_after(poses, reference, other);
  };
  CHECK_FALSE(failed_after(walk()).has_value());
  // Another origin and heading: laid on the truth by its first second.
  std::vector<StampedPose> turned = walk();
  const Mat3 R = Eigen::AngleAxisd(1.0, Vec3::UnitZ()).toRotationMatrix();
  for (StampedPose& pose : turned) pose.T = Pose{R * pose.T.R, R * pose.T.p + Vec3(3, 4, 5)};
  CHECK_FALSE(failed_after(turned).has_value());
  const auto off = [&](std::size_t from, std::size_t to, double metres) {
    std::vector<StampedPose> poses = turned;
    for (std::size_t i = from; i < to; ++i) poses[i].T.p.z() += metres;
    return failed_after(poses);
  };
  // 2 m early, 5 % of the way later; what has come back has failed, too.
  CHECK_FALSE(off(60, 70, 1.9).has_value());
  CHECK(off(60, 70, 2.1).value() == Approx(0.06));
  CHECK_FALSE(off(600, 601, 2.9).has_value());
  CHECK(off(600, 601, 3.1).value() == Approx(0.6));
  // Another failure, whichever is first; and nothing that could be laid on the truth.
  CHECK(failed_after(turned, 50 * kSecond).value() == Approx(0.5));
  std::vector<StampedPose> late = turned;
  late.back().T.p.z() += 9;
  CHECK(failed_after(late, 50 * kSecond).value() == Approx(0.5));
  CHECK(failed_after(late).value() == Approx(1.0));
  CHECK(failed_after({}).value() == 0);
}

TEST_CASE("a watch ends a run when nothing can change any more, and never one that goes on") {
  const Trajectory reference(walk());
  std::size_t ended = 0, came_back = 0;
  for (std::uint32_t k = 0; k < 500; ++k) {
    CAPTURE(k);
    std::mt19937 engine(k);
    const auto draw = [&](std::size_t n) { return static_cast<std::size_t>(engine()) % n; };
    // Drifts off at some time, by up to 1 m per step; every other time it is back at once after a while.
    std::vector<StampedPose> poses = walk();
    const std::size_t from = draw(poses.size()), to = k % 2 == 0 ? poses.size() : from + draw(100);
    const double speed = 0.001 * static_cast<double>(draw(1000));
    const Mat3 R = Eigen::AngleAxisd(0.01 * k, Vec3::UnitZ()).toRotationMatrix();
    for (std::size_t i = 0; i < poses.size(); ++i) {
      if (i >= from && i < to) poses[i].T.p.y() += speed * static_cast<double>(i - from);
      poses[i].T = Pose{R * poses[i].T.R, R * poses[i].T.p + Vec3(3, 4, 5)};
    }
    const auto whole = divergence_of(poses);
    const auto share = experiment::failed_after(poses, reference, {});
    experiment::DivergenceWatch watch(reference);
    std::optional<std::pair<TimeNs, std::string>> told;
    std::size_t seen = 0;
    while (!told && seen < poses.size()) told = watch.look({poses.data(), ++seen});
    came_back += share && !whole ? 1U : 0U;
    if (!told) {
      // Both have come within the last second, or not at all.
      if (whole && share) CHECK(seen == poses.size());
      if (whole && share) CHECK(std::max(to_seconds(whole->first), 100.0 * *share) > 97.0);
      continue;
    }
    ++ended;
    REQUIRE(whole.has_value());
    CHECK(*told == *whole);
    const std::vector<StampedPose> cut(poses.begin(), poses.begin() + static_cast<std::ptrdiff_t>(seen));
    CHECK(experiment::failed_after(cut, reference, {}) == share);
    CHECK(divergence_of(cut) == whole);
    CHECK(to_seconds(cut.back().t) < std::max(to_seconds(whole->first), 100.0 * share.value() + 1) + 1.2);
    // The method falls silent at some time, which is known a second later.
    const TimeNs silent = to_ns(100.0 * *share) + to_ns(0.1) * (static_cast<TimeNs>(draw(40)) - 20);
    const bool known = cut.back().t - silent > experiment::kMaxSilence;
    CHECK(experiment::failed_after(cut, reference, known ? std::optional(silent) : std::nullopt) ==
          experiment::failed_after(poses, reference, silent));
  }
  CHECK(ended > 100);
  CHECK(came_back > 5);
}

TEST_CASE("rpe is over the shortest distance of the recording, or over none") {
  aslio::evaluation::Evaluation evaluation;
  using aslio::evaluation::DeltaUnit;
  evaluation.rpe = {{.delta = 5, .unit = DeltaUnit::metres, .pairs = 3, .translation_rmse = 0.2},
                    {.delta = 1, .unit = DeltaUnit::metres, .pairs = 7, .translation_rmse = 0.1},
                    {.delta = 0.5, .unit = DeltaUnit::seconds, .pairs = 9, .translation_rmse = 0.3}};
  const auto found = aslio::experiment::headline_rpe(evaluation);
  REQUIRE(found);
  CHECK(found->distance_m == 1);
  CHECK(found->rmse_m == 0.1);
  // Poses too far apart for it: that over 5 m would be compared with that of others over 1 m.
  evaluation.rpe[1].pairs = 0;
  CHECK_FALSE(aslio::experiment::headline_rpe(evaluation));
}
