#include "overlaps/voxel_overlap.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace aslio::plugins {

namespace {

/// SplitMix64 (Steele et al. 2014): the jitter of strides.
std::uint64_t mix(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

/// The store is trimmed each time the sensor has moved by this share of the radius.
constexpr double kTrimStep = 0.1;

}  // namespace

VoxelOverlap::VoxelOverlap(Settings settings, std::unique_ptr<OccupancyStore> occupied,
                           std::unique_ptr<OccupancyStore> due)
    : settings_(std::move(settings)),
      inverse_voxel_(1.0 / settings_.voxel),
      occupied_(std::move(occupied)),
      due_(std::move(due)) {}

void VoxelOverlap::count_cells(std::span<const WorldPoint> points) {
  const std::size_t n = points.size();
  const std::size_t taken = settings_.max_points == 0 ? n : std::min(n, settings_.max_points);
  histogram_.reset(taken);
  for (std::size_t i = 0; i < taken; ++i) {
    // One point of each of `taken` equal runs. Which one varies: a fixed stride would fall into step with the scan
    // lines, which interleave (a stride of 6 on a six-line sensor sees one line).
    const std::size_t begin = i * n / taken, length = (i + 1) * n / taken - begin;
    const std::size_t index = length == 1 ? begin : begin + mix(settings_.order_seed + i) % length;
    Cell cell;
    if (CellHistogram::cell_of(points[index].p_W, inverse_voxel_, cell)) histogram_.add(cell);
  }
}

std::size_t VoxelOverlap::frames_due(TimeNs t) const {
  const auto later = std::find_if(waiting_.begin(), waiting_.end(), [t](const Frame& f) { return f.due > t; });
  return static_cast<std::size_t>(later - waiting_.begin());
}

void VoxelOverlap::gather_due(std::size_t frames) {
  const std::uint64_t end = merged_ + frames;
  if (due_begin_ != merged_ || due_end_ > end) {
    due_->clear();
    due_begin_ = due_end_ = merged_;
  }
  for (; due_end_ < end; ++due_end_) due_->insert(waiting_[static_cast<std::size_t>(due_end_ - merged_)].cells);
}

void VoxelOverlap::find_layers() {
  const auto cells = histogram_.cells();
  if (layers_.capacity() < cells.size()) {
    // Twice, and all at once: which cells are unseen, and how many, changes from frame to frame.
    for (auto* list : {&layers_, &due_layers_}) list->reserve(2 * cells.size());
    unseen_.reserve(2 * cells.size());
    unseen_index_.reserve(2 * cells.size());
  }
  layers_.resize(cells.size());
  occupied_->layers(cells, depth(), settings_.metric, layers_);
  if (due_->size() == 0) return;
  unseen_.clear();
  unseen_index_.clear();
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (layers_[i] == 0) continue;
    unseen_.push_back(cells[i]);
    unseen_index_.push_back(i);
  }
  due_layers_.resize(unseen_.size());
  due_->layers(unseen_, depth(), settings_.metric, due_layers_);
  for (std::size_t j = 0; j < unseen_.size(); ++j) {
    layers_[unseen_index_[j]] = std::min(layers_[unseen_index_[j]], due_layers_[j]);
  }
}

OverlapScore VoxelOverlap::evaluate(std::span<const WorldPoint> points, TimeNs t) {
  gather_due(frames_due(t));
  OverlapScore score;
  count_cells(points);
  for (const std::uint32_t count : histogram_.counts()) score.points += count;
  if (occupied_->size() + due_->size() == 0) return score;
  find_layers();
  for (std::size_t i = 0; i < layers_.size(); ++i) {
    if (layers_[i] <= depth()) score.layers[layers_[i]] += histogram_.counts()[i];
  }
  if (score.points == 0 || score.points < settings_.min_points) return score;
  double sum = 0;
  for (std::size_t i = 0; i < settings_.beta.size(); ++i) sum += settings_.beta[i] * score.layers[i];
  score.value = sum / score.points;
  return score;
}

void VoxelOverlap::extend(std::span<const WorldPoint> points, TimeNs t) {
  Frame frame{t + settings_.delay, {}};
  if (!spare_.empty()) {
    frame.cells = std::move(spare_.back());
    spare_.pop_back();
  }
  frame.cells.clear();
  for (const WorldPoint& point : points) {
    Cell cell;
    if (!CellHistogram::cell_of(point.p_W, inverse_voxel_, cell)) continue;
    // A store takes repeated cells; only runs of the same are worth leaving out.
    if (frame.cells.empty() || frame.cells.back() != cell) frame.cells.push_back(cell);
  }
  waiting_.push_back(std::move(frame));
  for (std::size_t frames = frames_due(t); frames > 0; --frames) {
    occupied_->insert(waiting_.front().cells);
    spare_.push_back(std::move(waiting_.front().cells));
    waiting_.pop_front();
    ++merged_;
  }
}

void VoxelOverlap::trim(const Vec3& centre_W, double radius) {
  const bool near = trimmed_radius_ == radius && (centre_W - trimmed_at_).norm() < kTrimStep * radius;
  if (!centre_W.allFinite() || near) return;
  trimmed_at_ = centre_W;
  trimmed_radius_ = radius;
  const auto clamped = [&](double c) {
    constexpr double limit = 1 << 20;
    return static_cast<std::int32_t>(std::clamp(std::floor(c * inverse_voxel_), -limit, limit));
  };
  const Vec3 lo = centre_W.array() - radius, hi = centre_W.array() + radius;
  occupied_->keep_inside({clamped(lo.x()), clamped(lo.y()), clamped(lo.z())},
                         {clamped(hi.x()), clamped(hi.y()), clamped(hi.z())});
}

std::size_t VoxelOverlap::memory_bytes() const {
  std::size_t bytes = sizeof(*this) + occupied_->memory_bytes() + due_->memory_bytes() + histogram_.memory_bytes();
  for (const Frame& frame : waiting_) bytes += sizeof(frame) + frame.cells.capacity() * sizeof(Cell);
  for (const auto& cells : spare_) bytes += cells.capacity() * sizeof(Cell);
  bytes += layers_.capacity() + due_layers_.capacity() + unseen_.capacity() * sizeof(Cell);
  return bytes + unseen_index_.capacity() * sizeof(std::size_t);
}

}  // namespace aslio::plugins
