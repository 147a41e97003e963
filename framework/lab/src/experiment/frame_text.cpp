#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>

#include "aslio/core/angles.hpp"
#include "aslio/experiment/frame_check.hpp"

namespace aslio::experiment {

namespace {

using Json = nlohmann::ordered_json;

const char* mark(FindingKind kind) {
  switch (kind) {
    case FindingKind::agrees:
      return "ok";
    case FindingKind::contradicts:
      return "WRONG";
    case FindingKind::undetermined:
      return "open";
    case FindingKind::note:
      break;
  }
  return "note";
}

Json list_of(const Vec3& v) { return {v.x(), v.y(), v.z()}; }
Json rows_of(const Mat3& R) {
  Json out = Json::array();
  for (int i = 0; i < 9; ++i) out.push_back(R(i / 3, i % 3));
  return out;
}
Json sigmas_of(const Mat3& covariance) { return list_of(covariance.diagonal().cwiseMax(0.0).cwiseSqrt()); }

Json json_of(const evaluation::RotationFit& fit) {
  if (!fit.problem.empty()) return {{"problem", fit.problem}, {"correlation", fit.correlation}};
  return {{"turns", fit.turns},
          {"rotation", rows_of(fit.R_A_B)},
          {"sigma_rotation_rad", sigmas_of(fit.covariance)},
          {"delay_s", fit.delay},
          {"sigma_delay_s", fit.sigma_delay},
          {"signs", list_of(fit.signs)},
          {"rate_rad_s", list_of(fit.rate)},
          {"bias_rad_s", list_of(fit.bias)},
          {"ratio", fit.ratio},
          {"correlation", fit.correlation},
          {"rms_rad", fit.rms}};
}

Json json_of(const evaluation::HandEye& fit) {
  if (!fit.problem.empty()) return {{"problem", fit.problem}};
  return {{"pairs", fit.pairs},
          {"translation", list_of(fit.T_B_A.p)},
          {"rotation", rows_of(fit.T_B_A.R)},
          {"sigma_rotation_rad", sigmas_of(fit.covariance.topLeftCorner<3, 3>())},
          {"sigma_translation_m", sigmas_of(fit.covariance.bottomRightCorner<3, 3>())},
          {"delay_s", fit.delay},
          {"sigma_delay_s", fit.sigma_delay},
          {"rms_of_the_files_m", fit.rms_expected},
          {"rms_m", fit.rms}};
}

Json json_of(const evaluation::PointFit& fit) {
  if (!fit.problem.empty()) return {{"problem", fit.problem}};
  return {{"pieces", fit.pieces}, {"point_m", list_of(fit.point)},    {"sigma_point_m", sigmas_of(fit.covariance)},
          {"delay_s", fit.delay}, {"sigma_delay_s", fit.sigma_delay}, {"rms_m", fit.rms}};
}

Json json_of(const evaluation::ForceFit& fit) {
  if (!fit.problem.empty()) return {{"problem", fit.problem}};
  return {{"pieces", fit.pieces},
          {"scale", list_of(fit.scale)},
          {"sigma_scale", list_of(fit.sigma_scale)},
          {"signs", list_of(fit.signs)},
          {"lever_m", list_of(fit.lever)},
          {"sigma_lever_m", sigmas_of(fit.covariance)},
          {"gravity_m_s2", fit.gravity},
          {"sigma_gravity_m_s2", fit.sigma_gravity},
          {"rms_m", fit.rms}};
}

std::string data_line(const LidarMotion& motion) {
  std::size_t poses = 0;
  for (const auto& stretch : motion.stretches) poses += stretch.poses.size();
  return fmt::format(
      "data         {:.1f} s read, {:.1f} s in motion; {} of {} windows registered, {} poses in {} stretch{}\n",
      motion.data_s, motion.moving_s, motion.accepted, motion.windows, poses, motion.stretches.size(),
      motion.stretches.size() == 1 ? "" : "es");
}

std::string extrinsic_lines(const MeasuredExtrinsic& extrinsic) {
  const Vec6 sigma = extrinsic.covariance.diagonal().cwiseSqrt();
  const Vec3& p = extrinsic.T_imu_lidar.p;
  std::string text =
      fmt::format("measured     T_imu_lidar translation [{:.4f}, {:.4f}, {:.4f}] +- [{:.3f}, {:.3f}, {:.3f}] m\n",
                  p.x(), p.y(), p.z(), sigma[3], sigma[4], sigma[5]);
  const Mat3& R = extrinsic.T_imu_lidar.R;
  return text + fmt::format(
                    "             rotation [{:.6f}, {:.6f}, {:.6f}, {:.6f}, {:.6f}, {:.6f}, {:.6f}, {:.6f}, {:.6f}]"
                    " +- [{:.2f}, {:.2f}, {:.2f}] deg\n",
                    R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1), R(2, 2),
                    kDegPerRad * sigma[0], kDegPerRad * sigma[1], kDegPerRad * sigma[2]);
}

std::string published_lines(const FrameCheck& check) {
  if (check.published_verdict.empty()) return {};
  std::string text;
  const auto out = std::back_inserter(text);
  if (!check.published.empty())
    fmt::format_to(out, "\n{:<40} {:>8} {:>7} {:>8} {:>7}\n", "published", "deg", "sigmas", "mm", "sigmas");
  for (const ExtrinsicComparison& c : check.published) {
    fmt::format_to(out, "{:<40} {:>8.2f} {:>7.1f} {:>8.1f} {:>7.1f}  {}\n", c.source, kDegPerRad * c.rotation,
                   c.rotation_sigmas, 1e3 * c.shift, c.shift_sigmas, c.fits ? "fits" : "does not fit");
  }
  fmt::format_to(out, "published    {}\n", check.published_verdict);
  return text;
}

}  // namespace

std::string render(const FrameCheck& check) {
  std::string text = data_line(check.measurement.motion);
  const auto out = std::back_inserter(text);
  for (const Finding& finding : check.findings) {
    fmt::format_to(out, "{:<6} {}: {}\n", mark(finding.kind), finding.subject, finding.text);
    if (finding.kind == FindingKind::contradicts && !finding.key.empty()) {
      fmt::format_to(out, "       set {}: {}\n", finding.key, finding.value);
    }
  }
  if (check.extrinsic) text += extrinsic_lines(*check.extrinsic);
  text += published_lines(check);
  return text + fmt::format("verdict      {}\n",
                            check.contradicts() ? "the data contradict the files" : "nothing contradicts the files");
}

std::string to_json(const FrameCheck& check) {
  const FrameMeasurement& m = check.measurement;
  Json out;
  out["contradicts"] = check.contradicts();
  out["data_s"] = m.motion.data_s;
  out["moving_s"] = m.motion.moving_s;
  out["findings"] = Json::array();
  for (const Finding& f : check.findings) {
    Json finding = {{"kind", mark(f.kind)}, {"subject", f.subject}, {"text", f.text}};
    if (!f.key.empty()) finding.update({{"key", f.key}, {"value", f.value}});
    out["findings"].push_back(std::move(finding));
  }
  if (check.extrinsic) {
    out["T_imu_lidar"] = {{"translation", list_of(check.extrinsic->T_imu_lidar.p)},
                          {"rotation", rows_of(check.extrinsic->T_imu_lidar.R)},
                          {"sigma_rotation_rad", sigmas_of(check.extrinsic->covariance.topLeftCorner<3, 3>())},
                          {"sigma_translation_m", sigmas_of(check.extrinsic->covariance.bottomRightCorner<3, 3>())}};
  }
  out["published"] = Json::array();
  for (const ExtrinsicComparison& c : check.published) {
    out["published"].push_back({{"source", c.source},
                                {"rotation_deg", kDegPerRad * c.rotation},
                                {"rotation_sigmas", c.rotation_sigmas},
                                {"shift_m", c.shift},
                                {"shift_sigmas", c.shift_sigmas},
                                {"fits", c.fits}});
  }
  out["published_verdict"] = check.published_verdict;
  out["specific_force"] = {{"rest_s", m.rest.seconds}, {"mean_m_s2", list_of(m.rest.mean)}};
  out["lidar_against_gyro"] = json_of(m.gyro_lidar);
  out["lidar_against_accelerometer"] = json_of(m.force_lidar);
  if (m.has_reference && !m.reference_has_rotation) out["reference_point_against_lidar"] = json_of(m.lidar_point);
  if (m.reference_has_rotation) {
    out["reference_against_gyro"] = json_of(m.gyro_reference);
    out["reference_against_accelerometer"] = json_of(m.force_reference);
    out["lidar_against_reference"] = json_of(m.lidar_reference);
  }
  return out.dump(2) + "\n";
}

}  // namespace aslio::experiment
