#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <utility>

#include "aslio/config/description.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/experiment/dataset.hpp"
#include "aslio/experiment/external_method.hpp"
#include "aslio/experiment/family.hpp"
#include "aslio/experiment/study.hpp"
#include "aslio/io/reference.hpp"
#include "aslio/io/source.hpp"
#include "aslio/pipeline/odometry.hpp"
#include "aslio/simulator/scene.hpp"
#include "command.hpp"
#include "console.hpp"
#include "stages.hpp"

namespace aslio::cli {

namespace {

struct DescribeArguments {
  std::string what;
  std::vector<std::string> plugins;
  bool markdown = false;
};

/// Keys with a heading; that of the first part is the file.
struct Part {
  std::string heading;
  config::Description keys;
};

template <class Config>
std::vector<Part> parts_of() {
  return {{"", config::describe([](config::Binder& binder) {
             Config defaults;
             Config::describe(binder, defaults);
           })}};
}

/// A scene with `motion: drive` has keys that others do not have.
Part drive_part() {
  config::Description keys = config::describe([](config::Binder& binder) {
    simulator::Scene scene;
    scene.motion = simulator::MotionKind::drive;
    simulator::Scene::describe(binder, scene);
  });
  std::erase_if(keys.fields, [](const config::Field& field) {
    return !field.path.starts_with("drive.") && !field.path.starts_with("cars.");
  });
  return {"motion: drive", std::move(keys)};
}

/// The keys of `world` depend on its type: those of each are a part of their own.
std::vector<Part> scene_parts() {
  using simulator::WorldKind;
  std::vector<Part> parts = parts_of<simulator::Scene>();
  auto& all = parts.front().keys.fields;
  const auto depends_on_type = [](const config::Field& field) {
    return field.path.starts_with("world.") && field.path != "world.type";
  };
  all.erase(std::remove_if(all.begin(), all.end(), depends_on_type), all.end());
  parts.push_back(drive_part());
  for (const WorldKind kind : simulator::kWorldKinds) {
    config::Description world = config::describe([kind](config::Binder& binder) {
      simulator::WorldParams params;
      params.type = kind;
      binder.group("world", params, "");
    });
    std::string type;
    for (const config::Field& field : world.fields) {
      if (field.path == "world.type") type = field.default_value;
    }
    std::erase_if(world.fields, [&](const config::Field& field) { return !depends_on_type(field); });
    parts.push_back({fmt::format("world of type {}", type), std::move(world)});
  }
  return parts;
}

struct File {
  std::string_view kind;
  std::vector<Part> (*parts)();
};
constexpr std::array<File, 8> kFiles = {{{"pipeline", parts_of<pipeline::PipelineConfig>},
                                         {"sensor", parts_of<io::SensorConfig>},
                                         {"dataset", parts_of<experiment::DatasetConfig>},
                                         {"family", parts_of<experiment::FamilyConfig>},
                                         {"reference", parts_of<io::ReferenceSpec>},
                                         {"scene", scene_parts},
                                         {"study", parts_of<experiment::StudyConfig>},
                                         {"external", parts_of<experiment::ExternalMethod>}}};

std::string describe_file(const plugin::Catalog& catalog, const File& file, bool markdown) {
  std::string text = markdown
                         ? fmt::format(
                               "# {} file\n\nBegins with `schema: aslio/{}/1`. Every key may be left out unless its "
                               "default or its meaning says `required`.\n\n",
                               file.kind, file.kind)
                         : fmt::format("{} file, begins with `schema: aslio/{}/1`\n", file.kind, file.kind);
  for (const Part& part : file.parts()) {
    if (!part.heading.empty()) text += markdown ? fmt::format("## {}\n\n", part.heading) : "\n" + part.heading + "\n";
    text += markdown ? config::to_markdown(part.keys) : config::to_text(part.keys, catalog);
  }
  while (text.ends_with("\n\n")) text.pop_back();
  return text;
}

int describe(const DescribeArguments& a) {
  const Stages stages = load_stages(a.plugins);
  const auto file = std::find_if(kFiles.begin(), kFiles.end(), [&](const File& f) { return f.kind == a.what; });
  if (file != kFiles.end()) {
    print(describe_file(stages.catalog, *file, a.markdown));
    return kSuccess;
  }
  if (a.markdown && a.what.empty()) {
    print(config::plugin_reference(stages.catalog));
    return kSuccess;
  }
  const std::vector<std::string> families = stages.catalog.families();
  if (!a.markdown && std::find(families.begin(), families.end(), a.what) != families.end()) {
    print(family_text(stages.catalog, a.what));
    print(fmt::format("`aslio describe {}/TYPE` shows the parameters of one\n", a.what));
    return kSuccess;
  }
  const std::size_t slash = a.what.find('/');
  if (a.markdown || slash == std::string::npos) {
    throw ConfigError(fmt::format(
        "'{}' is unknown: name a stage as FAMILY/TYPE (windows/fixed; `aslio list` shows all), a family, a "
        "file ('pipeline', 'sensor', 'dataset', 'family', 'reference', 'scene', 'study' or 'external'), or --markdown "
        "for all stages",
        a.what));
  }
  print(config::describe_stage(stages.catalog, a.what.substr(0, slash), a.what.substr(slash + 1)));
  return kSuccess;
}

}  // namespace

Command add_describe(CLI::App& root) {
  CLI::App* app = root.add_subcommand(
      "describe", "Prints the parameters of a stage, or the keys of a file: unit, range, default, meaning.");
  auto arguments = std::make_shared<DescribeArguments>();
  app->add_option("FAMILY/TYPE", arguments->what,
                  "the stage, a family of stages, or the file: pipeline, sensor, dataset, family, reference, scene, "
                  "study, external");
  app->add_flag("--markdown", arguments->markdown, "as Markdown: the keys of a file, or of all stages");
  add_plugin_option(*app, arguments->plugins);
  app->footer("Example:\n  aslio describe windows/sod_adaptive\n  aslio describe scene");
  return {app, [=] { return describe(*arguments); }};
}

}  // namespace aslio::cli
