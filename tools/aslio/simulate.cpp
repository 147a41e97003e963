#include "simulate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <iterator>
#include <limits>
#include <memory>
#include <optional>
#include <system_error>

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
#include "stand_in.hpp"

namespace aslio::cli {

namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

const std::vector<std::string> kFormats = {"bag", "db3", "mcap"};

simulator::RecordFormat format_of(const std::string& name) {
  if (name == "mcap") return simulator::RecordFormat::mcap;
  return name == "db3" ? simulator::RecordFormat::db3 : simulator::RecordFormat::bag;
}

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
  std::vector<fs::path> outputs = {folder / (name + ".bag"), folder / (name + ".mcap")};
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

/// Of a file, or of the files in a folder.
std::uintmax_t bytes_of(const fs::path& path) {
  std::error_code ignored;
  if (!fs::is_directory(path, ignored)) return fs::file_size(path, ignored);
  std::uintmax_t sum = 0;
  for (const auto& entry : fs::directory_iterator(path, ignored)) sum += entry.file_size(ignored);
  return sum;
}

std::string recording_report(const simulator::RecordResult& r, const SimulateArguments& a) {
  std::string text = fmt::format("duration     {:.2f} s, path {:.2f} m\n", r.data_s, r.path_length_m);
  const auto out = std::back_inserter(text);
  fmt::format_to(out, "messages     {} of the LiDAR, {} of the IMU\n", r.packets, r.imu_samples);
  fmt::format_to(out, "points       {} of {} rays returned\n", r.points, r.rays);
  if (r.wall_s > 0) {
    fmt::format_to(out, "speed        {:.2f} million rays/s, {:.1f}x real time: {:.1f} s with all files written\n",
                   1e-6 * static_cast<double>(r.rays) / r.wall_s, r.data_s / r.wall_s, r.wall_s);
  }
  fmt::format_to(out, "{:12} {}, {:.1f} MB, SHA-256 {}\n", a.format == "bag" ? "bag" : "recording", r.input,
                 1e-6 * static_cast<double>(bytes_of(fs::path(a.output) / r.input)), r.bag_sha256);
  fmt::format_to(out, "output       {}: {}\n", a.output, fmt::join(kFiles, ", "));
  fmt::format_to(out, "run it       aslio run configs/pipelines/as_lio_plus.yaml --dataset {} --output OUT\n",
                 a.output);
  return text;
}

int stopped(const std::string& output) {
  complain(fmt::format("interrupted: {} has no dataset.yaml; its other files are complete", output));
  return kInterrupted;
}

simulator::SimulationOptions options_of(const SimulateArguments& a) {
  simulator::SimulationOptions options;
  options.seed = a.seed;
  options.scale = a.scale;
  options.duration = a.duration;
  if (!a.sensor.empty()) options.sensor = simulator::sensor_kind(a.sensor);
  return options;
}

/// What a stand-in has of the user's options.
simulator::RecordOptions record_options(const SimulateArguments& a, const std::string& name,
                                        const std::optional<StandInPlan>& plan) {
  simulator::RecordOptions options{a.output, a.threads, !a.no_compression, name, format_of(a.format), a.parts};
  if (plan) {
    options.folder = plan->beside;
    options.name = plan->sequence;
    options.layout = plan->layout;
  }
  return options;
}

int simulate(const SimulateArguments& a) {
  catch_interrupts();
  std::optional<StandInPlan> plan;
  if (!a.as.empty()) plan = plan_stand_in(a);
  std::vector<std::string> overrides = plan ? plan->overrides : std::vector<std::string>{};
  overrides.insert(overrides.end(), a.overrides.begin(), a.overrides.end());
  const simulator::SceneFile scene = simulator::load_scene(a.scene, overrides);
  const std::string name = scene.path.stem().string();
  refuse_to_overwrite_inputs(scene, a, name);
  const simulator::Simulation simulation(scene, plan ? plan->simulation : options_of(a));
  if (simulation.follow_error() > 0.05)
    tell(
        fmt::format("warning: follow: the motion is up to {:.3f} m from the poses of {}; a shorter "
                    "follow.knot_interval follows closer",
                    simulation.follow_error(), scene.scene.follow.file));
  create_folder(a.output);
  if (plan) write_stand_in_note(*plan, simulation, a.output);
  if (!a.world.empty()) simulator::write_mesh(simulation.caster().mesh(), a.world);
  Monitor monitor(a.quiet, simulation.duration());
  simulator::RecordResult result;
  const bool whole = simulator::record(simulation, scene, record_options(a, name, plan), std::ref(monitor), result);
  monitor.clear();
  if (!whole) return stopped(a.output);
  if (plan) {
    print(stand_in_report(*plan, simulation, result, a.output));  // also where it is to be quiet: nobody should miss it
  } else if (!a.quiet) {
    print(recording_report(result, a));
  }
  return kSuccess;
}

std::vector<std::string> sensor_names() {
  std::vector<std::string> names;
  for (const simulator::SensorKind kind : simulator::kSensorKinds) {
    names.emplace_back(simulator::facts(kind).name);
  }
  return names;
}

void add_simulate_options(CLI::App& app, SimulateArguments& a) {
  app.add_option("SCENE", a.scene, "scene file (schema: aslio/scene/1)")->required()->transform(shipped_file("scenes"));
  app.add_option("--output", a.output, "folder for the recording; files of an earlier one are replaced")->required();
  app.add_option("--seed", a.seed, "of noise, biases, people, turn times and gait; the world has a seed of its own")
      ->check(whole_number(0, std::numeric_limits<std::uint64_t>::max()))
      ->capture_default_str();
  app.add_option("--sensor", a.sensor, fmt::format("in place of the scene's: {}", fmt::join(sensor_names(), ", ")))
      ->check(one_of("sensor", sensor_names()));
  app.add_option("--scale", a.scale, "scales route and world; the loop stays closed")
      ->check(number(simulator::kMinScale, simulator::kMaxScale))
      ->capture_default_str();
  app.add_option("--duration", a.duration,
                 "at most so many seconds from the start of the motion; the loop is then open")
      ->check(number(0.1, 1e5));
  auto* as =
      app.add_option("--as", a.as,
                     "writes a stand-in of a published sequence, simulated, with its file names, formats, topics, "
                     "units, stamps and frames; a minute of it unless --duration says otherwise")
          ->type_name("FAMILY/SEQUENCE");
  app.add_option("--format", a.format,
                 "of the recording: a ROS1 bag, a rosbag2 database in a folder, or an MCAP file of ROS2 messages")
      ->check(one_of("format", kFormats))
      ->excludes(as)
      ->capture_default_str();
  app.add_option("--parts", a.parts, "files of equal time, in a folder of their own")
      ->check(whole_number(1, 1000))
      ->excludes(as)
      ->capture_default_str();
  app.add_option("--threads", a.threads, "threads; the files are the same for any number")
      ->check(whole_number(1, 256))
      ->capture_default_str();
  app.add_option("--set", a.overrides, "key.path=value (YAML); changes the scene, may be repeated")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  app.add_option("--save-world", a.world, "PLY file for the surfaces of the world, without people")->type_name("FILE");
  app.add_flag("--no-compression", a.no_compression, "bag without lz4, MCAP without zstd");
  app.add_flag("--quiet", a.quiet, "no progress and no report; warnings and errors remain");
}

}  // namespace

Command add_simulate(CLI::App& root) {
  CLI::App* app = root.add_subcommand("simulate", "Simulates a recording with known truth from a scene file.");
  auto arguments = std::make_shared<SimulateArguments>();
  add_simulate_options(*app, *arguments);
  app->footer(
      "Writes <scene>.bag (or .mcap, or a folder <scene>), truth.tum, truth.csv, overlap.csv, sensor.yaml, scene.yaml, "
      "preview.svg and, last, "
      "dataset.yaml, which `aslio run --dataset` takes.\n\n"
      "Example:\n"
      "  aslio simulate configs/scenes/indoor_1.yaml --output out/indoor_1 --seed 7 --set people.walking=0\n"
      "  aslio simulate configs/scenes/outdoor_1.yaml --as newer_college_2021/quad_easy --output "
      "out/newer_college_2021");
  return {app, [=] { return simulate(*arguments); }};
}

}  // namespace aslio::cli
