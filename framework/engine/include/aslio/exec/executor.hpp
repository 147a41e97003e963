#pragma once
/// Ordered parallelism: the only room that knows threads. Work is split into chunks whose bounds depend on the
/// problem size alone, never on the number of threads; reductions combine the chunks in index order. So the result
/// has the same bits for any number of threads. No allocation per call.

#include <cstddef>
#include <memory>
#include <span>
#include <type_traits>

namespace aslio::exec {

/// Non-owning callable of one chunk index.
class ChunkFunction {
 public:
  template <class F>
  requires(!std::is_same_v<std::remove_cvref_t<F>, ChunkFunction>)
      ChunkFunction(F& f)  // NOLINT(google-explicit-constructor): a view, used at call sites only
      : object_(&f), call_([](void* object, std::size_t chunk) { (*static_cast<F*>(object))(chunk); }) {}
  void operator()(std::size_t chunk) const { call_(object_, chunk); }

 private:
  void* object_;
  void (*call_)(void*, std::size_t);
};

class Executor {
 public:
  /// threads >= 1; throws ConfigError otherwise.
  explicit Executor(int threads = 1);
  ~Executor();
  Executor(const Executor&) = delete;
  Executor& operator=(const Executor&) = delete;

  int threads() const;

  /// Calls f(chunk) once for every chunk in [0, chunks), in any order and concurrently. An exception thrown by a
  /// chunk is rethrown here after all chunks have ended (the one of the lowest chunk index).
  void for_chunks(std::size_t chunks, ChunkFunction f);

  /// f(begin, end, chunk) over [0, n) in chunks of `grain` elements.
  template <class F>
  void for_ranges(std::size_t n, std::size_t grain, F&& f) {
    auto body = [&](std::size_t chunk) {
      const std::size_t begin = chunk * grain;
      f(begin, begin + grain < n ? begin + grain : n, chunk);
    };
    for_chunks(chunk_count(n, grain), ChunkFunction(body));
  }

  /// Ordered reduction: partial[c] = map(begin, end) for each chunk, then combine(total, partial[c]) in index order.
  /// `partials` is the caller's scratch with at least chunk_count(n, grain) elements.
  template <class T, class Map, class Combine>
  T reduce(std::size_t n, std::size_t grain, T total, std::span<T> partials, Map&& map, Combine&& combine) {
    for_ranges(n, grain,
               [&](std::size_t begin, std::size_t end, std::size_t chunk) { partials[chunk] = map(begin, end); });
    const std::size_t chunks = chunk_count(n, grain);
    for (std::size_t c = 0; c < chunks; ++c) combine(total, partials[c]);
    return total;
  }

  static constexpr std::size_t chunk_count(std::size_t n, std::size_t grain) { return (n + grain - 1) / grain; }

 private:
  class Backend;
  std::unique_ptr<Backend> backend_;
};

}  // namespace aslio::exec
