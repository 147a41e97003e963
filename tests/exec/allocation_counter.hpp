#pragma once

#include <cstddef>

namespace test {

/// Number of calls of operator new of this program so far.
std::size_t allocation_count();

}  // namespace test
