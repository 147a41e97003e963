#pragma once
/// The OpenMP backend of Executor (ASLIO_EXEC_BACKEND=openmp).

#include <cstddef>

#include "aslio/exec/executor.hpp"

namespace aslio::exec {

/// One parallel region per call, static schedule. Set OMP_WAIT_POLICY=passive in the environment on a machine that is
/// shared: libgomp spins at its barriers otherwise, and reads the variable when it is loaded, before any of our code.
class OpenMpPool {
 public:
  explicit OpenMpPool(int threads) : threads_(threads) {}

  /// Calls body(chunk) for each chunk; `body` does not throw. One call at a time.
  void run(std::size_t chunks, ChunkFunction body) {
    const auto end = static_cast<std::ptrdiff_t>(chunks);
#pragma omp parallel for schedule(static) num_threads(threads_)
    for (std::ptrdiff_t chunk = 0; chunk < end; ++chunk) body(static_cast<std::size_t>(chunk));
  }

 private:
  int threads_;
};

}  // namespace aslio::exec
