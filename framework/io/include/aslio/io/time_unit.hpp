#pragma once

#include <cstdint>

namespace aslio::io {

/// Unit of times in a file. `automatic`: judged by the times.
enum class TimeUnit : std::uint8_t { automatic, s, ms, us, ns };

}  // namespace aslio::io
