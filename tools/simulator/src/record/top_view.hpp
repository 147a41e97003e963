#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "aslio/core/trajectory.hpp"
#include "aslio/simulator/ground.hpp"
#include "aslio/simulator/mesh.hpp"

namespace aslio::simulator {

/// Counts of points in the plan, one layer for what stands on the ground and one for ground and ceiling.
class TopView {
 public:
  /// The plan within 100 m of the path in which the mesh has surfaces, at most 1600 pixels wide and high.
  TopView(const Trajectory& path, const Mesh& mesh, const Ground& ground);

  void add(std::span<const Eigen::Vector3f> points_W);

  /// SVG with the points as an embedded PNG, the path, its start and a scale bar.
  std::string svg(const Trajectory& path, const std::string& title) const;

 private:
  struct Crop {
    int left = 0, top = 0, width = 1, height = 1;  ///< [pixel], row 0 in the north
  };
  Crop used() const;
  std::vector<std::uint8_t> png(const Crop& crop) const;

  const Ground& ground_;
  Vec2 low_ = Vec2::Zero();   ///< south-west corner [m]
  double resolution_ = 0.05;  ///< [m/pixel]
  int width_ = 1, height_ = 1;
  std::vector<std::uint32_t> standing_, level_;
};

}  // namespace aslio::simulator
