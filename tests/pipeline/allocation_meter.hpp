#pragma once
/// Counts what the heap is asked for while armed, by operator new and by malloc (Eigen calls malloc). Link
/// allocation_meter.cpp with -Wl,--wrap=malloc.

#include <cstddef>

namespace aslio::test {

void arm_allocation_meter(bool on);
/// Allocations while armed, so far.
std::size_t allocations_metered();

}  // namespace aslio::test
