#pragma once
/// Any registered stage, built as a configuration would.

#include <memory>
#include <string>

#include "aslio/config/load.hpp"
#include "aslio/plugin/registry.hpp"
#include "aslio/stages/build_context.hpp"

namespace aslio::test {

/// A file of one stage.
template <class S>
struct OneStage {
  config::Nested<S> stage;
  static void describe(config::Binder& b, OneStage& p) { b.stage("stage", p.stage, "the stage under test"); }
};

/// The stage of the YAML value `text`: "voxel_hash" or "{type: voxel_hash, voxel: 0.5}". `catalog` outlives it.
template <class S>
std::unique_ptr<S> make_stage(const plugin::Catalog& catalog, const std::string& text, const BuildContext& context) {
  return config::parse<OneStage<S>>("schema: aslio/pipeline/1\nstage: " + text + "\n", "test.yaml",
                                    config::FileKind::pipeline, catalog)
      .value.stage.make(context);
}

}  // namespace aslio::test
