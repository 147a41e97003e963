#include "overlaps/voxel_overlap.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "aslio/core/spread.hpp"
#include "overlaps/cell_of.hpp"

namespace aslio::plugins {

namespace {

/// The store is trimmed each time the sensor has moved by this share of the radius.
constexpr double kTrimStep = 0.1;

/// Most of the cells met lately: a beam meets its cells again within a few points, on this scan line or the next.
class RecentCells {
 public:
  RecentCells() { keys_.fill(~std::uint64_t{0}); }  // no cell: keys have 63 bits
  /// Was the cell met already? Never true for one that was not, false for some that were. Notes it.
  bool repeats(const Cell& cell) {
    const std::uint64_t key = pack_cell(cell.x, cell.y, cell.z);
    return std::exchange(keys_[static_cast<std::size_t>(key * kGoldenRatio >> (64 - kBits))], key) == key;
  }

 private:
  static constexpr unsigned kBits = 8;
  std::array<std::uint64_t, std::size_t{1} << kBits> keys_;
};

}  // namespace

void VoxelOverlap::describe(config::Binder& b, Params& p) {
  b.real("voxel", p.voxel, "m", {.min = 0.001, .max = 100.0}, "edge of a voxel");
  b.choice(
      "points", p.points, {{"latest", Points::latest}, {"window", Points::window}},
      "what is scored: the points since the last update, or all of the last frame_length, most of which are known");
  b.real("frame_length", p.frame_length, "s", {.min = 0.001, .max = 10.0}, "with 'points: window': its length");
  b.real("delay", p.delay, "s", {.min = 0.0, .max = 100.0},
         "age of the points that count as known, against the middle of the frame (0: all, which makes the score of "
         "short frames rise)");
  b.integer("max_points", p.max_points, "", {.min = 0}, "points of a frame that are scored, spread evenly (0: all)");
  b.integer("min_points", p.min_points, "", {.min = 1},
            "below this many points the score is undefined (a look ahead of the window scores 2000 at most, or with "
            "'points: window' all)");
  b.require(p.max_points == 0 || p.max_points >= p.min_points, "max_points",
            "must be 0 or at least min_points, or no frame would ever have a score");
  b.stage("store", p.store, "what holds the occupied voxels");
}

VoxelOverlap::VoxelOverlap(const Params& params, LayerMetric metric, std::vector<double> beta,
                           const BuildContext& context)
    : inverse_voxel_(1.0 / params.voxel),
      metric_(metric),
      beta_(std::move(beta)),
      delay_(to_ns(params.delay)),
      frame_length_(params.points == Points::window ? to_ns(params.frame_length) : 0),
      max_points_(static_cast<std::size_t>(params.max_points)),
      min_points_(static_cast<std::size_t>(params.min_points)),
      order_seed_(context.order_seed),
      occupied_(params.store.make(context)),
      due_(params.store.make(context)) {}

/// What trim() forgets again would be new each time.
bool VoxelOverlap::counts(const WorldPoint& point, Cell& cell) const {
  return static_cast<double>(point.range) <= far_ && cell_of(point.p_W, inverse_voxel_, cell);
}

void VoxelOverlap::choose(std::span<const WorldPoint> points, TimeNs t) {
  older_.clear();
  for (const KnownPoint& known : known_) {
    if (known.t > t - frame_length_) older_.push_back(known.cell);
  }
  const std::size_t n = older_.size() + points.size();
  const std::size_t taken = max_points_ == 0 ? n : std::min(n, max_points_);
  scored_.clear();
  point_of_.clear();
  next_scored_ = 0;
  StratifiedPick choice(taken, n, order_seed_);
  for (std::size_t i = 0; i < taken; ++i) {
    const std::size_t index = choice.next();
    Cell cell;
    if (index < older_.size()) {
      scored_.push_back(older_[index]);
      ++next_scored_;
      point_of_.push_back(0);
    } else if (counts(points[index - older_.size()], cell)) {
      scored_.push_back(cell);
      point_of_.push_back(index - older_.size());
    }
  }
}

void VoxelOverlap::remember(std::span<const WorldPoint> points, TimeNs t) {
  if (frame_length_ == 0) return;
  std::erase_if(known_, [&](const KnownPoint& known) { return known.t <= t - frame_length_; });
  for (const WorldPoint& point : points) {
    Cell cell;
    if (counts(point, cell)) known_.push_back({point.t, cell});
  }
}

// eq. SOD-3.
TimeNs VoxelOverlap::horizon(TimeNs t) const {
  // Half of what no frame should exceed, where updates were not merged.
  return t - delay_ - std::min((t - extended_) / 2, delay_ / 2);
}

void VoxelOverlap::gather_due(std::size_t slices) {
  const std::uint64_t end = merged_ + slices;
  if (due_begin_ != merged_ || due_end_ > end) {
    forget_due();
  }
  due_->insert(waiting_.cells(static_cast<std::size_t>(due_end_ - merged_), slices));
  due_end_ = end;
}

void VoxelOverlap::find_layers() {
  if (layers_.capacity() < scored_.size()) {
    // Twice, and all at once: which cells are unseen, and how many, changes from frame to frame.
    for (auto* list : {&layers_, &due_layers_}) list->reserve(2 * scored_.size());
    unseen_.reserve(2 * scored_.size());
    unseen_index_.reserve(2 * scored_.size());
  }
  layers_.resize(scored_.size());
  occupied_->layers(scored_, depth(), metric_, layers_);
  if (due_->size() == 0) return;
  unseen_.clear();
  unseen_index_.clear();
  for (std::size_t i = 0; i < scored_.size(); ++i) {
    if (layers_[i] == 0) continue;
    unseen_.push_back(scored_[i]);
    unseen_index_.push_back(i);
  }
  due_layers_.resize(unseen_.size());
  due_->layers(unseen_, depth(), metric_, due_layers_);
  for (std::size_t j = 0; j < unseen_.size(); ++j) {
    layers_[unseen_index_[j]] = std::min(layers_[unseen_index_[j]], due_layers_[j]);
  }
}

// eqs. SOD-1, SOD-2.
OverlapScore VoxelOverlap::evaluate(std::span<const WorldPoint> points, TimeNs t) {
  gather_due(waiting_.ended(horizon(t)));
  OverlapScore score;
  choose(points, t);
  score.points = static_cast<std::uint32_t>(scored_.size());
  layers_.clear();
  if (occupied_->size() + due_->size() == 0) return score;
  find_layers();
  for (const std::uint8_t layer : layers_) {
    if (layer <= depth()) ++score.layers[layer];
  }
  if (score.points == 0 || score.points < min_points_) return score;
  double sum = 0;
  for (std::size_t i = 0; i < beta_.size(); ++i) sum += beta_[i] * score.layers[i];
  score.value = sum / score.points;
  return score;
}

void VoxelOverlap::advance(TimeNs t) {
  const std::size_t slices = waiting_.ended(horizon(t));
  occupied_->insert(waiting_.cells(0, slices));
  waiting_.drop(slices);
  merged_ += slices;
}

void VoxelOverlap::extend(std::span<const WorldPoint> points, TimeNs t) {
  remember(points, t);
  TimeNs time = std::min(extended_, t);
  RecentCells recent;
  for (std::size_t i = 0; i < points.size(); ++i) {
    time = std::clamp(points[i].t, time, t);
    Cell cell;
    if (!counts(points[i], cell)) continue;
    waiting_.reach(time);
    const bool again = recent.repeats(cell), known = found_occupied(i, cell);
    if (!again && !known) waiting_.add(cell);
  }
  waiting_.close();
  extended_ = t;
  advance(t);
}

void VoxelOverlap::clear() {
  const std::size_t slices = waiting_.ended(kTimeMax);
  waiting_.drop(slices);
  merged_ += slices;
  occupied_->clear();
  forget_due();
  known_.clear();
  layers_.clear();
  trimmed_radius_ = -1;
  far_ = std::numeric_limits<double>::infinity();
}

void VoxelOverlap::trim(const Vec3& centre_W, double radius) {
  const bool near = trimmed_radius_ == radius && (centre_W - trimmed_at_).norm() < kTrimStep * radius;
  if (!centre_W.allFinite() || near) return;
  trimmed_at_ = centre_W;
  trimmed_radius_ = radius;
  far_ = (1.0 - kTrimStep) * radius;
  const auto clamped = [&](double c) {
    constexpr double limit = kCellRange;
    return static_cast<std::int32_t>(std::clamp(std::floor(c * inverse_voxel_), -limit, limit));
  };
  const Vec3 low = centre_W.array() - radius, high = centre_W.array() + radius;
  const Cell lo{clamped(low.x()), clamped(low.y()), clamped(low.z())};
  const Cell hi{clamped(high.x()), clamped(high.y()), clamped(high.z())};
  occupied_->keep_inside(lo, hi);
  // What waits, too: else a cell would be known again if it was learnt twice, and not if once.
  waiting_.keep_inside(lo, hi);
  forget_due();
  layers_.clear();
}

void VoxelOverlap::forget_due() {
  due_->clear();
  due_begin_ = due_end_ = merged_;
}

std::size_t VoxelOverlap::memory_bytes() const {
  std::size_t bytes = sizeof(*this) + occupied_->memory_bytes() + due_->memory_bytes() + waiting_.memory_bytes();
  bytes += known_.capacity() * sizeof(KnownPoint) + older_.capacity() * sizeof(Cell);
  bytes += layers_.capacity() + due_layers_.capacity() + (scored_.capacity() + unseen_.capacity()) * sizeof(Cell);
  return bytes + (point_of_.capacity() + unseen_index_.capacity()) * sizeof(std::size_t);
}

}  // namespace aslio::plugins
