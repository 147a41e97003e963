#pragma once
/// Named transforms between frames, and the one that they compose.

#include <span>
#include <string>
#include <vector>

#include "aslio/core/lie.hpp"

namespace aslio::config {
class Binder;
}

namespace aslio::io {

/// A rigid transform as written: a translation and, in one of two ways, a rotation.
struct TransformBlock {
  std::vector<double> translation{0, 0, 0};  ///< [m]
  std::vector<double> rotation;              ///< row by row; empty: none given
  std::vector<double> quaternion;            ///< x y z w; empty: none given

  Pose pose() const;
  bool is_identity() const;
  static void describe(config::Binder& b, TransformBlock& block);
};

/// Pose of the frame `child` in the frame `parent`: p_parent = T p_child.
struct NamedTransform {
  std::string parent, child;
  TransformBlock T;
  static void describe(config::Binder& b, NamedTransform& transform);
};

/// T_from_to (p_from = T_from_to p_to), composed along the shortest way through `transforms`, each of which may be gone
/// through either way. Throws ConfigError that lists the frames there are, and what to add, where none leads there.
Pose find_transform(std::span<const NamedTransform> transforms, const std::string& from, const std::string& to);

}  // namespace aslio::io
