#pragma once
/// Messages that tell poses of something.

#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "../decode/decode.hpp"
#include "aslio/core/types.hpp"

namespace aslio::io::decode {

enum class PoseKind : std::uint8_t { pose, transform, point, fix, transforms };

/// By the name of a type, `geometry_msgs/PoseStamped` as `geometry_msgs/msg/PoseStamped`; nothing for others.
std::optional<PoseKind> pose_kind(std::string_view type);

/// One pose of a message.
struct ToldPose {
  TimeNs t = 0;                         ///< of the header
  std::string_view parent, child;       ///< frames; as long as the message lives
  Vec3 p = Vec3::Zero();                ///< [m]; of a fix: latitude [deg], longitude [deg], height [m]
  std::array<double, 4> q{0, 0, 0, 0};  ///< x y z w as sent; zeros where there is none
  bool valid = true;                    ///< false: a fix without satellites
};

/// Gives each pose to `take`. Returns an empty text, or what is wrong with the message.
std::string decode_poses(const Message& message, PoseKind kind, const std::function<void(const ToldPose&)>& take);

}  // namespace aslio::io::decode
