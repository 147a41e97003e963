#include <catch2/catch.hpp>
#include <set>

#include "aslio/config/description.hpp"
#include "aslio/config/diff.hpp"
#include "aslio/config/load.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/pipeline/odometry.hpp"
#include "aslio/plugin/registry.hpp"
#include "aslio/stages/estimator.hpp"
#include "aslio/stages/insertion.hpp"
#include "aslio/stages/overlap.hpp"
#include "aslio/stages/residual.hpp"
#include "aslio/stages/window.hpp"
#include "register_all.hpp"

using namespace aslio;

namespace {

std::string resolved(const plugin::Catalog& catalog, const std::string& name) {
  const std::string path = std::string(ASLIO_SOURCE_DIR).append("/configs/pipelines/").append(name);
  return config::load<pipeline::PipelineConfig>(path, config::FileKind::pipeline, catalog).resolved;
}

/// A file that holds nothing but one stage.
template <class S>
struct Alone {
  config::Nested<S> stage;
  static void describe(config::Binder& b, Alone& p) { b.stage("stage", p.stage, "the one that is read"); }
};

/// Reads every stage of a family with `value` for each of its numbers, one at a time; returns how many were refused.
template <class S>
std::size_t refusals(const plugin::Catalog& catalog, const std::string& value) {
  std::size_t refused = 0;
  for (const std::string& type : catalog.types(S::family)) {
    for (const config::Field& field : config::describe(catalog, S::family, type).fields) {
      const bool number = field.type.starts_with("number") || field.type.starts_with("integer");
      if (!number || field.path.find('.') != std::string::npos) continue;
      const std::string text =
          "schema: aslio/pipeline/1\nstage: {type: " + type + ", " + field.path + ": " + value + "}\n";
      try {
        config::parse<Alone<S>>(text, "stage.yaml", config::FileKind::pipeline, catalog);
      } catch (const ConfigError&) {
        ++refused;
      }
    }
  }
  return refused;
}

}  // namespace

TEST_CASE("AS-LIO and its baseline differ in the window and history blocks only") {
  plugin::Catalog catalog;
  plugins::register_all(catalog);
  const auto differences = config::diff(resolved(catalog, "as_lio_plus.yaml"), resolved(catalog, "fixed_window.yaml"));
  std::set<std::string> blocks;
  for (const config::Difference& d : differences) blocks.insert(d.path.substr(0, d.path.find('.')));
  CHECK(blocks == std::set<std::string>{"history", "window"});
}

TEST_CASE("The defaults that a shipped pipeline leaves out lie in their own ranges") {
  plugin::Catalog catalog;
  plugins::register_all(catalog);
  const std::string written = resolved(catalog, "as_lio_plus.yaml");
  // Reading the resolved text checks the ranges of every default that the file leaves out.
  CHECK(
      config::parse<pipeline::PipelineConfig>(written, "resolved.yaml", config::FileKind::pipeline, catalog).resolved ==
      written);
}

TEST_CASE("No number of any registered stage is too odd to be refused in words") {
  plugin::Catalog catalog;
  plugins::register_all(catalog);
  for (const char* value : {"0", "-1", "1e-300", "1e300", "-1e300", "9223372036854775807"}) {
    CAPTURE(value);
    std::size_t refused = refusals<WindowStrategy>(catalog, value) + refusals<OverlapMetric>(catalog, value) +
                          refusals<OccupancyStore>(catalog, value) + refusals<HistoryPolicy>(catalog, value) +
                          refusals<Sampler>(catalog, value) + refusals<Map>(catalog, value) +
                          refusals<Insertion>(catalog, value) + refusals<Estimator>(catalog, value) +
                          refusals<MotionModel>(catalog, value) + refusals<Residual>(catalog, value);
    CHECK(refused > 10);
  }
}
