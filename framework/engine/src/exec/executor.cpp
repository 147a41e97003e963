#include "aslio/exec/executor.hpp"

#include <fmt/format.h>

#include <atomic>
#include <exception>
#include <mutex>

#include "aslio/core/errors.hpp"
#ifdef ASLIO_EXEC_OPENMP
#include "openmp_pool.hpp"
#else
#include "thread_pool.hpp"
#endif

namespace aslio::exec {

namespace {

#ifdef ASLIO_EXEC_OPENMP
using Pool = OpenMpPool;
#else
using Pool = ThreadPool;
#endif

/// Keeps the exception of the lowest chunk.
class Failure {
 public:
  void keep(std::size_t chunk, std::exception_ptr error) {
    const std::lock_guard lock(mutex_);
    if (error_ && chunk_ < chunk) return;
    chunk_ = chunk;
    error_ = std::move(error);
  }
  void rethrow() {
    if (error_) std::rethrow_exception(std::move(error_));
  }

 private:
  std::mutex mutex_;
  std::size_t chunk_ = 0;
  std::exception_ptr error_;
};

}  // namespace

class Executor::Backend {
 public:
  explicit Backend(int threads) : threads_(threads), pool_(threads) {}

  int threads() const { return threads_; }

  void for_chunks(std::size_t chunks, const ChunkFunction& f) {
    Failure failure;
    auto guarded = [&](std::size_t chunk) {
      try {
        f(chunk);
      } catch (...) {
        failure.keep(chunk, std::current_exception());
      }
    };
    // Busy: a nested call from inside a chunk, or a call from a second thread. Both run where they are.
    if (threads_ > 1 && chunks > 1 && !busy_.test_and_set(std::memory_order_acquire)) {
      pool_.run(chunks, ChunkFunction(guarded));
      busy_.clear(std::memory_order_release);
    } else {
      for (std::size_t chunk = 0; chunk < chunks; ++chunk) guarded(chunk);
    }
    failure.rethrow();
  }

 private:
  int threads_;
  std::atomic_flag busy_;
  Pool pool_;
};

namespace {

int checked_threads(int threads) {
  if (threads >= 1) return threads;
  throw ConfigError(fmt::format("threads is {}, must be at least 1", threads));
}

}  // namespace

Executor::Executor(int threads) : backend_(std::make_unique<Backend>(checked_threads(threads))) {}
Executor::~Executor() = default;

int Executor::threads() const { return backend_->threads(); }

void Executor::for_chunks(std::size_t chunks, ChunkFunction f) { backend_->for_chunks(chunks, f); }

}  // namespace aslio::exec
