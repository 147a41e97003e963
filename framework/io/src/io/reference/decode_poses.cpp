#include "decode_poses.hpp"

#include <fmt/format.h>

#include <utility>

#include "../decode/wire.hpp"

namespace aslio::io::decode {
namespace {

/// A message holds so many transforms at most: each has 60 bytes at least, and the count is checked against them.
constexpr std::size_t kLeastTransformBytes = 60;

Vec3 vector(Wire& wire) {
  Vec3 v;
  for (int i = 0; i < 3; ++i) v[i] = wire.get<double>();
  return v;
}

void orientation(Wire& wire, ToldPose& pose) {
  for (double& value : pose.q) value = wire.get<double>();
}

ToldPose transform(Wire& wire) {
  ToldPose pose;
  pose.t = wire.header();
  pose.parent = wire.frame();
  pose.child = wire.text();
  pose.p = vector(wire);
  orientation(wire, pose);
  return pose;
}

std::string transforms(Wire& wire, const std::function<void(const ToldPose&)>& take) {
  const auto count = wire.get<std::uint32_t>();
  if (count > wire.left() / kLeastTransformBytes) return fmt::format("{} transforms do not fit into it", count);
  for (std::uint32_t i = 0; i < count; ++i) {
    const ToldPose pose = transform(wire);
    if (!wire.ok()) return wire.problem("its transforms");
    take(pose);
  }
  return {};
}

}  // namespace

std::optional<PoseKind> pose_kind(std::string_view type) {
  std::string name(type);
  if (const std::size_t part = name.find("/msg/"); part != std::string::npos) name.erase(part, 4);
  constexpr std::array<std::pair<std::string_view, PoseKind>, 8> kKinds = {
      {{"nav_msgs/Odometry", PoseKind::transform},
       {"geometry_msgs/PoseStamped", PoseKind::pose},
       {"geometry_msgs/PoseWithCovarianceStamped", PoseKind::pose},
       {"geometry_msgs/TransformStamped", PoseKind::transform},
       {"geometry_msgs/PointStamped", PoseKind::point},
       {"sensor_msgs/NavSatFix", PoseKind::fix},
       {"tf2_msgs/TFMessage", PoseKind::transforms},
       {"tf/tfMessage", PoseKind::transforms}}};
  for (const auto& [known, kind] : kKinds) {
    if (name == known) return kind;
  }
  return std::nullopt;
}

std::string decode_poses(const Message& message, PoseKind kind, const std::function<void(const ToldPose&)>& take) {
  Wire wire(message);
  if (kind == PoseKind::transforms) {
    const std::string wrong = transforms(wire, take);
    return wire.ok() || !wrong.empty() ? wrong : wire.problem("a TFMessage");
  }
  ToldPose pose;
  if (kind == PoseKind::transform) {  // an Odometry begins as a TransformStamped does
    pose = transform(wire);
  } else {
    pose.t = wire.header();
    pose.parent = wire.frame();
    if (kind == PoseKind::fix) {
      pose.valid = wire.get<std::int8_t>() >= 0;
      wire.get<std::uint16_t>();  // constellations
    }
    pose.p = vector(wire);
    if (kind == PoseKind::pose) orientation(wire, pose);
  }
  if (!wire.ok()) return wire.problem("a pose");
  take(pose);
  return {};
}

}  // namespace aslio::io::decode
