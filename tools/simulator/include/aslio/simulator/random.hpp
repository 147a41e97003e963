#pragma once

#include <cmath>
#include <cstdint>
#include <random>

#include "aslio/core/spread.hpp"

namespace aslio::simulator {

/// Random numbers that are the same on every platform: std::mt19937_64 is specified bit by bit, the distributions of
/// the standard library are not; mixed() gives neighbouring seeds unrelated states. One stream per purpose, so that
/// switching one noise off leaves the others as they are.
class RandomStream {
 public:
  RandomStream(std::uint64_t seed, std::uint64_t purpose) : engine_(mixed(seed + mixed(purpose))) {}
  /// One of many streams of a purpose, so that parts can be drawn in any order.
  RandomStream(std::uint64_t seed, std::uint64_t purpose, std::uint64_t part)
      : engine_(mixed(seed + mixed(purpose + mixed(part)))) {}

  /// [0, 1), 53 bits.
  double uniform() { return static_cast<double>(engine_() >> 11U) * 0x1p-53; }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }

  /// Standard normal (Marsaglia's polar method).
  double normal() {
    if (has_spare_) {
      has_spare_ = false;
      return spare_;
    }
    double x = 0;
    double y = 0;
    double s = 0;
    do {
      x = uniform(-1, 1);
      y = uniform(-1, 1);
      s = x * x + y * y;
    } while (s >= 1 || s == 0);
    const double scale = std::sqrt(-2 * std::log(s) / s);
    spare_ = y * scale;
    has_spare_ = true;
    return x * scale;
  }

 private:
  std::mt19937_64 engine_;
  double spare_ = 0;
  bool has_spare_ = false;
};

}  // namespace aslio::simulator
