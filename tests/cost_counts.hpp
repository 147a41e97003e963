#pragma once
/// Whether the limits of cost hold or fail in this build: the preset `speed` alone.

namespace aslio::test {

/// Where the figures of cost mean something: sanitizers, assertions and missing optimisation multiply them.
#if defined(__OPTIMIZE__) && defined(NDEBUG) && !defined(_GLIBCXX_ASSERTIONS) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
inline constexpr bool kCostCounts = true;
#else
inline constexpr bool kCostCounts = false;
#endif

}  // namespace aslio::test
