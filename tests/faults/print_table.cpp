/// docs/faults.md, on stdout.

#include <cstdio>

#include "faults/table.hpp"

int main() {
  const std::string text = aslio::test::faults::to_markdown(aslio::test::faults::all_rows());
  return std::fwrite(text.data(), 1, text.size(), stdout) == text.size() ? 0 : 1;
}
