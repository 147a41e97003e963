#pragma once
/// Choosing some of many evenly, and out of step with whatever period they have.

#include <cstddef>
#include <cstdint>

namespace aslio {

/// 2^64 by the golden ratio: multiples of it (mod 2^64) are spread evenly over any run of factors.
inline constexpr std::uint64_t kGoldenRatio = 0x9e3779b97f4a7c15U;

/// Bits without a pattern, the same for the same x (SplitMix64, Steele et al. 2014).
constexpr std::uint64_t mixed(std::uint64_t x) {
  x += kGoldenRatio;
  x = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9U;
  x = (x ^ (x >> 27U)) * 0x94d049bb133111ebU;
  return x ^ (x >> 31U);
}

/// One item of each of `taken` equal runs of `n` items: run k is [k n / taken, (k + 1) n / taken). Which of the run
/// varies with `seed`: a fixed stride would fall into step with scan lines, which interleave (a stride of 6 on a
/// six-line sensor sees one line). Pre: taken <= n.
class StratifiedPick {
 public:
  constexpr StratifiedPick(std::size_t taken, std::size_t n, std::uint64_t seed)
      : taken_(taken), length_(taken == 0 ? 0 : n / taken), step_(taken == 0 ? 0 : n % taken), seed_(seed) {}
  /// Index of the item that stands for the next run. At most `taken` calls.
  constexpr std::size_t next() {
    // Of k n / taken, in parts of `taken`: no division per run.
    remainder_ += step_;
    const bool longer = remainder_ >= taken_;
    if (longer) remainder_ -= taken_;
    const std::size_t begin = begin_, length = length_ + (longer ? 1 : 0);
    begin_ += length;
    const std::uint64_t k = run_++;
    return length == 1 ? begin : begin + mixed(seed_ + k) % length;
  }

 private:
  std::size_t taken_, length_, step_, remainder_ = 0, begin_ = 0;
  std::uint64_t seed_, run_ = 0;
};

}  // namespace aslio
