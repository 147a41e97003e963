#pragma once

#include <string>

#include "aslio/config/load.hpp"
#include "fuzz/target.hpp"

namespace aslio::fuzz {

/// Reads `bytes` as a file of `kind`; what it resolves to must read back to the same text. Nothing when it is refused.
template <class T>
std::optional<config::Loaded<T>> parsed(Bytes bytes, config::FileKind kind, const config::StageLookup& stages) {
  std::optional<config::Loaded<T>> loaded;
  accepts([&] { loaded = config::parse<T>(text_of(bytes), "input.yaml", kind, stages); });
  if (!loaded) return loaded;
  std::string again;
  const bool same = accepts([&] { again = config::parse<T>(loaded->resolved, "again.yaml", kind, stages).resolved; });
  must(same && again == loaded->resolved, "a resolved configuration reads back to itself");
  return loaded;
}

}  // namespace aslio::fuzz
