#include "manifest.hpp"

#include <fmt/format.h>
#include <spdlog/version.h>

#include <Eigen/Core>
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

}  // namespace

std::string to_json(const Manifest& manifest, const RunOptions& options) {
  Json plugins = Json::array();
  for (const PluginFile& plugin : options.plugins) plugins.push_back(file(plugin.path, plugin.sha256));
  Json input = file(options.input, manifest.input_sha256);
  input["hash_s"] = manifest.input_hash_s;
  input["start_s"] = options.section.start;
  input["duration_s"] = options.section.duration ? Json(*options.section.duration) : Json(nullptr);
  Json sensor = file(options.sensor, manifest.sensor_sha256);
  sensor["resolved"] = manifest.sensor_resolved;
  const Json out = {{"aslio", version()},
                    {"command_line", options.command_line},
                    {"pipeline", file(options.pipeline, manifest.pipeline_sha256)},
                    {"overrides", options.overrides},
                    {"stages", manifest.stages},
                    {"plugins", plugins},
                    {"sensor", sensor},
                    {"input", input},
                    {"dataset", options.dataset ? Json(options.dataset->string()) : Json(nullptr)},
                    {"seeds", {{"order", options.order_seed}}},
                    {"threads", options.threads},
                    {"build", build()},
                    {"libraries", libraries()},
                    {"cpu", cpu_model()}};
  return out.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace aslio::experiment
