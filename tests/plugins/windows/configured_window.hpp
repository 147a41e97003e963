#pragma once
/// Windows as a pipeline file names them.

#include <memory>
#include <string>
#include <vector>

#include "aslio/config/load.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/plugin/registry.hpp"
#include "aslio/stages/window.hpp"
#include "plugins/build_environment.hpp"
#include "plugins/under_test.hpp"
#include "plugins/windows/fake_stream.hpp"

namespace aslio::test {

/// A pipeline file that holds nothing but a window.
struct WindowBlock {
  config::Nested<WindowStrategy> window;
  static void describe(config::Binder& b, WindowBlock& p) { b.stage("window", p.window, "when to update"); }
};

class WindowCatalog {
 public:
  WindowCatalog() : catalog_(stages_under_test()) {}

  /// As the key `window` names them.
  std::vector<std::string> all() const { return under_test(catalog_, WindowStrategy::family); }
  /// From the value of the key `window`, such as "{type: fixed, period: 0.05}". Throws ConfigError.
  config::Nested<WindowStrategy> read(const std::string& value) const {
    const std::string text = "schema: aslio/pipeline/1\nwindow: " + value + "\n";
    return config::parse<WindowBlock>(text, "window.yaml", config::FileKind::pipeline, catalog_).value.window;
  }
  /// What is wrong with it; empty when nothing is.
  std::string complaint(const std::string& value) const {
    try {
      read(value);
    } catch (const ConfigError& error) {
      return error.what();
    }
    return {};
  }

 private:
  plugin::Catalog catalog_;
};

/// All windows of a stream that has arrived and ended.
inline std::vector<WindowPlan> plans_of(const std::string& value, FakeStream stream, TimeNs start = 0) {
  BuildEnvironment environment;
  const auto strategy = WindowCatalog().read(value).make(environment.context());
  FakeProbe probe = blind_probe();
  WindowLoop loop(*strategy, probe, start, [](const WindowPlan&) { return std::optional<double>(); });
  stream.finish();
  loop.run(stream);
  return loop.plans;
}

}  // namespace aslio::test
