#include "aslio/experiment/study.hpp"

#include "aslio/experiment/dataset.hpp"
#include "aslio/experiment/family.hpp"
#include "fuzz/stages.hpp"
#include "fuzz/yaml.hpp"

// A study file, with what it may name beside it: files of one input, of which study.yaml is read as a study, and
// dataset.yaml as a dataset and as a family.
ASLIO_FUZZ_TARGET(study) {
  const auto& at = unpacked(
      bytes, {"study.yaml", "pipeline.yaml", "scene.yaml", "dataset.yaml", "sensor.yaml", "truth.tum", "data.bag"});
  const experiment::StudyReading reading{.resolve_scene =
                                             [](const std::filesystem::path&, const std::vector<std::string>& set) {
                                               std::string text;
                                               for (const std::string& assignment : set) text += assignment + "\n";
                                               return experiment::ResolvedScene{text, {}};
                                             },
                                         .seeds = std::nullopt,
                                         .scale = 1};
  accepts([&] {
    const experiment::Study study = experiment::load_study(at / "study.yaml", all_stages(), reading);
    for (const experiment::StudyRun& run : experiment::plan_runs(study, "program")) {
      must(run.folder.find('/') == std::string::npos && !run.folder.empty(), "the folder of a run is one name");
    }
  });
  accepts([&] { (void)experiment::load_dataset(at / "dataset.yaml"); });
  accepts([&] { (void)experiment::load_family(at / "dataset.yaml"); });
}
