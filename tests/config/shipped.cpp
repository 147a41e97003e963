#include <catch2/catch.hpp>
#include <set>

#include "aslio/config/diff.hpp"
#include "aslio/config/load.hpp"
#include "aslio/pipeline/odometry.hpp"
#include "aslio/plugin/registry.hpp"
#include "register_all.hpp"

using namespace aslio;

namespace {

std::string resolved(const plugin::Catalog& catalog, const std::string& name) {
  const std::string path = std::string(ASLIO_SOURCE_DIR).append("/configs/pipelines/").append(name);
  return config::load<pipeline::PipelineConfig>(path, config::FileKind::pipeline, catalog).resolved;
}

}  // namespace

TEST_CASE("AS-LIO and its baseline differ in the window and history blocks only") {
  plugin::Catalog catalog;
  plugins::register_all(catalog);
  const auto differences = config::diff(resolved(catalog, "as_lio.yaml"), resolved(catalog, "fixed_window.yaml"));
  std::set<std::string> blocks;
  for (const config::Difference& d : differences) blocks.insert(d.path.substr(0, d.path.find('.')));
  CHECK(blocks == std::set<std::string>{"history", "window"});
}

TEST_CASE("The defaults that a shipped pipeline leaves out lie in their own ranges") {
  plugin::Catalog catalog;
  plugins::register_all(catalog);
  const std::string written = resolved(catalog, "as_lio.yaml");
  // Reading the resolved text checks the ranges of every default that the file leaves out.
  CHECK(
      config::parse<pipeline::PipelineConfig>(written, "resolved.yaml", config::FileKind::pipeline, catalog).resolved ==
      written);
}
