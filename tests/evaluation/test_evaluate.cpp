#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>

#include "aslio/core/errors.hpp"
#include "aslio/evaluation/evaluation.hpp"
#include "evaluation/paths.hpp"
#include "evaluation/tum.hpp"

namespace {

using namespace aslio;
using namespace aslio::evaluation;
using test::kMs;
using test::moved;
using test::sampled;

constexpr double kDegree = 180.0 / std::numbers::pi;

const std::filesystem::path kFixture = std::filesystem::path(ASLIO_SOURCE_DIR) / "tests/evaluation/reference";

void check_equal(const Statistics& ours, const nlohmann::json& expected) {
  CHECK(ours.n == expected["n"].get<std::size_t>());
  for (const auto& [key, value] :
       {std::pair("rmse", ours.rmse), std::pair("mean", ours.mean), std::pair("median", ours.median),
        std::pair("std", ours.std), std::pair("min", ours.min), std::pair("max", ours.max)}) {
    INFO(key);
    CHECK(value == Approx(expected[key].get<double>()).epsilon(1e-9));
  }
}

}  // namespace

TEST_CASE("evo's rule gives the figures of an independent implementation") {
  const auto expected = nlohmann::json::parse(std::ifstream(kFixture / "expected.json"));
  const Trajectory estimate = test::read_tum(kFixture / "estimate.tum");
  const Trajectory reference = test::read_tum(kFixture / "reference.tum");
  Options options;
  options.rule = Rule::evo;
  const Evaluation forward = evaluate(estimate, reference, options);
  check_equal(forward.ate.translation, expected["forward"]["translation_m"]);
  check_equal(forward.ate.rotation, expected["forward"]["rotation_deg"]);
  for (int row = 0; row < 3; ++row) {
    const auto i = static_cast<std::size_t>(row);
    CHECK(forward.T_reference_estimate.p[row] ==
          Approx(expected["forward"]["alignment"]["translation"][i].get<double>()).epsilon(1e-9));
  }
  const Evaluation swapped = evaluate(reference, estimate, options);
  check_equal(swapped.ate.translation, expected["swapped"]["translation_m"]);
  check_equal(swapped.ate.rotation, expected["swapped"]["rotation_deg"]);
}

TEST_CASE("the same motion in another world has no error") {  // eq. EVAL-9
  const Trajectory reference = sampled(0, 12 * kSecond, 5 * kMs);
  const Trajectory estimate =
      moved(sampled(100 * kMs, 12 * kSecond, 100 * kMs), {exp_so3(Vec3(0.3, -0.2, 2)), Vec3(5, 6, 7)});
  const Evaluation e = evaluate(estimate, reference);
  CHECK(e.ate.translation.max < 1e-9);
  CHECK(e.ate.rotation.max < 1e-6);
  CHECK(e.ate_deg_rotation_aligned < 1e-6);
  CHECK(e.end_to_end.error < 1e-9);
  CHECK(e.matched_share == 1.0);
  CHECK(e.covered_share == Approx(11.9 / 12.0));
  for (const RelativeError& error : e.rpe) CHECK(error.translation_rmse < 1e-9);
  REQUIRE(e.rpe.size() == 4);  // 1, 5 and 10 m of a path of about 22 m, and 1 s
  CHECK(e.rpe[0].pairs > 90);
  CHECK(e.rpe[3].pairs == 110);
  CHECK(e.warnings.empty());
  // The tilt of that world shows when only yaw is aligned.
  REQUIRE(e.ate_yaw.has_value());
  CHECK(e.ate_yaw->rotation.rmse > 10.0);
}

TEST_CASE("a constant rotation of the body frame is told from errors of the motion") {  // eq. EVAL-6
  const Trajectory reference = sampled(0, 12 * kSecond, 5 * kMs);
  const Pose mounting{exp_so3(Vec3(0.02, 0.01, -0.02)), Vec3::Zero()};
  const Evaluation e = evaluate(moved(sampled(0, 12 * kSecond, 100 * kMs), {}, mounting), reference);
  CHECK(e.ate.translation.max < 1e-9);
  CHECK(e.ate.rotation.rmse == Approx(0.03 * kDegree).epsilon(1e-6));
  CHECK(e.ate_deg_body_offset_removed < 1e-6);
}

TEST_CASE("a rotation that the positions get wrong is told from errors of the motion") {
  // Positions bent so that the alignment turns by about 0.02 rad; orientations are exact.
  const Trajectory reference = sampled(0, 12 * kSecond, 5 * kMs);
  Trajectory estimate;
  const Trajectory exact = sampled(0, 12 * kSecond, 100 * kMs);
  for (const StampedPose& s : exact.samples()) {
    estimate.append({s.t, {s.T.R, exp_so3(Vec3(0, 0.02, 0)) * s.T.p}});
  }
  const Evaluation e = evaluate(estimate, reference);
  CHECK(e.ate.translation.max < 1e-9);
  CHECK(e.ate.rotation.rmse == Approx(0.02 * kDegree).epsilon(1e-6));
  CHECK(e.ate_deg_rotation_aligned < 1e-6);
}

TEST_CASE("more poses in a turn do not change errors weighted by time") {
  const Trajectory reference = sampled(0, 12 * kSecond, 5 * kMs);
  const auto with_error = [](TimeNs t) {  // 0.1 m up during [5.5 s, 6.5 s)
    Pose T = test::path(to_seconds(t));
    if (t >= 5500 * kMs && t < 6500 * kMs) T.p.z() += 0.1;
    return StampedPose{t, T};
  };
  Trajectory even, adaptive;
  for (TimeNs t = 0; t <= 12 * kSecond; t += 100 * kMs) even.append(with_error(t));
  for (TimeNs t = 0; t <= 12 * kSecond;) {
    adaptive.append(with_error(t));
    t += t >= 5500 * kMs && t < 6500 * kMs ? 20 * kMs : 100 * kMs;
  }
  Options options;
  options.alignment = Alignment::none;
  const double even_rmse = evaluate(even, reference, options).ate.translation.rmse;
  const Evaluation weighted = evaluate(adaptive, reference, options);
  CHECK(even_rmse == Approx(0.1 * std::sqrt(1.0 / 12.0)).epsilon(0.01));
  CHECK(weighted.ate.translation.rmse == Approx(even_rmse).epsilon(0.03));
  REQUIRE(weighted.ate_grid.has_value());
  CHECK(weighted.ate_grid->translation.n == 121);
  CHECK(weighted.ate_grid->translation.rmse == Approx(even_rmse).epsilon(0.03));
  options.rule = Rule::evo;
  CHECK(evaluate(adaptive, reference, options).ate.translation.rmse > 1.5 * even_rmse);  // why evo's rule misleads
  // And the error is where the turn is.
  REQUIRE(weighted.ate_turns.has_value());
  REQUIRE(weighted.ate_straight.has_value());
  CHECK(weighted.ate_turns->translation.rmse > 0.09);
  CHECK(weighted.ate_straight->translation.rmse < 0.03);
  CHECK(weighted.ate_turns->translation.n + weighted.ate_straight->translation.n == adaptive.size());
}

TEST_CASE("turn rate of a reference, also at its ends") {  // eq. EVAL-10
  Trajectory reference;
  for (int i = 0; i <= 100; ++i) reference.append({i * 10 * kMs, {exp_so3(Vec3(0, 0, 0.007 * i)), Vec3::Zero()}});
  for (const TimeNs t : {TimeNs{0}, TimeNs{3 * kMs}, TimeNs{500 * kMs}, TimeNs{kSecond}}) {
    CHECK(turn_rate(reference, t) == Approx(0.7).epsilon(1e-9));
  }
}

TEST_CASE("relative errors of a scale error are that scale times the distance") {  // eq. EVAL-11
  const auto line = [](double scale) {
    Trajectory trajectory;
    for (int i = 0; i <= 200; ++i) trajectory.append({i * 100 * kMs, {Mat3::Identity(), Vec3(0.1 * scale * i, 0, 0)}});
    return trajectory;
  };
  Options options;
  options.alignment = Alignment::yaw;
  options.distances = {1.0, 5.0, 100.0};
  options.durations = {2.0};
  const Evaluation e = evaluate(line(1.02), line(1.0), options);
  REQUIRE(e.rpe.size() == 4);
  CHECK(e.rpe[0].translation_rmse == Approx(0.02));
  CHECK(e.rpe[0].pairs == 191);
  CHECK(e.rpe[1].translation_rmse == Approx(0.10));
  CHECK(e.rpe[2].pairs == 0);  // longer than the path
  CHECK(e.rpe[3].translation_rmse == Approx(0.04));
  CHECK(e.rpe[3].unit == DeltaUnit::seconds);
  CHECK(e.end_to_end.distance == Approx(20.4));
  CHECK(e.end_to_end.error == Approx(0.4));
  options.alignment = Alignment::se3;
  CHECK_THROWS_AS(evaluate(line(1.02), line(1.0), options), DataError);
}

TEST_CASE("the distances of the relative errors are those of the reference, whatever the rate of the estimate") {
  const auto straight = [](double speed, TimeNs period) {  // with a stop of 4 s in the middle
    Trajectory out;
    for (TimeNs t = 0; t <= 24 * kSecond; t += period) {
      const double s = to_seconds(t), way = std::min(s, 10.0) + std::max(0.0, s - 14.0);
      out.append({t, {Mat3::Identity(), Vec3(speed * way, std::sin(0.1 * speed * way), 0)}});
    }
    return out;
  };
  const auto distances = [&](double speed, TimeNs period) {
    std::vector<double> found;
    for (const RelativeError& error : evaluate(straight(speed, period), straight(speed, 5 * kMs)).rpe) {
      if (error.unit == DeltaUnit::metres) found.push_back(error.delta);
    }
    return found;
  };
  for (const TimeNs period : {8 * kMs, 100 * kMs}) {
    CHECK(distances(1.3, period) == std::vector{1.0, 5.0, 10.0});
    CHECK(distances(3.0, period) == std::vector{1.0, 5.0, 10.0});
    CHECK(distances(15.0, period) == std::vector{5.0, 10.0, 50.0, 100.0});
  }
}

TEST_CASE("a stop on the way takes no pair away from the relative errors over a distance") {  // eq. EVAL-11
  // 10 m, a second or more of standing still, 10 m: from every pose up to 5 m before the end.
  for (const int stop : {0, 10, 100}) {
    CAPTURE(stop);
    const auto walk = [stop](double scale) {
      Trajectory trajectory;
      for (int i = 0; i <= 200 + stop; ++i) {
        const int moved = i <= 100 ? i : std::max(100, i - stop);
        trajectory.append({i * 100 * kMs, {Mat3::Identity(), Vec3(0.1 * scale * moved, 0, 0)}});
      }
      return trajectory;
    };
    Options options;
    options.alignment = Alignment::yaw;
    options.distances = {5.0};
    const Evaluation e = evaluate(walk(1.02), walk(1.0), options);
    REQUIRE(e.rpe.size() >= 1);
    CHECK(e.rpe[0].pairs == static_cast<std::size_t>(151 + stop));
    CHECK(e.rpe[0].translation_rmse == Approx(0.10));
  }
}

TEST_CASE("an estimate that ends early says so") {
  const Evaluation e = evaluate(sampled(0, 6 * kSecond, 100 * kMs), sampled(0, 12 * kSecond, 5 * kMs));
  CHECK(e.matched_share == 1.0);
  CHECK(e.covered_share == Approx(0.5));
  REQUIRE(e.warnings.size() == 1);
  CHECK(e.warnings[0] ==
        "the estimate covers 50 % of the reference's duration: its errors are not comparable with "
        "those of a complete run");
}

TEST_CASE("an alignment that the errors may turn is warned of") {
  // A walk of 10 m along x that sways by `sway`, measured with an error of 0.1 m up and down.
  const auto warnings = [](double sway, Alignment alignment) {
    Trajectory reference, estimate;
    for (int i = 0; i <= 200; ++i) {
      const Vec3 p(0.05 * i, i % 4 < 2 ? sway : -sway, 0.0);
      reference.append({i * 50 * kMs, {Mat3::Identity(), p}});
      estimate.append({i * 50 * kMs, {Mat3::Identity(), p + Vec3(0, 0, i % 2 == 0 ? 0.1 : -0.1)}});
    }
    Options options;
    options.alignment = alignment;
    options.rule = Rule::evo;
    return evaluate(estimate, reference, options).warnings;
  };
  REQUIRE(warnings(0.4, Alignment::se3).size() == 1);
  CHECK(warnings(0.4, Alignment::se3)[0] ==
        "the alignment is poorly determined: the positions spread by 0.400 m across their main direction, less than 5 "
        "times their error of 0.100 m. So it hides part of the error, and its rotation is not reliable. Use a longer "
        "trajectory, or the relative errors, which need no alignment");
  CHECK(warnings(0.6, Alignment::se3).empty());
  CHECK(warnings(0.4, Alignment::yaw).empty());
  CHECK(warnings(0.4, Alignment::none).empty());
}

TEST_CASE("options out of range are refused by name") {
  const Trajectory reference = sampled(0, 12 * kSecond, 5 * kMs);
  Options options;
  options.grid_period = 0.0;
  CHECK_THROWS_WITH(evaluate(reference, reference, options), "grid_period is 0, must be positive");
  options = {};
  options.distances = {1.0, -5.0};
  CHECK_THROWS_AS(evaluate(reference, reference, options), ConfigError);
}
