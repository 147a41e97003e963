#pragma once
/// Points for samplers, with the storage that a SampleBatch is a view of.

#include <random>
#include <vector>

#include "aslio/stages/sampler.hpp"

namespace aslio::test {

struct Batch {
  std::vector<TimedPoint> raw;
  std::vector<Eigen::Vector3f> body;
  std::vector<PointUses> uses;

  SampleBatch view() { return {.raw = raw, .body = body, .uses = uses}; }
  std::size_t count(PointUse use) const {
    std::size_t n = 0;
    for (const PointUses bits : uses) n += (bits & mask(use)) != 0;
    return n;
  }
  void add(const Eigen::Vector3f& p, PointUses bits = kAllUses) {
    TimedPoint point;
    point.x = p.x();
    point.y = p.y();
    point.z = p.z();
    point.index = static_cast<std::uint32_t>(raw.size());
    point.line = static_cast<std::uint8_t>(raw.size() % 6);
    point.t = static_cast<TimeNs>(raw.size() / 6) * 25'000;
    raw.push_back(point);
    body.push_back(p);
    uses.push_back(bits);
  }
};

/// Firings of six points in a cube of +-`half` metres around the origin.
inline Batch random_batch(std::size_t points, std::uint64_t seed, float half, bool mixed_taps = false) {
  std::mt19937_64 random(seed);
  const auto coordinate = [&] { return half * (static_cast<float>(random() % 20001) / 10000.0f - 1.0f); };
  Batch batch;
  for (std::size_t i = 0; i < points; ++i) {
    const float x = coordinate(), y = coordinate(), z = coordinate();
    batch.add({x, y, z}, mixed_taps ? static_cast<PointUses>(random() % 8) : kAllUses);
  }
  return batch;
}

}  // namespace aslio::test
