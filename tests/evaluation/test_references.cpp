// References that are sparse, late, far from their origin, or without orientation.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "aslio/core/errors.hpp"
#include "aslio/evaluation/report.hpp"
#include "evaluation/paths.hpp"

namespace {

using namespace aslio;
using namespace aslio::evaluation;
using test::kMs;
using test::moved;
using test::sampled;

bool tells(const Evaluation& e, const std::string& part) {
  return std::any_of(e.warnings.begin(), e.warnings.end(),
                     [&](const std::string& warning) { return warning.find(part) != std::string::npos; });
}

/// Positions alone: every orientation is lost.
Trajectory positions_of(const Trajectory& trajectory) {
  Trajectory out;
  for (const StampedPose& pose : trajectory.samples()) out.append({pose.t, {Mat3::Identity(), pose.T.p}});
  return out;
}

Options positions_only() {
  Options options;
  options.positions_only = true;
  return options;
}

Trajectory later(const Trajectory& trajectory, TimeNs by) {
  Trajectory out;
  for (const StampedPose& pose : trajectory.samples()) out.append({pose.t + by, pose.T});
  return out;
}

/// The path with a speed that changes: a minute in which it is gone along at another pace.
Trajectory uneven(TimeNs begin, TimeNs end, TimeNs period) {
  Trajectory out;
  for (TimeNs t = begin; t <= end; t += period) {
    const double s = to_seconds(t);
    out.append(
        {t, {exp_so3(Vec3(0, 0, 0.1 * s)), Vec3(s + 3 * std::sin(0.3 * s), 4 * std::sin(0.11 * s * s / 10), 0)}});
  }
  return out;
}

}  // namespace

TEST_CASE("a neighbour that is too far leaves a stamp out") {  // eq. EVAL-1
  Trajectory reference;
  for (const TimeNs t : {0, 180, 200})
    reference.append({t * kMs, {Mat3::Identity(), Vec3(1e-3 * static_cast<double>(t), 0, 0)}});
  Trajectory estimate;
  for (const TimeNs t : {0, 50, 90, 120, 190}) estimate.append({t * kMs, {}});
  const auto matched = [&](TimeNs most) {
    return associate_interpolated(estimate, reference, 200 * kMs, kSecond, most).matched();
  };
  CHECK(matched(kTimeMax) == 5);
  CHECK(matched(100 * kMs) == 3);  // 90 is 90 from both; 50 and 120 have a neighbour at 130 and 120
  CHECK(matched(10 * kMs) == 2);
}

TEST_CASE("a sparse reference is measured at its own stamps") {  // eq. EVAL-12
  const Trajectory reference = sampled(0, 12 * kSecond, kSecond);
  const Trajectory estimate = moved(sampled(0, 12 * kSecond, 20 * kMs), {exp_so3(Vec3(0, 0, 1)), Vec3(5, 6, 7)});
  Options options;
  options.max_reference_gap = 2.5;
  const Evaluation interpolated = evaluate(estimate, reference, options);
  CHECK(interpolated.ate.translation.rmse > 0.05);
  CHECK(tells(interpolated, "the reference has 1 Hz: to interpolate it may cost 0.0"));
  CHECK(tells(interpolated, "`association: at_reference` measures at its stamps instead"));
  options.rule = Rule::at_reference;
  const Evaluation there = evaluate(estimate, reference, options);
  CHECK(there.matched == 13);
  CHECK(there.ate.translation.max < 1e-9);
  CHECK(there.warnings.empty());
  CHECK_FALSE(there.ate_grid.has_value());
  CHECK(to_json(there)["rule"] == "at_reference");
}

TEST_CASE("what interpolation costs is about what it does cost") {
  const Trajectory reference = sampled(0, 12 * kSecond, kSecond), estimate = sampled(0, 12 * kSecond, 20 * kMs);
  Options options;
  options.alignment = Alignment::none;
  options.max_reference_gap = 2.5;
  const Evaluation e = evaluate(estimate, reference, options);
  CHECK(tells(e, fmt::format("it may cost {:.3f} m", e.ate.translation.rmse)));
}

TEST_CASE("a reference at 10 Hz is interpolated without a word") {
  CHECK(evaluate(sampled(0, 12 * kSecond, 20 * kMs), sampled(0, 12 * kSecond, 100 * kMs)).warnings.empty());
}

TEST_CASE("gaps of the reference are left out and told") {
  Trajectory reference;
  const Trajectory whole = sampled(0, 20 * kSecond, 50 * kMs);
  for (const StampedPose& pose : whole.samples()) {
    if (pose.t <= 8 * kSecond || pose.t >= 11 * kSecond) reference.append(pose);
  }
  const Evaluation e = evaluate(sampled(0, 20 * kSecond, 100 * kMs), reference);
  CHECK(e.matched == 201 - 29);
  CHECK(tells(e,
              "the reference has 1 gaps of more than 0.1 s, 3.0 s in all, the longest of 3.0 s from 8.000 s on: the "
              "poses there are not measured"));
}

TEST_CASE("positions only give no figure of rotation") {
  const Pose body{Mat3::Identity(), Vec3(0.3, -0.1, 0.4)};
  const Trajectory estimate = moved(sampled(0, 12 * kSecond, 100 * kMs), {exp_so3(Vec3(0, 0, 2)), Vec3(5, 6, 7)});
  const Trajectory point = moved(estimate, {}, body);
  const Trajectory reference = positions_of(moved(sampled(0, 12 * kSecond, 5 * kMs), {}, body));
  const Evaluation e = evaluate(point, reference, positions_only());
  CHECK(e.ate.translation.max < 1e-6);
  CHECK(e.ate.rotation.n == 0);
  CHECK(e.rpe.empty());
  CHECK_FALSE(e.ate_turns.has_value());
  // Without the lever arm the point turns about the estimate.
  CHECK(evaluate(estimate, reference, positions_only()).ate.translation.rmse > 0.1);
  const auto json = to_json(e);
  for (const char* key : {"ate_deg", "ate_deg_rotation_aligned", "ate_deg_body_offset_removed", "end_to_end_error_m"}) {
    INFO(key);
    CHECK(json[key].is_null());
  }
  CHECK(json["ate"]["rotation_deg"].is_null());
  CHECK(json["positions_only"] == true);
  CHECK_THAT(to_text(e),
             Catch::Contains("the reference tells positions only: no rotation error") && !Catch::Contains("  deg\n"));
}

TEST_CASE("an origin far away changes no figure") {
  const Vec3 utm(744073.3226, 2553112.0182, 0.19);
  const Trajectory reference = sampled(0, 12 * kSecond, 5 * kMs), estimate = sampled(0, 12 * kSecond, 100 * kMs);
  Trajectory noisy;
  for (const StampedPose& pose : estimate.samples()) {
    noisy.append({pose.t, {pose.T.R, pose.T.p + 0.01 * Vec3(std::sin(7e-8 * static_cast<double>(pose.t)), 0, 0)}});
  }
  const Alignment alignment = GENERATE(Alignment::se3, Alignment::yaw, Alignment::none);
  Options options;
  options.alignment = alignment;
  const Evaluation here = evaluate(noisy, reference, options);
  options.reference_origin = utm;
  // The reference has had its origin taken off; an estimate in its world has not.
  const Evaluation there =
      evaluate(alignment == Alignment::none ? moved(noisy, {Mat3::Identity(), utm}) : noisy, reference, options);
  CHECK(there.ate.translation.rmse == Approx(here.ate.translation.rmse).epsilon(1e-6));
  CHECK(there.ate.rotation.rmse == Approx(here.ate.rotation.rmse).epsilon(1e-6));
  if (alignment != Alignment::none)
    CHECK((there.T_reference_estimate.p - here.T_reference_estimate.p - utm).norm() < 1e-6);
}

TEST_CASE("a constant delay is found and told, and nothing is shifted") {  // eq. EVAL-13
  const Trajectory truth = uneven(0, 60 * kSecond, 20 * kMs), estimate = uneven(0, 60 * kSecond, 100 * kMs);
  CHECK_FALSE(find_time_offset(estimate, truth, 100 * kMs).has_value());
  for (const double delay : {0.085, -0.3, 37.0 / 2, -12.0}) {
    INFO(delay);
    const Trajectory late = later(truth, to_ns(delay));
    const auto found = find_time_offset(estimate, late, 100 * kMs);
    REQUIRE(found.has_value());
    CHECK(found->seconds == Approx(-delay).margin(1e-3));
    CHECK(found->rmse_after < 0.01);
  }
  const Evaluation e = evaluate(estimate, later(truth, 85 * kMs));
  CHECK(e.ate.translation.rmse > 0.05);
  CHECK(tells(
      e, "the stamps of the reference look 0.085 s too late: -0.085 s added to them, the positions fit to 0.000 m"));
  CHECK(tells(e, "nothing was shifted. If the clocks differ, set `time_offset: -0.085`"));
  CHECK(to_json(e)["time_offset"]["seconds"].get<double>() == Approx(-0.085).margin(1e-3));
}

TEST_CASE("a factor of 1000 in the stamps is named with its remedy") {
  Trajectory reference;
  for (int i = 0; i < 100; ++i) reference.append({i * kSecond * 100, {}});
  Trajectory estimate;
  for (int i = 0; i < 100; ++i) estimate.append({(i + 1) * kSecond / 10 - 11 * kSecond, {}});
  CHECK_THROWS_WITH(
      evaluate(estimate, reference),
      Catch::Contains("the reference lasts 1e+03 times longer: are its stamps in ms (set its `time_unit`)?"));
}

TEST_CASE("the score of Hilti gives points by the error of each pose of the reference") {  // eq. EVAL-14
  // Ten points on a triangle, so that the alignment is determined; worlds are the same.
  Trajectory reference, estimate;
  const double errors[] = {0.0, 0.009, 0.02, 0.029, 0.05, 0.09, 0.2, 0.5, 0.004, 1.0};
  for (int i = 0; i < 10; ++i) {
    const Vec3 p(i % 3, i % 2, 0.1 * i);
    reference.append({i * 10 * kSecond, {Mat3::Identity(), p}});
    if (i != 9) estimate.append({i * 10 * kSecond + kSecond, {Mat3::Identity(), p + Vec3(errors[i], 0, 0)}});
  }
  Options options = positions_only();
  options.rule = Rule::evo;
  options.evo_max_difference = 2;
  options.alignment = Alignment::none;
  options.scoring = Scoring::hilti_2022;
  CHECK(*evaluate(estimate, reference, options).score == Approx(100 * (10 + 10 + 6 + 6 + 3 + 1 + 0 + 0 + 10) / 100.0));
  options.scoring = Scoring::hilti_2023;
  const Evaluation e = evaluate(estimate, reference, options);
  CHECK(*e.score == Approx(100 * (20 + 10 + 6 + 6 + 5 + 3 + 1 + 0 + 20) / 200.0));
  CHECK(to_json(e)["score"]["name"] == "hilti_2023");
  CHECK_THAT(to_text(e), Catch::Contains("score hilti_2023: 35.50 of 100"));
}
