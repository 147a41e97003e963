#pragma once
/// A fuzz target feeds a reader with bytes: it must end soon, in little memory, without a crash, whatever the bytes
/// are. Under libFuzzer (preset `fuzz`) each target is a program; in the tests one program replays their corpora.

#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <span>
#include <string_view>

#include "aslio/core/errors.hpp"

namespace aslio::fuzz {

using Bytes = std::span<const std::uint8_t>;

inline std::string_view text_of(Bytes bytes) { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }

/// A property that holds for any bytes: prints `what` and aborts where it does not.
void must(bool holds, std::string_view what);

/// Runs `action`; false when it refuses its input as a reader may, by ConfigError or DataError. Any other exception is
/// a finding.
template <class Action>
bool accepts(Action&& action) {
  try {
    action();
    return true;
  } catch (const ConfigError& error) {
    must(*error.what() != '\0', "a refusal says why");
  } catch (const DataError& error) {
    must(*error.what() != '\0', "a refusal says why");
  }
  return false;
}

/// Folder of this process, in memory where there is a place for it; removed at its end.
const std::filesystem::path& folder();

/// Path of a file of that name in folder() that holds `bytes`.
std::filesystem::path written(std::string_view name, Bytes bytes);

/// Files of one input: a line `=== NAME` comes before the content of each; those of other names than `names` are left
/// out. Removes what the call before has written. Returns folder().
const std::filesystem::path& unpacked(Bytes bytes, std::initializer_list<std::string_view> names);

}  // namespace aslio::fuzz

#ifdef ASLIO_LIBFUZZER
// The names are libFuzzer's.
#define ASLIO_FUZZ_TARGET(name)                                                       \
  namespace aslio::fuzz {                                                             \
  void fuzz_##name(Bytes bytes);                                                      \
  }                                                                                   \
  extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) { \
    aslio::fuzz::fuzz_##name({data, size});                                           \
    return 0;                                                                         \
  }                                                                                   \
  void aslio::fuzz::fuzz_##name(Bytes bytes)
#else
#define ASLIO_FUZZ_TARGET(name)  \
  namespace aslio::fuzz {        \
  void fuzz_##name(Bytes bytes); \
  }                              \
  void aslio::fuzz::fuzz_##name(Bytes bytes)
#endif
