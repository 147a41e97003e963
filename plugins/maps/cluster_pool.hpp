#pragma once
/// Point moments of keyframes, in one list per place, newest first.

#include <cstdint>
#include <utility>

#include "maps/point_moments.hpp"
#include "maps/slots.hpp"

namespace aslio::plugins {

/// A store of lists whose elements are used again. Memory is that of the most elements at a time.
class ClusterPool {
 public:
  static constexpr std::uint32_t kNone = 0xffffffff;
  struct Cluster {
    PointMoments points;
    std::uint32_t keyframe = 0;
    std::uint32_t next = kNone;  ///< older
  };

  /// That of `keyframe` in the list that begins at `head`, made there if the list has none. Pre: no newer one.
  Cluster& of(std::uint32_t& head, std::uint32_t keyframe) {
    if (head != kNone && clusters_[head].keyframe == keyframe) return clusters_[head];
    const std::uint32_t number = clusters_.take();
    Cluster& made = clusters_[number];
    made = {{}, keyframe, head};
    head = number;
    return made;
  }
  /// Calls with(cluster), newest first.
  template <class With>
  void each(std::uint32_t head, With with) {
    for (; head != kNone; head = clusters_[head].next) with(clusters_[head]);
  }
  template <class With>
  void each(std::uint32_t head, With with) const {
    for (; head != kNone; head = clusters_[head].next) with(clusters_[head]);
  }
  /// Calls with(cluster) for those of keyframes before `until`, newest first, and lets go of them.
  template <class With>
  void leave(std::uint32_t& head, std::uint32_t until, With with) {
    std::uint32_t* link = &head;
    while (*link != kNone && clusters_[*link].keyframe >= until) link = &clusters_[*link].next;
    std::uint32_t number = *link;
    *link = kNone;
    while (number != kNone) {
      with(clusters_[number]);
      clusters_.give_back(std::exchange(number, clusters_[number].next));
    }
  }
  void clear() { clusters_.clear(); }
  std::size_t memory_bytes() const { return clusters_.memory_bytes(); }

 private:
  Slots<Cluster, 10> clusters_;
};

}  // namespace aslio::plugins
