#include "manifest.hpp"

#include <fmt/format.h>
#include <spdlog/version.h>

#include <Eigen/Core>
#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "aslio/experiment/version.hpp"

namespace aslio::experiment {

namespace {

using Json = nlohmann::ordered_json;

std::string cpu_model() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    if (line.starts_with("model name")) return line.substr(std::min(line.find(':') + 2, line.size()));
  }
  return "unknown";
}

Json build() {
  return {{"revision", source_revision()},
          {"compiler", ASLIO_COMPILER_TEXT},
          {"flags", ASLIO_FLAGS_TEXT},
          {"build_type", ASLIO_BUILD_TYPE},
          {"exec_backend", ASLIO_EXEC_TEXT}};
}

Json libraries() {
  return {{"eigen", fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)},
          {"yaml-cpp", ASLIO_YAML_VERSION},
          {"fmt", fmt::format("{}.{}.{}", FMT_VERSION / 10000, FMT_VERSION / 100 % 100, FMT_VERSION % 100)},
          {"spdlog", fmt::format("{}.{}.{}", SPDLOG_VER_MAJOR, SPDLOG_VER_MINOR, SPDLOG_VER_PATCH)}};
}

Json file(const std::filesystem::path& path, const std::string& sha256) {
  return {{"path", path.string()}, {"sha256", sha256}};
}

/// The published sequence that the input is, and whose extrinsic the run took.
Json published(const std::optional<PublishedSequence>& sequence) {
  if (!sequence) return nullptr;
  return {{"family", sequence->family},
          {"sequence", sequence->sequence},
          {"data", sequence->data.string()},
          {"extrinsic_source", sequence->extrinsic_source}};
}

/// All that makes the data of a study what they are; simulated data are gone when they have served.
Json data_of(const StudyData& data) {
  Json json = {{"name", data.name}, {"identity", data.identity}};
  if (data.scene.empty()) {
    json["dataset"] = data.dataset.string();
    if (!data.folder.empty()) json["data"] = data.folder.string();
    return json;
  }
  json["scene"] = data.scene.string();
  json["seed"] = data.seed ? Json(*data.seed) : Json(nullptr);
  json["scale"] = data.scale;
  json["set"] = data.set;
  return json;
}

}  // namespace

std::array<double, 3> machine_load() {
  std::array<double, 3> load{};
  const int known = ::getloadavg(load.data(), 3);
  for (int i = std::max(known, 0); i < 3; ++i) load[static_cast<std::size_t>(i)] = -1;
  return load;
}

std::string study_manifest(const std::string& text, const StudyData& data, const std::vector<std::string>& command,
                           const std::string& program) {
  Json json = Json::parse(text, nullptr, false);
  if (!json.is_object()) {
    json = {{"aslio", version()}, {"build", build()},   {"libraries", libraries()},
            {"cpu", cpu_model()}, {"program", program}, {"load_average", machine_load()}};
  }
  json["command_line"] = command;
  json["data"] = data_of(data);
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string to_json(const Manifest& manifest, const RunOptions& options) {
  Json plugins = Json::array();
  for (const PluginFile& plugin : options.plugins) plugins.push_back(file(plugin.path, plugin.sha256));
  Json input = file(options.input, manifest.input_sha256);
  for (const auto& more : options.more_inputs) input["more"].push_back(more.string());
  input["hash_s"] = manifest.input_hash_s;
  input["start_s"] = options.section.start;
  input["duration_s"] = options.section.duration ? Json(*options.section.duration) : Json(nullptr);
  Json sensor = file(options.sensor, manifest.sensor_sha256);
  sensor["resolved"] = manifest.sensor_resolved;
  // Absolute: the report of a run, which is made from anywhere, draws its error.
  Json reference = nullptr;
  if (options.reference) {
    reference = file(std::filesystem::absolute(options.reference->file), manifest.reference_sha256);
    reference["resolved"] = manifest.reference_resolved;
  }
  const Json out = {{"aslio", version()},
                    {"command_line", options.command_line},
                    {"pipeline", file(options.pipeline, manifest.pipeline_sha256)},
                    {"overrides", options.overrides},
                    {"stages", manifest.stages},
                    {"plugins", plugins},
                    {"sensor", sensor},
                    {"input", input},
                    {"dataset", options.dataset ? Json(options.dataset->string()) : Json(nullptr)},
                    {"published", published(options.published)},
                    {"reference", reference},
                    {"seeds", {{"order", options.order_seed}}},
                    {"threads", options.threads},
                    {"program", manifest.program_sha256},
                    {"build", build()},
                    {"libraries", libraries()},
                    {"cpu", cpu_model()},
                    {"load_average", manifest.load_average}};
  return out.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace aslio::experiment
