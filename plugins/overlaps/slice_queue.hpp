#pragma once
/// Cells that wait until they count, in slices of time.

#include <cstddef>
#include <span>
#include <vector>

#include "aslio/stages/overlap.hpp"

namespace aslio::plugins {

/// In order of time; allocates only while what waits grows.
class SliceQueue {
 public:
  /// Points of at most this much time come to count together.
  static constexpr TimeNs kLength = 5 * kSecond / 1000;

  /// Goes on to time `t`, which is not before any so far: a slice is open then that takes it.
  void reach(TimeNs t) {
    if (!open_ || t > begin_ + kLength) begin(t);
    slices_.back().t = t;
  }
  /// A cell of the time last reached. Pre: reach() since the last close().
  void add(const Cell& cell) {
    cells_.push_back(cell);
    slices_.back().end_cell = cells_.size();
  }
  /// What is reached next begins a slice.
  void close() { open_ = false; }
  /// How many slices, from the oldest on, have ended by `t`.
  std::size_t ended(TimeNs t) const;
  /// The cells of slices [begin, end), counted from the oldest.
  std::span<const Cell> cells(std::size_t begin, std::size_t end) const;
  void drop(std::size_t slices);
  /// Drops cells outside the axis-aligned cube [lo, hi]; the slices stay.
  void keep_inside(const Cell& lo, const Cell& hi);
  std::size_t memory_bytes() const;

 private:
  struct Slice {
    TimeNs t = 0;              // of its end
    std::size_t end_cell = 0;  // position in cells_
  };
  void begin(TimeNs t);
  /// Position in cells_ where slice `number`, counted from the oldest, begins.
  std::size_t begin_of(std::size_t number) const;

  std::vector<Cell> cells_;
  std::vector<Slice> slices_;
  std::size_t dropped_ = 0;  // of slices_
  TimeNs begin_ = 0;         // of the last slice
  bool open_ = false;
};

}  // namespace aslio::plugins
