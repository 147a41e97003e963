#pragma once
/// Cells of points, a batch at a time.

#include <array>

#include "aslio/core/cell_index.hpp"

namespace aslio {

/// Where each point of a batch lies in a grid, as cell_of() tells it of one: axis by axis, so that a processor with
/// vectors takes several at once, which a point by itself, with its three coordinates, does not let it. Point by point,
/// voxel_plane took 1.08 times the time to take points (simulated corridor, in turn, AVX2).
class CellBatch {
 public:
  static constexpr std::size_t kSize = 32;
  /// Key of a point that has no cell: not finite, or beyond kCellLimit.
  static constexpr std::uint64_t kNoCell = ~std::uint64_t{0};

  /// Finds those of `count` <= kSize points, the i-th of which is `point(i)` [m], in cells of `edge` [m]; cell 0 begins
  /// at -edge * offset.
  template <class PointOf>
  void find(std::size_t count, const PointOf& point, double edge, const Vec3& offset) {
    for (std::size_t i = 0; i < count; ++i) {
      const Vec3& p = point(i);
      for (int axis = 0; axis < 3; ++axis) in_[static_cast<std::size_t>(axis)][i] = p[axis];
    }
    within_.fill(1);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      place(edge, offset[static_cast<int>(axis)], axis);
    }
    for (std::size_t i = 0; i < kSize; ++i) key_[i] = pack(cell(i));
    for (std::size_t i = 0; i < kSize; ++i) key_[i] = within_[i] > 0 ? key_[i] : kNoCell;
  }

  std::uint64_t key(std::size_t i) const { return key_[i]; }
  /// Of a point that has one.
  VoxelCell cell(std::size_t i) const { return {cell_[0][i], cell_[1][i], cell_[2][i]}; }
  /// From the corner of its cell [m].
  Eigen::Vector3f inside(std::size_t i) const { return {inside_[0][i], inside_[1][i], inside_[2][i]}; }

 private:
  /// One axis. Loops that each do one thing to one kind of number: those are what compilers make vectors of.
  void place(double edge, double shift, std::size_t axis) {
    const double inverse = 1.0 / edge, moved = edge * shift;
    const double* in = in_[axis].data();
    double *at = at_.data(), *low = low_.data(), *within = within_.data();
    std::int32_t* cell = cell_[axis].data();
    float* inside = inside_[axis].data();
    for (std::size_t i = 0; i < kSize; ++i) at[i] = (in[i] + moved) * inverse;
    // Written so that NaN fails: the cast is undefined for anything that does not fit.
    for (std::size_t i = 0; i < kSize; ++i) within[i] = std::abs(at[i]) < kCellLimit ? within[i] : 0.0;
    for (std::size_t i = 0; i < kSize; ++i) at[i] = std::abs(at[i]) < kCellLimit ? at[i] : 0.0;
    // floor(), of which gcc makes no vectors.
    for (std::size_t i = 0; i < kSize; ++i) cell[i] = static_cast<std::int32_t>(at[i]);
    for (std::size_t i = 0; i < kSize; ++i) low[i] = static_cast<double>(cell[i]);
    for (std::size_t i = 0; i < kSize; ++i) at[i] = low[i] > at[i] ? 1.0 : 0.0;
    for (std::size_t i = 0; i < kSize; ++i) low[i] -= at[i];
    for (std::size_t i = 0; i < kSize; ++i) cell[i] = static_cast<std::int32_t>(low[i]);
    for (std::size_t i = 0; i < kSize; ++i) inside[i] = static_cast<float>(in[i] - edge * (low[i] - shift));
  }

  template <class T>
  using Column = std::array<T, kSize>;
  std::array<Column<double>, 3> in_{};
  std::array<Column<float>, 3> inside_{};
  std::array<Column<std::int32_t>, 3> cell_{};
  Column<double> at_{}, low_{};  ///< of one axis, in cells: where the point is, and where its cell begins
  Column<double> within_{};      ///< 1, or 0 for a point without a cell
  Column<std::uint64_t> key_{};
};

}  // namespace aslio
