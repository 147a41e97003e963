#pragma once
/// How a measured frame differs from that of the files, in numbers and in words.

#include <array>
#include <string>
#include <vector>

#include "aslio/experiment/frame_check.hpp"

namespace aslio::experiment {

inline constexpr double kBeyond = 14.2;  ///< chi^2 of three that noise exceeds in one of 370 cases
inline constexpr std::array<const char*, 3> kAxis{"x", "y", "z"};

/// A vector with its covariance against limits. eq. FRM-6
struct Difference {
  Vec3 off, sigma;
  double chi2 = 0;
  double size = 0, size_sigma = 0;  ///< of the part that the data bind
  std::string open;                 ///< axes that they do not bind: "x and y"
  bool known = false;               ///< anything is bound
  bool contradicts = false;
};

/// `bound`: standard deviation of what counts as known; `tolerated`: size of what is no contradiction.
Difference difference(const Vec3& off, const Mat3& covariance, double bound, double tolerated);

/// "x +0.01 +- 0.12, y .., z .. deg", times `unit`.
std::string by_axis(const Difference& d, double unit, int digits, const char* name);
/// "[1, 2, 3]"
std::string list_of(const Vec3& v, int digits);
/// "{translation: [..], rotation: [..]}", as in a sensor file.
std::string pose_of(const Pose& T);

/// Fills FrameCheck::published and its verdict.
void compare_published(const std::vector<PublishedExtrinsic>& published, FrameCheck& check);

}  // namespace aslio::experiment
