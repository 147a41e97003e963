#include "aslio/pipeline/stage_set.hpp"
#include "fuzz/stages.hpp"
#include "fuzz/yaml.hpp"

ASLIO_FUZZ_TARGET(pipeline) {
  const auto loaded = parsed<pipeline::PipelineConfig>(bytes, config::FileKind::pipeline, all_stages());
  if (loaded) accepts([&] { pipeline::check_stages(*loaded); });
}
