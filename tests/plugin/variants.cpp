// Shared objects with one mistake each; VARIANT says which.
#include <dlfcn.h>
#include <sys/stat.h>

#include <stdexcept>

#include "aslio/plugin/entry.hpp"
#include "config/stages.hpp"

namespace {

[[maybe_unused]] int register_nothing(void*, char*, std::size_t) { return 0; }

[[maybe_unused]] void register_quartz(aslio::plugin::Catalog& catalog) {
  aslio::plugin::Registry<aslio::test::Clock>(catalog).add<aslio::test::Quartz>("quartz", "another one");
}
[[maybe_unused]] void register_and_throw(aslio::plugin::Catalog& catalog) {
  register_quartz(catalog);
  throw std::runtime_error("no licence found");
}
[[maybe_unused]] void register_none(aslio::plugin::Catalog&) {}
[[maybe_unused]] void throw_number(aslio::plugin::Catalog&) { throw 5; }

constexpr auto kMagic = aslio::plugin::kPluginMagic;
constexpr auto kVersion = aslio::plugin::kPluginAbiVersion;
constexpr std::uint32_t kSize = sizeof(AslioPlugin);

}  // namespace

#define ENTRY(magic, version, size, stamp)          \
  extern "C" __attribute__((visibility("default"))) \
  const AslioPlugin aslio_plugin = {magic, version, size, stamp, &register_nothing};

#if defined(WRONG_MAGIC)
ENTRY(kMagic + 1, kVersion, kSize, aslio::plugin::kBuildStamp)
#elif defined(WRONG_VERSION)
ENTRY(kMagic, kVersion + 1, kSize, aslio::plugin::kBuildStamp)
#elif defined(WRONG_SIZE)
ENTRY(kMagic, kVersion, kSize + 8, aslio::plugin::kBuildStamp)
#elif defined(WRONG_STAMP)
ENTRY(kMagic, kVersion, kSize, "framework 0.0.9; c++ 202002")
#elif defined(NO_STAMP)
ENTRY(kMagic, kVersion, kSize, nullptr)
#elif defined(THROWS)
ASLIO_PLUGIN(register_and_throw)
#elif defined(THROWS_NUMBER)
ASLIO_PLUGIN(throw_number)
#elif defined(TAKEN)
ASLIO_PLUGIN(register_quartz)
#elif defined(CHANGES)
ASLIO_PLUGIN(register_none)
namespace {
/// Runs while the object is loaded, and does to its file what another program might do.
__attribute__((constructor)) void change_own_file() {
  Dl_info self{};
  if (dladdr(&aslio_plugin, &self) != 0) chmod(self.dli_fname, 0700);
}
}  // namespace
#elif defined(EMPTY)
ASLIO_PLUGIN(register_none)
#endif
