#include "frame_difference.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>

#include "aslio/core/angles.hpp"

namespace aslio::experiment {

namespace {

std::string rows_of(const Mat3& R) {
  std::string text;
  for (int i = 0; i < 9; ++i) text += fmt::format("{}{:.6f}", i == 0 ? "" : ", ", R(i / 3, i % 3));
  return "[" + text + "]";
}

ExtrinsicComparison compare(const PublishedExtrinsic& published, const MeasuredExtrinsic& measured) {
  ExtrinsicComparison c;
  c.source = published.source;
  const Vec3 turn = log_so3(published.T_imu_lidar.R * measured.T_imu_lidar.R.transpose());
  const Vec3 shift = published.T_imu_lidar.p - measured.T_imu_lidar.p;
  const Mat3 turn_covariance = measured.covariance.topLeftCorner<3, 3>();
  const Mat3 shift_covariance = measured.covariance.bottomRightCorner<3, 3>();
  c.rotation = turn.norm();
  c.shift = shift.norm();
  c.rotation_sigmas = std::sqrt(turn.dot(turn_covariance.ldlt().solve(turn)));
  c.shift_sigmas = std::sqrt(shift.dot(shift_covariance.ldlt().solve(shift)));
  const double limit = std::sqrt(kBeyond);
  c.fits = c.rotation_sigmas < limit && c.shift_sigmas < limit;
  return c;
}

std::string which_fits(const FrameCheck& check) {
  std::vector<std::string> fitting;
  for (const ExtrinsicComparison& c : check.published) {
    if (c.fits) fitting.push_back(c.source);
  }
  if (fitting.empty()) return "none of them fits";
  if (fitting.size() == 1)
    return check.published.size() == 1 ? fitting.front() + " fits" : fitting.front() + " alone fits";
  const Vec6 sigma = check.extrinsic->covariance.diagonal().cwiseSqrt();
  return fmt::format(
      "the data cannot tell these apart: {}. Their differences are within what is measured, to {:.2f} deg "
      "and {:.0f} mm in the worst direction",
      fmt::join(fitting, ", "), kDegPerRad * sigma.head<3>().maxCoeff(), 1e3 * sigma.tail<3>().maxCoeff());
}

}  // namespace

Difference difference(const Vec3& off, const Mat3& covariance, double bound, double tolerated) {
  Difference d;
  d.off = off;
  d.sigma = covariance.diagonal().cwiseSqrt();
  d.chi2 = off.dot(covariance.ldlt().solve(off));
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(covariance);
  Vec3 known = Vec3::Zero();
  for (int i = 0; i < 3; ++i) {
    if (std::sqrt(eigen.eigenvalues()[i]) > bound) continue;
    known += eigen.eigenvectors().col(i).dot(off) * eigen.eigenvectors().col(i);
    d.known = true;
  }
  d.size = known.norm();
  if (d.size > 0) d.size_sigma = std::sqrt(known.dot(covariance * known)) / d.size;
  for (int axis = 0; axis < 3; ++axis) {
    if (d.sigma[axis] > bound)
      d.open += std::string(d.open.empty() ? "" : " and ") + kAxis[static_cast<std::size_t>(axis)];
  }
  d.contradicts = d.known && d.chi2 > kBeyond && d.size > tolerated;
  return d;
}

std::string by_axis(const Difference& d, double unit, int digits, const char* name) {
  std::string text;
  for (int i = 0; i < 3; ++i) {
    text += fmt::format("{}{} {:+.{}f} +- {:.{}f}", i == 0 ? "" : ", ", kAxis[static_cast<std::size_t>(i)],
                        unit * d.off[i], digits, unit * d.sigma[i], digits);
  }
  return text + " " + name;
}

std::string list_of(const Vec3& v, int digits) {
  return fmt::format("[{:.{}f}, {:.{}f}, {:.{}f}]", v.x(), digits, v.y(), digits, v.z(), digits);
}

std::string pose_of(const Pose& T) {
  return fmt::format("{{translation: {}, rotation: {}}}", list_of(T.p, 4), rows_of(T.R));
}

void compare_published(const std::vector<PublishedExtrinsic>& published, FrameCheck& check) {
  if (published.empty()) return;
  if (!check.extrinsic) {
    check.published_verdict = "no published extrinsic can be judged: the LiDAR's motion does not tell of the gyro's";
    return;
  }
  for (const PublishedExtrinsic& p : published) check.published.push_back(compare(p, *check.extrinsic));
  check.published_verdict = which_fits(check);
}

}  // namespace aslio::experiment
