// The keys of a method that is not of this program, and what its words stand for.
#include "aslio/experiment/external_method.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <system_error>
#include <utility>

#include "aslio/config/binder.hpp"
#include "aslio/config/file_text.hpp"
#include "aslio/config/load.hpp"
#include "aslio/config/names.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/io/layout_writer.hpp"
#include "aslio/plugin/registry.hpp"

namespace aslio::experiment {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view kBag = "{bag}";
constexpr std::string_view kTimes = "times=";

bool is_name(std::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(),
                                      [](unsigned char c) { return std::isalnum(c) != 0 || c == '_' || c == ':'; });
}

/// A topic that is asked for and not known.
void require_topic(const std::string& text, std::string_view name, const std::string& topic) {
  if (!topic.empty() || text.find(fmt::format("{{{}}}", name)) == std::string::npos) return;
  throw ConfigError(
      fmt::format("{{{0}}}: the sensor file names no {0}: name it there, or let the method have `input: bag`", name));
}

bool whole(const std::vector<double>& values) {
  return std::all_of(values.begin(), values.end(), [](double v) { return v == std::floor(v); });
}

/// The file that a shell would start.
fs::path program_file(const std::string& name) {
  if (name.find('/') != std::string::npos) return name;
  const char* paths = std::getenv("PATH");
  std::string_view left = paths == nullptr ? "" : paths;
  while (!left.empty()) {
    const std::size_t end = std::min(left.find(':'), left.size());
    const fs::path file = fs::path(left.substr(0, end)) / name;
    std::error_code ignored;
    if (::access(file.c_str(), X_OK) == 0 && fs::is_regular_file(file, ignored)) return file;
    left.remove_prefix(std::min(end + 1, left.size()));
  }
  return {};
}

void describe_trajectory(config::Binder& b, ExternalMethod& method) {
  b.text("trajectory", method.trajectory,
         "file with the poses: of a command, in its output folder; without a command a finished one, relative to the "
         "folder of this file, as in theirs/{data}.tum");
  io::describe_format(b, method.format, "of the poses; auto: by the content");
  b.text("frame", method.frame,
         "whose poses they are: imu, lidar, or a frame of the sensor file's transforms; their world may be any");
  b.texts("trajectory_set", method.trajectory_set, {},
          "key=value of the file of poses, as of a reference: `columns=[..]`, `times=..`, `topic=/Odometry`");
}

void describe_container(config::Binder& b, ExternalMethod& method) {
  b.text(
      "engine", method.engine,
      "container in which the command runs: docker or apptainer; empty: none. The folders of the run and of its data "
      "have the same paths inside");
  b.text("image", method.image, "image of the container");
  b.texts("engine_options", method.engine_options, {}, "further words for the engine, as in [--network, none]");
  b.require(method.engine.empty() || method.engine == "docker" || method.engine == "apptainer", "engine",
            "must be docker, apptainer or empty");
  b.require(method.engine.empty() == method.image.empty(), "image", "and `engine` go together: give both or neither");
  b.require(method.engine.empty() || !method.command.empty(), "engine", "goes with `command`");
}

}  // namespace

const std::vector<std::string>& external_places() {
  static const std::vector<std::string> names = {"bag",  "imu_topic", "lidar_topic", "output", "sensor",
                                                 "data", "sequence",  "seed",        "here"};
  return names;
}

const std::vector<std::string>& files_of_a_run() {
  static const std::vector<std::string> names = {"summary.json",  "trajectory.tum", "trajectory_lidar.tum",
                                                 "manifest.json", "resolved.yaml",  "program.log",
                                                 "method.yaml",   "log.txt",        "run_key.json"};
  return names;
}

void ExternalMethod::describe_keys(config::Binder& b, ExternalMethod& method) {
  b.texts(
      "command", method.command, {},
      fmt::format("words of a program that is run in place of a pipeline; {{{}}} are replaced; {{here}} is the folder "
                  "of this file",
                  fmt::join(external_places(), "}, {")));
  describe_trajectory(b, method);
  b.choice(
      "input", method.input,
      {{"as_is", ExternalInput::as_is},
       {"bag", ExternalInput::bag},
       {"db3", ExternalInput::db3},
       {"mcap", ExternalInput::mcap},
       {"folder", ExternalInput::folder}},
      "what {bag} is: the recording as it is, or written again as a ROS1 bag, rosbag2 database, MCAP file, or folder "
      "of PCD files with imu.csv");
  b.choice("points", method.points,
           {{"auto", ExternalPoints::automatic},
            {"velodyne", ExternalPoints::velodyne},
            {"ouster", ExternalPoints::ouster},
            {"hesai", ExternalPoints::hesai},
            {"livox_cloud", ExternalPoints::livox_cloud},
            {"livox", ExternalPoints::livox},
            {"livox2", ExternalPoints::livox2}},
           "fields or message of the points in a bag, db3 or mcap that is written; auto: of the driver of Livox where "
           "the recording has its message, else of velodyne_pointcloud");
  describe_container(b, method);
  b.reals("exit_codes", method.exit_codes, 0, "", {.min = 0.0, .max = 255.0},
          "with which the program has done its work");
  b.require(method.command.empty() || !method.command.front().empty(), "command", "begins with the name of a program");
  const auto& ours = files_of_a_run();
  b.require(method.command.empty() || std::find(ours.begin(), ours.end(), method.trajectory) == ours.end(),
            "trajectory",
            "is the name of a file that this program writes: let the other one write into a folder, as in "
            "out/trajectory.tum");
  b.require(method.command.empty() || !method.trajectory.empty(), "trajectory",
            "is required: name the file of poses that the command writes");
  b.require(!method.command.empty() || method.input == ExternalInput::as_is, "input", "goes with `command`");
  b.require(!method.exit_codes.empty() && whole(method.exit_codes), "exit_codes",
            "must be whole numbers, one at least");
  b.require(!method.given() || !method.frame.empty(), "frame", "must be imu, lidar or a frame of the sensor file");
  for (const std::string& word : method.command) {
    const std::string unknown = unknown_place(word);
    b.require(unknown.empty(), "command",
              fmt::format("{{{}}} is no place; there are {{{}}}", unknown, fmt::join(external_places(), "}, {")));
  }
  const std::string unknown = unknown_place(method.trajectory);
  b.require(unknown.empty(), "trajectory",
            fmt::format("{{{}}} is no place; there are {{{}}}", unknown, fmt::join(external_places(), "}, {")));
}

void ExternalMethod::describe(config::Binder& b, ExternalMethod& method) {
  describe_keys(b, method);
  b.text("here", method.folder, "folder that a container sees besides; empty: that of this file");
  b.require(method.given(), "command", "is required: give the words of a program, or `trajectory` alone");
}

std::string unknown_place(std::string_view text) {
  for (std::size_t open = text.find('{'); open != std::string_view::npos; open = text.find('{', open + 1)) {
    const std::size_t close = text.find('}', open);
    if (close == std::string_view::npos) break;
    const std::string name(text.substr(open + 1, close - open - 1));
    const auto& places = external_places();
    if (!is_name(name) || std::find(places.begin(), places.end(), name) != places.end()) continue;
    // Others have braces for their own purposes.
    if (name.starts_with("run:") || !config::nearest(name, places).empty()) return name;
  }
  return {};
}

std::string filled_in(const std::string& text, const ExternalPlaces& places) {
  require_topic(text, "imu_topic", places.imu_topic);
  require_topic(text, "lidar_topic", places.lidar_topic);
  std::string out = text;
  if (places.bags.size() > 1 && text.find(kBag) != std::string::npos) {
    throw ConfigError(
        fmt::format("'{}': the recording has {} files: let {{bag}} be a word of its own, which becomes one "
                    "for each, or give the method `input: bag`",
                    text, places.bags.size()));
  }
  if (!places.bags.empty()) out = io::filled_in(out, "bag", places.bags.front().string());
  const std::vector<std::pair<std::string_view, std::string>> values = {{"imu_topic", places.imu_topic},
                                                                        {"lidar_topic", places.lidar_topic},
                                                                        {"output", places.output.string()},
                                                                        {"sensor", places.sensor.string()},
                                                                        {"data", places.data},
                                                                        {"sequence", places.sequence},
                                                                        {"seed", places.seed}};
  for (const auto& [key, value] : values) out = io::filled_in(std::move(out), key, value);
  return out;
}

std::vector<std::string> filled_in(const std::vector<std::string>& words, const ExternalPlaces& places) {
  std::vector<std::string> out;
  for (const std::string& word : words) {
    if (word == kBag) {
      for (const fs::path& bag : places.bags) out.push_back(bag.string());
    } else {
      out.push_back(filled_in(word, places));
    }
  }
  return out;
}

ExternalMethod placed_in(ExternalMethod method, const fs::path& folder) {
  std::error_code ignored;
  const fs::path here = fs::absolute(folder.empty() ? fs::path(".") : folder, ignored).lexically_normal();
  const std::string text = here.has_filename() ? here.string() : here.parent_path().string();
  const auto at = [&](const std::string& path) { return (fs::path(text) / path).lexically_normal().string(); };
  if (!method.engine.empty() && method.folder.empty()) method.folder = text;
  const auto fill = [&text](std::string& word) { word = io::filled_in(std::move(word), "here", text); };
  for (std::string& word : method.command) fill(word);
  fill(method.trajectory);
  fill(method.image);
  for (std::string& key : method.trajectory_set) {
    fill(key);
    if (key.starts_with(kTimes) && method.command.empty()) key = std::string(kTimes) + at(key.substr(kTimes.size()));
  }
  if (method.engine == "apptainer" && fs::exists(at(method.image), ignored)) method.image = at(method.image);
  if (method.command.empty()) {
    if (!method.trajectory.empty()) method.trajectory = at(method.trajectory);
  } else if (method.engine.empty() && method.command.front().find('/') != std::string::npos) {
    method.command.front() = at(method.command.front());
  }
  io::with_overrides({}, method.trajectory_set);  // what is wrong with them is told now
  return method;
}

std::string resolved_text(const ExternalMethod& method) {
  return config::file_text(method, config::FileKind::external, plugin::Catalog());
}

ExternalMethod load_external_method(const fs::path& file) {
  return placed_in(config::load<ExternalMethod>(file, config::FileKind::external, plugin::Catalog()).value,
                   file.parent_path());
}

std::vector<std::string> in_container(const ExternalMethod& method, std::vector<std::string> words,
                                      const fs::path& output, std::vector<fs::path> read, const std::string& name) {
  if (method.engine.empty()) return words;
  const bool docker = method.engine == "docker";
  std::vector<std::string> out = {"apptainer", "exec"};
  if (docker) {
    out = {"docker", "run", "--rm", "--init", "--name", name, "-u", fmt::format("{}:{}", ::getuid(), ::getgid())};
  }
  out.insert(out.end(), method.engine_options.begin(), method.engine_options.end());
  if (!method.folder.empty()) read.push_back(method.folder);
  // A folder that lies in another one is mounted after it, and so hides its part of that.
  std::erase(read, output);
  std::vector<std::pair<fs::path, const char*>> mounts = {{output, ""}};
  for (const fs::path& folder : read) mounts.emplace_back(folder, ":ro");
  std::sort(mounts.begin(), mounts.end());
  mounts.erase(std::unique(mounts.begin(), mounts.end()), mounts.end());
  for (const auto& [folder, mode] : mounts) {
    if (folder.string().find_first_of(":,") != std::string::npos) {
      throw ConfigError(
          fmt::format("{}: a container cannot be given a folder with ':' or ',' in its name", folder.string()));
    }
    out.insert(out.end(), {docker ? "-v" : "--bind", fmt::format("{0}:{0}{1}", folder.string(), mode)});
  }
  out.insert(out.end(), {docker ? "-w" : "--pwd", output.string(), method.image});
  out.insert(out.end(), words.begin(), words.end());
  return out;
}

std::vector<fs::path> files_of(const ExternalMethod& method, const ExternalPlaces& places) {
  std::vector<fs::path> files;
  std::error_code ignored;
  const auto add = [&](const fs::path& file) {
    if (file.is_absolute() && fs::is_regular_file(file, ignored)) files.push_back(file);
  };
  const auto add_times = [&] {
    for (const std::string& key : method.trajectory_set) {
      if (key.starts_with(kTimes)) add(filled_in(key.substr(kTimes.size()), places));
    }
  };
  if (method.command.empty()) {
    add(filled_in(method.trajectory, places));
    add_times();
    return files;
  }
  if (method.engine.empty()) add(program_file(method.command.front()));
  ExternalPlaces known = places;
  known.imu_topic = known.lidar_topic = "-";  // no part of a path
  for (std::size_t i = 1; i < method.command.size(); ++i) {
    if (method.command[i] != kBag) add(filled_in(method.command[i], known));
  }
  add_times();
  return files;
}

}  // namespace aslio::experiment
