#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <new>
#include <numeric>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "aslio/core/errors.hpp"
#include "aslio/exec/executor.hpp"
#include "exec/allocation_counter.hpp"

namespace {

using aslio::ConfigError;
using aslio::exec::ChunkFunction;
using aslio::exec::Executor;
using test::allocation_count;

const int kThreads[] = {1, 2, 3, 8};

/// Floats whose sum depends on the order of addition in nearly every bit.
std::vector<float> awkward_numbers(std::size_t n) {
  std::vector<float> x(n);
  std::uint32_t state = 12345;
  for (float& value : x) {
    state = state * 1664525u + 1013904223u;
    const float mantissa = static_cast<float>(state >> 8) - 8388608.0f;
    value = std::ldexp(mantissa, static_cast<int>(state % 40u) - 40);
  }
  return x;
}

std::uint32_t bits(float value) {
  std::uint32_t b = 0;
  std::memcpy(&b, &value, sizeof(b));
  return b;
}

float ordered_sum(Executor& executor, const std::vector<float>& x, std::size_t grain, std::vector<float>& partials) {
  return executor.reduce(
      x.size(), grain, 0.0f, std::span<float>(partials),
      [&](std::size_t begin, std::size_t end) {
        float sum = 0.0f;
        for (std::size_t i = begin; i < end; ++i) sum += x[i];
        return sum;
      },
      [](float& total, float part) { total += part; });
}

}  // namespace

TEST_CASE("a float reduction has the same bits for 1, 2, 3 and 8 threads") {
  const std::vector<float> x = awkward_numbers(100'003);
  constexpr std::size_t grain = 256;
  std::vector<float> partials(Executor::chunk_count(x.size(), grain));

  float expected = 0.0f;  // the definition, without an executor
  for (std::size_t begin = 0; begin < x.size(); begin += grain) {
    float part = 0.0f;
    for (std::size_t i = begin; i < std::min(begin + grain, x.size()); ++i) part += x[i];
    expected += part;
  }
  // The numbers must be such that another order would show.
  REQUIRE(bits(std::accumulate(x.rbegin(), x.rend(), 0.0f)) != bits(expected));

  for (const int threads : kThreads) {
    Executor executor(threads);
    for (int repetition = 0; repetition < 20; ++repetition) {
      std::fill(partials.begin(), partials.end(), -1.0f);
      INFO(threads << " threads, repetition " << repetition);
      REQUIRE(bits(ordered_sum(executor, x, grain, partials)) == bits(expected));
    }
  }
}

TEST_CASE("every chunk runs once and the ranges tile the problem") {
  for (const int threads : kThreads) {
    Executor executor(threads);
    CHECK(executor.threads() == threads);
    for (const std::size_t n : {0u, 1u, 7u, 8u, 9u, 1000u}) {
      std::vector<int> visits(n, 0);
      executor.for_ranges(n, 8, [&](std::size_t begin, std::size_t end, std::size_t chunk) {
        if (begin != chunk * 8 || end <= begin || end > n) throw std::logic_error("wrong range");
        for (std::size_t i = begin; i < end; ++i) ++visits[i];
      });
      CHECK(visits == std::vector<int>(n, 1));
    }
  }
}

TEST_CASE("nothing to do calls nothing") {
  Executor executor(3);
  int calls = 0;
  auto count = [&](std::size_t) { ++calls; };
  executor.for_chunks(0, ChunkFunction(count));
  CHECK(calls == 0);
  std::span<double> none;
  const double total = executor.reduce(
      0, 16, 42.0, none, [](std::size_t, std::size_t) { return 1.0; }, [](double& t, double x) { t += x; });
  CHECK(total == 42.0);
}

TEST_CASE("many tiny calls in a row give the right result each time") {
  for (const int threads : {2, 8}) {
    Executor executor(threads);
    std::vector<std::size_t> seen(5);
    for (std::size_t call = 0; call < 5'000; ++call) {
      const std::size_t chunks = 1 + call % seen.size();
      auto mark = [&](std::size_t chunk) { seen[chunk] = call; };
      executor.for_chunks(chunks, ChunkFunction(mark));
      for (std::size_t chunk = 0; chunk < chunks; ++chunk) REQUIRE(seen[chunk] == call);
    }
  }
}

TEST_CASE("the exception of the lowest chunk comes back after all chunks have ended") {
  for (const int threads : kThreads) {
    Executor executor(threads);
    for (int repetition = 0; repetition < 50; ++repetition) {
      std::vector<int> ended(64, 0);
      auto work = [&](std::size_t chunk) {
        ended[chunk] = 1;
        if (chunk == 17 || chunk == 18 || chunk == 63) throw std::runtime_error("chunk " + std::to_string(chunk));
      };
      REQUIRE_THROWS_WITH(executor.for_chunks(ended.size(), ChunkFunction(work)), "chunk 17");
      REQUIRE(std::accumulate(ended.begin(), ended.end(), 0) == 64);
    }
    int calls = 0;  // and the executor is still good
    auto count = [&](std::size_t) { ++calls; };
    executor.for_chunks(1, ChunkFunction(count));
    CHECK(calls == 1);
  }
}

TEST_CASE("a call from inside a chunk runs on the chunk's own thread, in order") {
  for (const int threads : kThreads) {
    Executor executor(threads);
    std::vector<int> in_order(16, 0);
    executor.for_ranges(in_order.size(), 1, [&](std::size_t, std::size_t, std::size_t outer) {
      const std::thread::id here = std::this_thread::get_id();
      std::size_t next = 0;
      bool good = true;
      executor.for_ranges(100, 10, [&](std::size_t, std::size_t, std::size_t inner) {
        good = good && inner == next++ && std::this_thread::get_id() == here;
      });
      in_order[outer] = good && next == 10 ? 1 : 0;
    });
    CHECK(in_order == std::vector<int>(16, 1));
  }
}

TEST_CASE("two threads may share an executor") {
  Executor executor(3);
  const std::vector<float> x = awkward_numbers(20'000);
  std::vector<float> here(79), there(79);
  const float expected = ordered_sum(executor, x, 256, here);
  bool same = true;
  std::thread other([&] {
    for (int i = 0; i < 200; ++i) same = same && bits(ordered_sum(executor, x, 256, there)) == bits(expected);
  });
  for (int i = 0; i < 200; ++i) CHECK(bits(ordered_sum(executor, x, 256, here)) == bits(expected));
  other.join();
  CHECK(same);
}

TEST_CASE("a call allocates nothing") {
  const std::vector<float> x = awkward_numbers(10'000);
  std::vector<float> partials(40);
  for (const int threads : kThreads) {
    Executor executor(threads);
    float sum = ordered_sum(executor, x, 256, partials);
    const std::size_t before = allocation_count();
    for (int i = 0; i < 100; ++i) sum += ordered_sum(executor, x, 256, partials);
    const std::size_t after = allocation_count();
    INFO(threads << " threads, sum " << sum);
    CHECK(after == before);
  }
  const std::size_t before = allocation_count();  // the counter does count
  ::operator delete(::operator new(1));
  CHECK(allocation_count() == before + 1);
}

TEST_CASE("fewer than one thread is refused") {
  CHECK_THROWS_WITH(Executor(0), "threads is 0, must be at least 1");
  CHECK_THROWS_AS(Executor(-4), ConfigError);
}
