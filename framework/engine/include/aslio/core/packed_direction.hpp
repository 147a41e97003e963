#pragma once
/// A direction in two bytes, for points that come by the hundred thousand.

#include <Eigen/Core>
#include <cmath>
#include <cstdint>

namespace aslio {

/// A direction to within 1 deg, or none: the octahedral map (Cigolle et al. 2014, A Survey of Efficient Representations
/// for Independent Unit Vectors) on a grid of 255 x 255.
class PackedDirection {
 public:
  PackedDirection() = default;  ///< none
  /// That of `v`, of any length; none for zero or what is not finite.
  explicit PackedDirection(const Eigen::Vector3f& v) {
    const float sum = v.cwiseAbs().sum();
    if (!(sum > 0) || !std::isfinite(sum)) return;
    float a = v.x() / sum, b = v.y() / sum;
    if (v.z() < 0) fold(a, b, 1);
    // nearbyint is an instruction where lround is a call.
    a_ = static_cast<std::int8_t>(std::nearbyint(kSteps * a));
    b_ = static_cast<std::int8_t>(std::nearbyint(kSteps * b));
  }
  bool none() const { return a_ == kNone; }
  /// Unit vector; zero for none.
  Eigen::Vector3f vector() const { return toward().normalized(); }
  /// The same, of some length from 73 to 127: for whoever asks for a sign alone, often.
  Eigen::Vector3f toward() const {
    if (none()) return Eigen::Vector3f::Zero();
    auto a = static_cast<float>(a_), b = static_cast<float>(b_);
    const float z = kSteps - std::abs(a) - std::abs(b);
    if (z < 0) fold(a, b, kSteps);
    return Eigen::Vector3f(a, b, z);
  }

 private:
  static constexpr float kSteps = 127;
  static constexpr std::int8_t kNone = -128;

  /// Between the inner square, of the upper half space, and the corners of the square about it, of
  /// the lower one. `edge`: half of that of the square, in units of a and b.
  static void fold(float& a, float& b, float edge) {
    const float x = a;
    a = std::copysign(edge - std::abs(b), a);
    b = std::copysign(edge - std::abs(x), b);
  }

  std::int8_t a_ = kNone, b_ = 0;
};

}  // namespace aslio
