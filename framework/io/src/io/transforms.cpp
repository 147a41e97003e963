#include "aslio/io/transforms.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <deque>
#include <map>

#include "aslio/config/binder.hpp"
#include "aslio/core/errors.hpp"

namespace aslio::io {
namespace {

constexpr double kTolerance = 1e-3;  ///< of a rotation whose digits were cut by hand
constexpr double kFarthest = 1000;   ///< [m] between two frames of one carrier

Mat3 matrix_of(const std::vector<double>& rows) {
  Mat3 M;
  for (std::size_t i = 0; i < 9; ++i) M(static_cast<int>(i / 3), static_cast<int>(i % 3)) = rows[i];
  return M;
}

bool is_rotation(const std::vector<double>& rows) {
  if (rows.size() != 9) return false;
  const Mat3 R = matrix_of(rows);
  const double determinant = R.col(0).cross(R.col(1)).dot(R.col(2));
  return (R.transpose() * R - Mat3::Identity()).cwiseAbs().maxCoeff() < kTolerance && determinant > 0;
}

double norm_of(const std::vector<double>& values) {
  double squares = 0;
  for (const double v : values) squares += v * v;
  return std::sqrt(squares);
}

std::string frames_of(std::span<const NamedTransform> transforms) {
  std::vector<std::string> names;
  for (const NamedTransform& t : transforms) names.insert(names.end(), {t.parent, t.child});
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "));
}

}  // namespace

Pose TransformBlock::pose() const {
  Pose T;
  T.p = Vec3(translation[0], translation[1], translation[2]);
  if (!rotation.empty()) T.R = orthonormalised(matrix_of(rotation));
  if (!quaternion.empty()) {
    const Eigen::Quaterniond q(quaternion[3], quaternion[0], quaternion[1], quaternion[2]);
    T.R = q.normalized().toRotationMatrix();
  }
  return T;
}

bool TransformBlock::is_identity() const {
  return norm_of(translation) == 0 && rotation.empty() && (quaternion.empty() || norm_of(quaternion) == quaternion[3]);
}

void TransformBlock::describe(config::Binder& b, TransformBlock& block) {
  b.reals("translation", block.translation, 3, "m", {.min = -kFarthest, .max = kFarthest},
          "origin of the child in the parent");
  b.reals("rotation", block.rotation, 0, "1", {.min = -1.001, .max = 1.001},
          "from the child to the parent, row by row; empty: by the quaternion");
  b.reals("quaternion", block.quaternion, 0, "1", {.min = -1.001, .max = 1.001},
          "the same as x y z w; both empty: none");
  b.require(block.rotation.empty() || block.quaternion.empty(), "quaternion",
            "and rotation exclude each other: leave one out");
  b.require(block.rotation.empty() || is_rotation(block.rotation), "rotation",
            "must be 9 numbers of an orthonormal matrix with determinant 1, row by row");
  b.require(
      block.quaternion.empty() || (block.quaternion.size() == 4 && std::abs(norm_of(block.quaternion) - 1) < 1e-2),
      "quaternion", "must be 4 numbers x y z w of norm 1");
}

void NamedTransform::describe(config::Binder& b, NamedTransform& transform) {
  b.text("parent", transform.parent, "frame that points are mapped to, as in imu; required");
  b.text("child", transform.child, "frame that points are mapped from, as in base; required");
  TransformBlock::describe(b, transform.T);
  b.require(!transform.parent.empty(), "parent", "is required: name a frame");
  b.require(!transform.child.empty() && transform.child != transform.parent, "child",
            "is required: name a frame, another one than `parent`");
}

Pose find_transform(std::span<const NamedTransform> transforms, const std::string& from, const std::string& to) {
  std::map<std::string, Pose> reached{{from, Pose{}}};
  std::deque<std::string> next{from};
  while (!next.empty() && !reached.contains(to)) {
    const std::string here = next.front();
    next.pop_front();
    const auto reach = [&](const std::string& frame, const Pose& step) {
      if (reached.emplace(frame, reached.at(here) * step).second) next.push_back(frame);
    };
    for (const NamedTransform& t : transforms) {
      if (t.parent == here) reach(t.child, t.T.pose());
      if (t.child == here) reach(t.parent, t.T.pose().inverse());
    }
  }
  const auto found = reached.find(to);
  if (found != reached.end()) return found->second;
  throw ConfigError(
      fmt::format("no transform leads from frame '{}' to '{}'; there are: {}; add one to `transforms` (parent, child, "
                  "translation, quaternion)",
                  from, to, frames_of(transforms)));
}

}  // namespace aslio::io
