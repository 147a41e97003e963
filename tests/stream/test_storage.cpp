/// Memory and time of the stream over long recordings.

#include <atomic>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <ctime>
#include <new>

#include "aslio/stream/measurement_stream.hpp"
#include "stream/stream_data.hpp"

namespace {
std::atomic<std::uint64_t> allocations{0};
}

void* operator new(std::size_t size) {
  ++allocations;
  if (void* p = std::malloc(size == 0 ? 1 : size)) return p;
  throw std::bad_alloc();
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  ++allocations;
  return std::malloc(size == 0 ? 1 : size);
}
void operator delete(void* p) noexcept { std::free(p); }
void operator delete(void* p, std::size_t) noexcept { std::free(p); }

using namespace aslio;
using namespace aslio::test;
using stream::MeasurementStream;

namespace {

constexpr int kPointsPerPacket = 22'500;
constexpr TimeNs kPointStep = 4'444;
constexpr TimeNs kSweep = kPointsPerPacket * kPointStep;

double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

struct Usage {
  double push_seconds = 0;
  std::uint64_t allocations = 0;  ///< in push, cut and release
  std::size_t most_points = 0, most_imu = 0;
};

/// Packets of ten sweeps per second, windows of 20 ms, everything older than a sweep released.
Usage run(MeasurementStream& stream, std::uint32_t first, std::uint32_t packets, bool shuffled) {
  Usage usage;
  std::mt19937_64 random(first);
  for (std::uint32_t k = first; k < first + packets; ++k) {
    const TimeNs begin = kEpoch + k * kSweep;
    LidarPacket p = regular_packet(k, begin, kPointStep, kPointsPerPacket);
    if (shuffled)
      for (std::size_t i = p.points.size() - 1; i > 0; --i) std::swap(p.points[i], p.points[random() % (i + 1)]);
    const std::uint64_t before = allocations;
    const double started = cpu_seconds();
    stream.push(std::move(p));
    usage.push_seconds += cpu_seconds() - started;
    for (TimeNs t = begin; t < begin + kSweep; t += 5'000'000) stream.push(imu(t));
    for (TimeNs t = begin; t + 20'000'000 <= begin + kSweep; t += 20'000'000) {
      WindowPlan plan;
      plan.history_begin = plan.fresh_begin = t;
      plan.end = t + 20'000'000;
      REQUIRE(stream.cut(plan, 1).fresh.size() >= 4500);
      stream.release(t - kSweep);
    }
    usage.allocations += allocations - before;
    usage.most_points = std::max(usage.most_points, stream.buffered_points());
    usage.most_imu = std::max(usage.most_imu, stream.buffered_imu());
  }
  return usage;
}

}  // namespace

TEST_CASE("after warm-up nothing is allocated and the buffers stay as small as the windows reach") {
  for (const bool shuffled : {false, true}) {
    MeasurementStream stream;
    run(stream, 0, 10, shuffled);
    const Usage usage = run(stream, 10, 100, shuffled);
    CHECK(usage.allocations == 0);
    CHECK(usage.most_points < 3 * kPointsPerPacket);
    CHECK(usage.most_imu < 3 * 22);
    CHECK(stream.counters().points == 110 * kPointsPerPacket);
  }
}

TEST_CASE("taking in a second of points costs a small part of a second") {
  MeasurementStream stream;
  run(stream, 0, 10, false);
  const double sorted = run(stream, 10, 50, false).push_seconds / 5;
  INFO("225 000 points in order: " << 1e3 * sorted << " ms");
  CHECK(sorted < 0.02);
}
