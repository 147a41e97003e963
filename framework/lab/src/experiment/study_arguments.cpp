#include "study_arguments.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "run_outputs.hpp"

namespace aslio::experiment {

namespace fs = std::filesystem;

bool asks_for(const Study& study, std::string_view output) {
  const auto& outputs = study.config.outputs;
  return std::find(outputs.begin(), outputs.end(), output) != outputs.end();
}

std::vector<std::string> run_arguments(const Study& study, const std::vector<StudyRun>& runs, std::size_t i,
                                       const RunPlaces& places, const std::vector<std::string>& more) {
  const StudyRun& run = runs[i];
  const StudyMethod& method = study.methods[run.method];
  const StudyData& data = study.data[run.data];
  const fs::path& folder = places.folder;
  std::vector<std::string> arguments = {
      "run",    method.pipeline.string(),       "--dataset", places.dataset.string(), "--output", folder.string(),
      "--seed", fmt::to_string(run.order_seed), "--quiet"};
  if (!data.folder.empty()) arguments.insert(arguments.end(), {"--data", data.folder.string()});
  if (method.external) {
    const fs::path file = folder / "method.yaml";
    write_file(file, method.resolved);
    arguments[0] = "external";
    arguments[1] = file.string();
    arguments.insert(arguments.end(), {"--name", data.name, "--sequence", data.sequence});
    return arguments;
  }
  for (const std::string& assignment : overrides_of(study, runs, run, places.runs_folder)) {
    arguments.insert(arguments.end(), {"--set", assignment});
  }
  if (study.config.stop_when_diverged) arguments.emplace_back("--stop-when-diverged");
  if (asks_for(study, "dense")) arguments.emplace_back("--dense");
  if (asks_for(study, "map")) arguments.insert(arguments.end(), {"--save-map", (folder / "map.ply").string()});
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

void name_finally(std::string& text, const fs::path& folder, const fs::path& final) {
  const std::size_t at = text.find(folder.string());
  if (at != std::string::npos) text.replace(at, folder.string().size(), final.string());
}

}  // namespace aslio::experiment
