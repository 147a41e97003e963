#pragma once

#include <array>
#include <span>

#include "aslio/config/binder.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/stages/overlap.hpp"
#include "stores/brick.hpp"

namespace aslio::plugins {

/// Occupied cells as bricks of 8^3 bits in an open-addressing table. For a cell that is not occupied, the bits around
/// it are looked at; a brick that is asked for more than a few such cells, without a change in or next to it, is
/// dilated: one bit plane per layer, so that a query is a few bit tests. The planes of the `cached` bricks asked for
/// last are kept (direct-mapped), whether or not they hold occupied cells: memory for planes does not grow with the
/// map, and no query allocates once depth and metric are settled. layers() must not be called concurrently.
class BlockHash final : public OccupancyStore {
 public:
  struct Params {
    std::int64_t cached = 4096;
  };
  static void describe(config::Binder& b, Params& p);
  BlockHash(const Params& params, const BuildContext& context);

  void insert(std::span<const Cell> cells) override;
  void layers(std::span<const Cell> cells, int depth, LayerMetric metric, std::span<std::uint8_t> out) override;
  void keep_inside(const Cell& lo, const Cell& hi) override;
  std::size_t size() const override { return size_; }
  std::size_t memory_bytes() const override;
  /// Keeps the memory.
  void clear() override;

  /// Bricks dilated so far.
  std::uint64_t dilations() const { return dilations_; }

 private:
  /// Cells whose bricks are fetched at once: looking for one after the other is waiting for memory.
  static constexpr std::size_t kBatch = 32;
  using Keys = std::array<std::uint64_t, kBatch>;
  static constexpr std::uint64_t kNone = ~std::uint64_t{0};  // no brick: keys have 63 bits
  struct Slot {
    std::uint64_t key = kNone;
    std::uint32_t brick = 0;
  };
  /// What is known of the brick whose planes have a place in the cache.
  struct Line {
    std::uint64_t key = kNone;
    std::uint32_t asked = 0;  // cells looked at one by one
    bool dilated = false;     // its planes are up to date
  };
  struct Label {
    std::uint64_t key = 0;
    std::uint32_t announced = 0;  // the query count at which the cache was last told of a change
  };
  /// Keys of the first kBatch cells, or as many as there are; the memory where they are looked for is asked for.
  std::size_t fetch(std::span<const Cell> cells, Keys& keys) const;
  /// Where a key is looked for first, and where it is or would be.
  std::size_t first_slot(std::uint64_t key) const;
  std::size_t slot_of(std::uint64_t key) const;
  const Brick* find(std::uint64_t key) const;
  std::size_t find_or_add(std::uint64_t key);
  void set(std::size_t brick, const Cell& cell, std::uint64_t key);
  void rehash(std::size_t slots);
  /// Forgets the planes of a brick and of its neighbours.
  void announce_change(std::uint64_t key);
  std::size_t line_of(std::uint64_t key) const;
  const Brick* planes_of(std::uint64_t key);
  std::uint8_t layer_of_unoccupied(const Cell& cell, std::uint64_t key);
  int layer_alone(const Cell& cell) const;
  void forget_planes();

  std::vector<Slot> slots_;
  unsigned slot_shift_ = 0;
  std::vector<Brick> bricks_;
  std::vector<Label> labels_;  // of bricks_
  std::size_t size_ = 0;
  std::uint32_t queries_ = 1;

  std::vector<Line> cache_;
  unsigned line_shift_ = 0;
  std::vector<Brick> planes_;  // depth_ for each line
  int depth_ = -1;
  LayerMetric metric_ = LayerMetric::chebyshev;
  std::uint64_t dilations_ = 0;
};

}  // namespace aslio::plugins
