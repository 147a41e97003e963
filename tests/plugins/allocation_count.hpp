#pragma once

#include <cstddef>

namespace aslio::test {

/// Heap allocations made by this program so far. Link allocation_count.cpp.
std::size_t allocation_count();

}  // namespace aslio::test
