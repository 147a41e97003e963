#include "aslio/toolkit/match_tally.hpp"

#include <algorithm>
#include <bit>

#include "aslio/core/spread.hpp"

namespace aslio {

namespace {
constexpr std::size_t kFirst = 1024;  // slots: some hundred planes are in view
}

std::size_t MatchTally::slot_of(const void* owner) {
  const std::size_t mask = owners_.size() - 1;
  // Fibonacci hashing: neighbours in memory go far apart.
  const auto bits = static_cast<std::uint64_t>(std::bit_cast<std::uintptr_t>(owner)) * kGoldenRatio;
  std::size_t slot = static_cast<std::size_t>(bits >> 32) & mask;
  while (owners_[slot] != nullptr && owners_[slot] != owner) slot = (slot + 1) & mask;
  return slot;
}

void MatchTally::reserve(std::size_t matches) {
  slots_.reserve(matches);
  const std::size_t size = std::bit_ceil(std::max(kFirst, matches / 2));
  if (owners_.size() < size) resize(size);
}

void MatchTally::resize(std::size_t size) {
  owners_.assign(size, nullptr);
  counts_.assign(size + 1, 0);
}

/// Whether the table was large enough.
bool MatchTally::tally(std::span<const std::span<Surface>> sets) {
  std::size_t used = 0, at = 0;
  for (const std::span<const Surface> surfaces : sets) {
    const void* last = nullptr;  // points come in the order in which they were measured: the next is often on the same
    std::size_t slot = 0;
    for (const Surface& surface : surfaces) {
      const void* owner = surface.valid ? surface.owner : nullptr;
      if (owner == nullptr) {
        slots_[at++] = static_cast<std::uint32_t>(owners_.size());
        continue;
      }
      if (owner != last) {
        slot = slot_of(owner);
        last = owner;
        if (owners_[slot] == nullptr) {
          if (2 * ++used > owners_.size()) return false;
          owners_[slot] = owner;
        }
      }
      slots_[at++] = static_cast<std::uint32_t>(slot);
      ++counts_[slot];
    }
  }
  return true;
}

void MatchTally::count(std::span<const std::span<Surface>> sets, double times) {
  std::size_t size = 0;
  for (const std::span<Surface> surfaces : sets) size += surfaces.size();
  slots_.resize(size);
  if (owners_.empty()) resize(kFirst);
  std::fill(owners_.begin(), owners_.end(), nullptr);
  std::fill(counts_.begin(), counts_.end(), 0U);
  while (!tally(sets)) resize(2 * owners_.size());
  counts_.back() = 1;
  std::size_t at = 0;
  for (const std::span<Surface> surfaces : sets) {
    for (Surface& surface : surfaces) surface.shared_matches = times * counts_[slots_[at++]];
  }
}

}  // namespace aslio
