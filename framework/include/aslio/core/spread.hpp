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

/// Index of the item that stands for run k of `taken` equal runs of `n` items. Which of the run varies: a fixed stride
/// would fall into step with scan lines, which interleave (a stride of 6 on a six-line sensor sees one line).
/// Pre: k < taken <= n.
constexpr std::size_t one_of_run(std::size_t k, std::size_t taken, std::size_t n, std::uint64_t seed) {
  const std::size_t begin = k * n / taken, length = (k + 1) * n / taken - begin;
  return length == 1 ? begin : begin + mixed(seed + k) % length;
}

}  // namespace aslio
