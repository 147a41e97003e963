#include "pipeline/allocation_meter.hpp"

#include <atomic>
#include <cstdlib>
#include <new>

// NOLINTBEGIN(bugprone-reserved-identifier): the linker's --wrap prescribes the names
extern "C" void* __real_malloc(std::size_t size);
extern "C" void* __wrap_malloc(std::size_t size);
// NOLINTEND(bugprone-reserved-identifier)

namespace {

std::atomic<bool> armed{false};
std::atomic<std::size_t> count{0};

void note() {
  if (armed.load(std::memory_order_relaxed)) count.fetch_add(1, std::memory_order_relaxed);
}

}  // namespace

void aslio::test::arm_allocation_meter(bool on) { armed.store(on); }
std::size_t aslio::test::allocations_metered() { return count.load(); }

// NOLINTNEXTLINE(bugprone-reserved-identifier): the linker's --wrap prescribes the name
extern "C" void* __wrap_malloc(std::size_t size) {
  note();
  return __real_malloc(size);
}
void* operator new(std::size_t size) {
  note();
  if (void* memory = __real_malloc(size == 0 ? 1 : size)) return memory;
  throw std::bad_alloc();
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  note();
  return __real_malloc(size == 0 ? 1 : size);
}
void operator delete(void* memory, const std::nothrow_t&) noexcept { std::free(memory); }
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
