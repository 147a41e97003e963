// Lists the stages that come with the framework and sums the first thousand numbers on two threads.
#include <iostream>
#include <vector>

#include "aslio/exec/executor.hpp"
#include "aslio/plugin/registry.hpp"
#include "register_all.hpp"

int main() {
  aslio::plugin::Catalog catalog;
  aslio::plugins::register_all(catalog);
  for (const auto& family : catalog.families()) {
    for (const auto& type : catalog.types(family)) std::cout << family << '/' << type << '\n';
  }

  aslio::exec::Executor exec(2);
  std::vector<long> partials(aslio::exec::Executor::chunk_count(1000, 64));
  const long sum = exec.reduce(
      1000, 64, 0L, std::span<long>(partials),
      [](std::size_t begin, std::size_t end) {
        long part = 0;
        for (std::size_t i = begin; i < end; ++i) part += static_cast<long>(i);
        return part;
      },
      [](long& total, long part) { total += part; });
  std::cout << "sum " << sum << '\n';
}
