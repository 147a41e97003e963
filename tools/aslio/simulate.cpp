#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <iterator>
#include <limits>
#include <memory>
#include <system_error>
#include <thread>

#include "aslio/core/errors.hpp"
#include "aslio/io/writers.hpp"
#include "aslio/simulator/mesh_file.hpp"
#include "aslio/simulator/record.hpp"
#include "aslio/simulator/scene.hpp"
#include "aslio/simulator/simulation.hpp"
#include "command.hpp"
#include "console.hpp"
#include "interrupt.hpp"
#include "options.hpp"
#include "progress.hpp"

namespace aslio::cli {

namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

struct SimulateArguments {
  std::string scene, output, sensor, world;
  std::vector<std::string> overrides;
  int threads = static_cast<int>(std::clamp(std::thread::hardware_concurrency(), 1U, 256U));
  std::uint64_t seed = simulator::SimulationOptions{}.seed;
  double scale = 1;
  bool no_compression = false, quiet = false;
};

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

/// What a recording consists of besides its bag.
constexpr std::array<std::string_view, 7> kFiles = {"truth.tum",  "truth.csv",   "overlap.csv", "sensor.yaml",
                                                    "scene.yaml", "preview.svg", "dataset.yaml"};

/// Throws ConfigError when a file of the recording would replace one that is read.
void refuse_to_overwrite_inputs(const simulator::SceneFile& scene, const SimulateArguments& a,
                                const std::string& name) {
  const fs::path folder = a.output;
  const fs::path beside = scene.path.parent_path();
  std::vector<fs::path> inputs = {scene.path};
  for (const std::string& file : {scene.scene.follow.file, scene.scene.world.mesh.file}) {
    if (!file.empty()) inputs.push_back(beside / file);
  }
  std::vector<fs::path> outputs = {folder / (name + ".bag")};
  for (const std::string_view file : kFiles) outputs.push_back(folder / file);
  if (!a.world.empty()) outputs.emplace_back(a.world);
  for (const fs::path& output : outputs) {
    for (const fs::path& input : inputs) {
      std::error_code ignored;
      const bool same = fs::weakly_canonical(output, ignored) == fs::weakly_canonical(input, ignored) ||
                        fs::equivalent(output, input, ignored);
      if (!same) continue;
      throw ConfigError(fmt::format("{}: {} would be overwritten, and the simulation reads it; name another place",
                                    output == a.world ? "--save-world" : "--output", input.string()));
    }
  }
  // Else a slip of the hand replaces another recording's truth, or a file of this one.
  if (!a.world.empty() && fs::path(a.world).extension() != ".ply") {
    throw ConfigError(fmt::format("--save-world {}: is written as PLY; give a name that ends in .ply", a.world));
  }
}

/// Throws ConfigError: nothing has been simulated yet, and another --output is the remedy.
void create_folder(const fs::path& folder) {
  std::error_code error, ignored;
  fs::create_directories(folder, error);
  if (!fs::is_directory(folder, ignored)) {
    throw ConfigError(fmt::format("--output {}: {}; name a folder that exists or can be created", folder.string(),
                                  error ? error.message() : "it is not a folder"));
  }
  try {
    const io::AtomicFile probe(folder / kFiles.back());  // never closed: nothing of it stays
  } catch (const DataError& failure) {
    throw ConfigError(
        fmt::format("--output {}: {}; name a folder that can be written", folder.string(), failure.what()));
  }
}

std::string time_left(double seconds) {
  const auto whole = std::llround(seconds);
  return fmt::format("{}:{:02} left", whole / 60, whole % 60);
}

/// Tells how far the recording is, some ten times a second; false once the user wants to stop.
class Monitor {
 public:
  Monitor(bool quiet, double duration_s) : bar_(quiet, stderr_is_terminal()), duration_s_(duration_s) {}

  bool operator()(double share) {
    const double wall_s = seconds_since(start_);
    if (wall_s - shown_s_ >= 0.1 || share >= 1) {
      shown_s_ = wall_s;
      std::string more = fmt::format("   {:.0f} %", 100 * share);
      if (share > 0 && share < 1) more += "   " + time_left(wall_s / share * (1 - share));
      bar_.show({share * duration_s_, duration_s_, wall_s, std::move(more)});
    }
    return !interrupted();
  }
  void clear() const { bar_.clear(); }

 private:
  ProgressBar bar_;
  double duration_s_;
  Clock::time_point start_ = Clock::now();
  double shown_s_ = -1;
};

std::string recording_report(const simulator::RecordResult& r, const SimulateArguments& a, const std::string& name) {
  std::error_code ignored;
  const double megabytes = 1e-6 * static_cast<double>(fs::file_size(fs::path(a.output) / (name + ".bag"), ignored));
  std::string text = fmt::format("duration     {:.2f} s, path {:.2f} m\n", r.data_s, r.path_length_m);
  const auto out = std::back_inserter(text);
  fmt::format_to(out, "messages     {} of the LiDAR, {} of the IMU\n", r.packets, r.imu_samples);
  fmt::format_to(out, "points       {} of {} rays returned\n", r.points, r.rays);
  if (r.wall_s > 0) {
    fmt::format_to(out, "speed        {:.2f} million rays/s, {:.1f}x real time: {:.1f} s with all files written\n",
                   1e-6 * static_cast<double>(r.rays) / r.wall_s, r.data_s / r.wall_s, r.wall_s);
  }
  fmt::format_to(out, "bag          {}.bag, {:.1f} MB, SHA-256 {}\n", name, megabytes, r.bag_sha256);
  fmt::format_to(out, "output       {}: {}\n", a.output, fmt::join(kFiles, ", "));
  fmt::format_to(out, "run it       aslio run configs/pipelines/as_lio_plus.yaml --dataset {} --output OUT\n",
                 a.output);
  return text;
}

int stopped(const std::string& output) {
  complain(fmt::format("interrupted: {} has no dataset.yaml; its other files are complete", output));
  return kInterrupted;
}

int simulate(const SimulateArguments& a) {
  catch_interrupts();
  const simulator::SceneFile scene = simulator::load_scene(a.scene, a.overrides);
  const std::string name = scene.path.stem().string();
  refuse_to_overwrite_inputs(scene, a, name);
  simulator::SimulationOptions options;
  options.seed = a.seed;
  options.scale = a.scale;
  if (!a.sensor.empty()) options.sensor = simulator::sensor_kind(a.sensor);
  const simulator::Simulation simulation(scene, options);
  if (simulation.follow_error() > 0.05)
    tell(
        fmt::format("warning: follow: the motion is up to {:.3f} m from the poses of {}; a shorter "
                    "follow.knot_interval follows closer",
                    simulation.follow_error(), scene.scene.follow.file));
  create_folder(a.output);
  if (!a.world.empty()) simulator::write_mesh(simulation.caster().mesh(), a.world);
  Monitor monitor(a.quiet, simulation.duration());
  simulator::RecordResult result;
  const bool whole =
      simulator::record(simulation, scene, {a.output, a.threads, !a.no_compression, name}, std::ref(monitor), result);
  monitor.clear();
  if (!whole) return stopped(a.output);
  if (!a.quiet) print(recording_report(result, a, name));
  return kSuccess;
}

std::vector<std::string> sensor_names() {
  using simulator::SensorKind;
  std::vector<std::string> names;
  for (const SensorKind kind :
       {SensorKind::avia, SensorKind::mid360, SensorKind::spin16, SensorKind::spin32, SensorKind::spin64}) {
    names.emplace_back(simulator::facts(kind).name);
  }
  return names;
}

void add_simulate_options(CLI::App& app, SimulateArguments& a) {
  app.add_option("SCENE", a.scene, "scene file (schema: aslio/scene/1)")->required()->check(CLI::ExistingFile);
  app.add_option("--output", a.output, "folder for the recording; files of an earlier one are replaced")->required();
  app.add_option("--seed", a.seed, "of noise, biases, people, turn times and gait; the world has a seed of its own")
      ->check(whole_number(0, std::numeric_limits<std::uint64_t>::max()))
      ->capture_default_str();
  app.add_option("--sensor", a.sensor, fmt::format("in place of the scene's: {}", fmt::join(sensor_names(), ", ")))
      ->check(one_of("sensor", sensor_names()));
  app.add_option("--scale", a.scale, "scales route and world; the loop stays closed")
      ->check(number(simulator::kMinScale, simulator::kMaxScale))
      ->capture_default_str();
  app.add_option("--threads", a.threads, "threads; the files are the same for any number")
      ->check(whole_number(1, 256))
      ->capture_default_str();
  app.add_option("--set", a.overrides, "key.path=value (YAML); changes the scene, may be repeated")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  app.add_option("--save-world", a.world, "PLY file for the surfaces of the world, without people")->type_name("FILE");
  app.add_flag("--no-compression", a.no_compression, "bag without lz4");
  app.add_flag("--quiet", a.quiet, "no progress and no report; warnings and errors remain");
}

}  // namespace

Command add_simulate(CLI::App& root) {
  CLI::App* app = root.add_subcommand("simulate", "Simulates a recording with known truth from a scene file.");
  auto arguments = std::make_shared<SimulateArguments>();
  add_simulate_options(*app, *arguments);
  app->footer(
      "Writes <scene>.bag, truth.tum, truth.csv, overlap.csv, sensor.yaml, scene.yaml, preview.svg and, last, "
      "dataset.yaml, which `aslio run --dataset` takes.\n\n"
      "Example:\n"
      "  aslio simulate configs/scenes/indoor_1.yaml --output out/indoor_1 --seed 7 --set people.walking=0");
  return {app, [=] { return simulate(*arguments); }};
}

}  // namespace aslio::cli
