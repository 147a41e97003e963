#pragma once
/// How many matches of one evaluation lie on the same surface of the map. (RES-5)

#include <cstdint>
#include <span>
#include <vector>

#include "aslio/stages/surface.hpp"

namespace aslio {

/// Counts matches by Surface::owner. Only equality of owners matters, so that the counts are the same wherever the map
/// lies in memory. Its memory grows to the largest number of surfaces met at once and is kept.
class MatchTally {
 public:
  /// Room for so many matches of which four and more share a surface in the mean; with fewer, count() may allocate.
  void reserve(std::size_t matches);
  /// Surface::shared_matches of each becomes `times` the number of valid matches with the same owner, itself included,
  /// or `times` without an owner.
  void count(std::span<Surface> surfaces, double times = 1.0) {
    count(std::span<const std::span<Surface>>(&surfaces, 1), times);
  }
  /// The same of several sets that are registered together.
  void count(std::span<const std::span<Surface>> sets, double times = 1.0);

 private:
  bool tally(std::span<const std::span<Surface>> sets);
  std::size_t slot_of(const void* owner);
  void resize(std::size_t size);

  /// Open addressing; slots of no owner follow the table: one for matches that share their surface with none.
  std::vector<const void*> owners_;
  std::vector<std::uint32_t> counts_;  ///< of each slot; the last is 1
  std::vector<std::uint32_t> slots_;   ///< of each match
};

}  // namespace aslio
