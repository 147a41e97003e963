#include "overlaps/slice_queue.hpp"

#include <algorithm>

namespace aslio::plugins {

void SliceQueue::begin(TimeNs t) {
  slices_.push_back({t, cells_.size()});
  begin_ = t;
  open_ = true;
}

std::size_t SliceQueue::begin_of(std::size_t number) const {
  const std::size_t i = dropped_ + number;
  return i == 0 ? 0 : slices_[i - 1].end_cell;
}

std::size_t SliceQueue::ended(TimeNs t) const {
  const auto first = slices_.begin() + static_cast<std::ptrdiff_t>(dropped_);
  return static_cast<std::size_t>(std::find_if(first, slices_.end(), [t](const Slice& s) { return s.t > t; }) - first);
}

std::span<const Cell> SliceQueue::cells(std::size_t begin, std::size_t end) const {
  return std::span(cells_).subspan(begin_of(begin), begin_of(end) - begin_of(begin));
}

void SliceQueue::drop(std::size_t slices) {
  dropped_ += slices;
  const std::size_t gone = begin_of(0);
  if (2 * gone < cells_.size()) return;  // each cell is moved about once
  cells_.erase(cells_.begin(), cells_.begin() + static_cast<std::ptrdiff_t>(gone));
  slices_.erase(slices_.begin(), slices_.begin() + static_cast<std::ptrdiff_t>(dropped_));
  dropped_ = 0;
  for (Slice& slice : slices_) slice.end_cell -= gone;
}

void SliceQueue::keep_inside(const Cell& lo, const Cell& hi) {
  std::size_t next = begin_of(0), kept = 0;
  slices_.erase(slices_.begin(), slices_.begin() + static_cast<std::ptrdiff_t>(dropped_));
  dropped_ = 0;
  for (Slice& slice : slices_) {
    for (; next < slice.end_cell; ++next) {
      const Cell& cell = cells_[next];
      const bool inside =
          cell.x >= lo.x && cell.x <= hi.x && cell.y >= lo.y && cell.y <= hi.y && cell.z >= lo.z && cell.z <= hi.z;
      if (inside) cells_[kept++] = cell;
    }
    slice.end_cell = kept;
  }
  cells_.resize(kept);
}

std::size_t SliceQueue::memory_bytes() const {
  return cells_.capacity() * sizeof(Cell) + slices_.capacity() * sizeof(Slice);
}

}  // namespace aslio::plugins
