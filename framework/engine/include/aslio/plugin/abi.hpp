#pragma once
/// What a shared object and the program must agree on before a C++ object may pass between them.
///
/// A plugin exports one C structure. The program reads its first three fields, whose places never change, then the
/// build stamp, and calls `register_types` only when all of it matches its own.

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "aslio/config/binder.hpp"
#include "aslio/plugin/registry.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/stages/estimator.hpp"
#include "aslio/stages/insertion.hpp"
#include "aslio/stages/overlap.hpp"

namespace aslio::plugin {

inline constexpr std::uint64_t kPluginMagic = 0x4e494755'4c50'4c41;  // "ALPLUGIN", little endian
/// Counts changes of the stage interfaces and of anything else that the stamp does not see.
inline constexpr std::uint32_t kPluginAbiVersion = 13;
inline constexpr std::string_view kFrameworkVersion = "0.2.0";
inline constexpr const char* kPluginSymbol = "aslio_plugin";

namespace detail {

/// Text built by the compiler.
struct Stamp {
  std::array<char, 1024> text{};
  std::size_t size = 0;

  constexpr void put(std::string_view part) {
    for (const char c : part) text.at(size++) = c;
  }
  constexpr void put_number(std::size_t value) {
    std::array<char, 20> digits{};
    std::size_t n = 0;
    do {
      digits.at(n++) = static_cast<char>('0' + value % 10);
      value /= 10;
    } while (value > 0);
    while (n > 0) text.at(size++) = digits.at(--n);
  }
  constexpr void item(std::string_view name, std::size_t value) {
    put("; ");
    put(name);
    put(" ");
    put_number(value);
  }
  template <class T>
  constexpr void layout(std::string_view name) {
    item(name, sizeof(T));
    put("/");
    put_number(alignof(T));
  }
};

constexpr Stamp make_stamp() {
  Stamp s;
  s.put("framework ");
  s.put(kFrameworkVersion);
  s.item("c++", __cplusplus);
#ifdef __clang__
  s.item("clang", __clang_major__);
#else
  s.item("gcc", __GNUC__);
#endif
  s.item("compiler abi", __GXX_ABI_VERSION);
  s.item("libstdc++", _GLIBCXX_RELEASE);
  s.item("_GLIBCXX_USE_CXX11_ABI", _GLIBCXX_USE_CXX11_ABI);
#ifdef _GLIBCXX_DEBUG
  s.item("_GLIBCXX_DEBUG", 1);
#endif
  s.item("eigen", EIGEN_WORLD_VERSION * 10000 + EIGEN_MAJOR_VERSION * 100 + EIGEN_MINOR_VERSION);
  s.item("eigen max align", EIGEN_MAX_ALIGN_BYTES);
  s.layout<std::string>("string");
  s.layout<Eigen::Vector4d>("Vector4d");
  s.layout<Eigen::Matrix4f>("Matrix4f");
  s.layout<Pose>("Pose");
  s.layout<ImuSample>("ImuSample");
  s.layout<TimedPoint>("TimedPoint");
  s.layout<NavState>("NavState");
  s.layout<SensorModel>("SensorModel");
  s.layout<BuildContext>("BuildContext");
  s.layout<Catalog>("Catalog");
  s.layout<Entry>("Entry");
  s.layout<config::StageRecipe>("StageRecipe");
  s.layout<config::Range>("Range");
  s.layout<Feedback>("Feedback");
  s.layout<WindowPlan>("WindowPlan");
  s.layout<Window>("Window");
  s.layout<Update>("Update");
  s.layout<WorldPoint>("WorldPoint");
  s.layout<MapQuery>("MapQuery");
  return s;
}

inline constexpr Stamp kStamp = make_stamp();

}  // namespace detail

/// Compiler, libraries and layouts this translation unit was built with, as "name value; name value; ..".
inline constexpr const char* kBuildStamp = detail::kStamp.text.data();

}  // namespace aslio::plugin

extern "C" {

/// What a shared object exports under the name `aslio_plugin`.
struct AslioPlugin {
  std::uint64_t magic;        ///< kPluginMagic
  std::uint32_t abi_version;  ///< kPluginAbiVersion
  std::uint32_t size;         ///< sizeof(AslioPlugin)
  const char* build_stamp;    ///< kBuildStamp
  /// Adds types to a Catalog. Not 0: it failed, and `message` (of `capacity` bytes) says why. Lets no exception out.
  int (*register_types)(void* catalog, char* message, std::size_t capacity);
};
}
