#pragma once
/// Planes in voxels as docs/equations.md has them (MAP-1, MAP-4) and no more: no early way out, no pool, no batches.

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "aslio/stages/map.hpp"

namespace aslio::test {

class PlainVoxelPlanes {
 public:
  struct Params {
    double voxel = 0.5;
    int levels = 2;
    std::uint32_t min_points = 10, max_points = 60;
    double thickness = 0.023;
  };
  explicit PlainVoxelPlanes(const Params& params) : params_(params) {}

  /// Returns how many of them changed something.
  std::size_t insert(const std::vector<WorldPoint>& points) {
    std::size_t inserted = 0;
    std::vector<Node*> touched;
    for (const WorldPoint& point : points) {
      Voxel& voxel = voxels_[cell(point.p_W)];
      const Eigen::Vector3f p = inside(point.p_W), view = point.view.vector();
      inserted += add(part_for(voxel, p, view), p, view, touched) ? 1 : 0;
    }
    std::vector<Voxel*> changed;
    for (auto& [number, voxel] : voxels_) {
      if (voxel.first.touched) changed.push_back(&voxel);
    }
    for (Node* node : touched) fit(*node);
    for (Voxel* voxel : changed) {
      if (voxel->second) unite(*voxel);
    }
    return inserted;
  }

  struct Found {
    Vec3 mean, normal;
  };
  std::optional<Found> at(const Vec3& query, const Vec3& viewpoint) const {
    const auto found = voxels_.find(cell(query));
    if (found == voxels_.end()) return std::nullopt;
    const Eigen::Vector3f p = inside(query), view = (query - viewpoint).cast<float>().normalized();
    const Node* along = nullptr;
    for (const Node* part : std::array<const Node*, 2>{&found->second.first, found->second.second.get()}) {
      const Node* node = part == nullptr ? nullptr : plane_at(*part, p);
      if (node == nullptr) continue;
      const float away = node->sided ? view.dot(node->normal) : 0;
      if (away <= 0) return tell(found->first, *node);
      if (away <= 0.1F && along == nullptr) along = node;
    }
    if (along == nullptr) return std::nullopt;
    return tell(found->first, *along);
  }

 private:
  using Number = std::array<long, 3>;
  struct Node {
    std::uint32_t count = 0, next_fit = 0;
    bool planar = false, sided = false, touched = false;
    std::array<int, 3> views{};
    Eigen::Vector3f sum = Eigen::Vector3f::Zero(), mean = Eigen::Vector3f::Zero(), normal = Eigen::Vector3f::Zero();
    std::array<float, 6> squares{};
    std::vector<Node> parts;  ///< none or eight
    Eigen::Vector3f view() const {
      return Eigen::Vector3f(Eigen::Vector3i(views[0], views[1], views[2]).cast<float>());
    }
  };
  struct Voxel {
    Node first;
    std::unique_ptr<Node> second;
  };

  static inline const Vec3 kOffset{0.137, 0.223, 0.311};

  Number cell(const Vec3& p) const {
    const Vec3 number = ((p + params_.voxel * kOffset) / params_.voxel).array().floor();
    return {std::lround(number.x()), std::lround(number.y()), std::lround(number.z())};
  }
  Vec3 corner(const Number& number) const {
    return params_.voxel * (Eigen::Matrix<long, 3, 1>(number[0], number[1], number[2]).cast<double>() - kOffset);
  }
  Eigen::Vector3f inside(const Vec3& p) const { return (p - corner(cell(p))).cast<float>(); }
  Found tell(const Number& number, const Node& node) const {
    return {corner(number) + node.mean.cast<double>(), node.normal.cast<double>().normalized()};
  }
  bool closed(const Node& node) const { return node.count >= params_.max_points; }

  /// The part of eight in which p lies, on the `level`-th level from 1 on.
  std::size_t octant(const Eigen::Vector3f& p, int level) const {
    std::size_t out = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double parts = std::exp2(level);
      const auto number = static_cast<long>(std::floor(static_cast<double>(p[axis]) / params_.voxel * parts));
      out |= (number % 2 != 0 ? std::size_t{1} : std::size_t{0}) << axis;
    }
    return out;
  }

  const Node* plane_at(const Node& part, const Eigen::Vector3f& p) const {
    const Node* node = &part;
    for (int level = 1;; ++level) {
      if (node->planar) return node;
      if (node->parts.empty()) return nullptr;
      node = &node->parts[octant(p, level)];
    }
  }

  Node& part_for(Voxel& voxel, const Eigen::Vector3f& p, const Eigen::Vector3f& view) const {
    const Node* node = plane_at(voxel.first, p);
    bool first = view.dot(voxel.first.view()) >= 0;
    if (node != nullptr) {
      const float away = node->sided ? view.dot(node->normal) : 0;
      const double distance = std::abs((p - node->mean).dot(node->normal));
      first = away <= 0 || (away <= 0.1F && distance <= 2 * params_.thickness);
    }
    if (first) return voxel.first;
    if (!voxel.second) voxel.second = std::make_unique<Node>();
    return *voxel.second;
  }

  bool add(Node& node, const Eigen::Vector3f& p, const Eigen::Vector3f& view, std::vector<Node*>& touched,
           int level = 1) const {
    const bool open = !closed(node);
    if (open) {
      if (!node.touched) touched.push_back(&node);
      node.touched = true;
      if (++node.count <= 256) {
        for (int axis = 0; axis < 3; ++axis) {
          node.views[static_cast<std::size_t>(axis)] += static_cast<int>(127 * view[axis]);
        }
      }
      node.sum += p;
      std::size_t k = 0;
      for (int i = 0; i < 3; ++i)
        for (int j = i; j < 3; ++j) node.squares[k++] += p[i] * p[j];
    }
    if (node.planar || level == params_.levels) return open;
    if (node.parts.empty()) {
      if (node.next_fit == 0) return open;  // of few points, it is not yet known what the voxel is
      node.parts.resize(8);
    }
    const bool below = add(node.parts[octant(p, level)], p, view, touched, level + 1);
    return open || below;
  }

  void fit(Node& node) const {
    node.touched = false;
    if (node.count < params_.min_points || (node.count < node.next_fit && !closed(node))) return;
    node.next_fit = static_cast<std::uint32_t>(1.1 * node.count) + 1;
    const Vec3 mean = node.sum.cast<double>() / node.count;
    Eigen::SelfAdjointEigenSolver<Mat3> solver;
    solver.computeDirect(squares(node) / node.count - mean * mean.transpose());  // as there: what is at a limit
    const Vec3& l = solver.eigenvalues();
    node.planar = l[0] < params_.thickness * params_.thickness && l[1] > 0.05 * l[2] &&
                  l[1] > 9 * std::max(l[0], 1e-6 * params_.voxel * params_.voxel);
    node.mean = mean.cast<float>();
    node.normal = solver.eigenvectors().col(0).cast<float>();
    const float away = node.view().dot(node.normal);
    node.sided = away != 0;
    if (away > 0) node.normal = -node.normal;
  }

  static Mat3 squares(const Node& node) {
    Eigen::Matrix3f out;
    const auto& s = node.squares;
    out << s[0], s[1], s[2], s[1], s[3], s[4], s[2], s[4], s[5];
    return out.cast<double>();
  }

  void unite(Voxel& voxel) const {
    Node& node = voxel.first;
    const Node& rest = *voxel.second;
    if (!node.planar || !node.sided || rest.count == 0 || rest.view().dot(node.normal) > 0) return;
    const Vec3 normal = node.normal.cast<double>(), mean = rest.sum.cast<double>() / rest.count;
    const double off = normal.dot(mean - node.mean.cast<double>());
    const double across = normal.dot(squares(rest) * normal) / rest.count - std::pow(normal.dot(mean), 2);
    if (off * off + across > params_.thickness * params_.thickness) return;
    Node both = node;
    both.count += rest.count;
    both.sum += rest.sum;
    for (std::size_t i = 0; i < both.squares.size(); ++i) both.squares[i] += rest.squares[i];
    both.next_fit = 0;
    fit(both);
    if (!both.planar) return;
    node = std::move(both);
    voxel.second.reset();
  }

  Params params_;
  std::map<Number, Voxel> voxels_;
};

}  // namespace aslio::test
