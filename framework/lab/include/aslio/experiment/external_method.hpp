#pragma once
/// A method that is not of this program: a program of others, or a trajectory that others have made. It is run, limited
/// and measured like any other (docs/external_programs.md).

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "aslio/io/reference.hpp"

namespace aslio::config {
class Binder;
}

namespace aslio::experiment {

/// What the program is given to read.
enum class ExternalInput : std::uint8_t {
  as_is,   ///< the files of the recording, as they are
  bag,     ///< a ROS1 bag, written from what this program reads
  db3,     ///< a rosbag2 database, the same
  mcap,    ///< an MCAP file of ROS2 messages, the same
  folder,  ///< a PCD file for each sweep and a table of the IMU, the same
};

/// Fields or message of the points in what is written.
enum class ExternalPoints : std::uint8_t { automatic, velodyne, ouster, hesai, livox_cloud, livox, livox2 };

/// Keys of such a method: an entry of `methods` in a study, or a file (`schema: aslio/external/1`).
struct ExternalMethod {
  /// Words; {bag}, {output} and so on are replaced (external_places()). Empty: the trajectory is finished.
  std::vector<std::string> command;
  std::string trajectory;  ///< file with the poses; of a command: in its output folder
  io::ReferenceFormat format = io::ReferenceFormat::automatic;
  std::string frame = "imu";  ///< whose poses they are: imu, lidar, or one of the sensor file's transforms
  std::vector<std::string> trajectory_set;  ///< further keys of the file, `key=value` as of a reference
  ExternalInput input = ExternalInput::as_is;
  ExternalPoints points = ExternalPoints::automatic;
  std::string engine;                       ///< docker, apptainer, or empty: no container
  std::string image;                        ///< of the container
  std::vector<std::string> engine_options;  ///< words for it
  std::string folder;                       ///< of a method in a container: that of {here}; empty: that of its file
  std::vector<double> exit_codes{0};        ///< with which the program has done its work

  bool given() const { return !command.empty() || !trajectory.empty(); }
  /// The keys alone: they stand beside others in a study.
  static void describe_keys(config::Binder& b, ExternalMethod& method);
  /// A whole file.
  static void describe(config::Binder& b, ExternalMethod& method);
};

/// Names that may stand in braces in a word of the command or in the path of the trajectory.
const std::vector<std::string>& external_places();

/// What the places stand for in one run.
struct ExternalPlaces {
  std::vector<std::filesystem::path> bags;  ///< a word that is {bag} alone becomes a word for each
  std::string imu_topic, lidar_topic;       ///< empty: not known
  std::filesystem::path output;             ///< folder of the run, in which the program works
  std::filesystem::path sensor;             ///< sensor file
  std::string data;                         ///< name of the recording, with the seed of a simulation
  std::string sequence;                     ///< without
  std::string seed;                         ///< order seed of the run
};

/// Words with their places filled in. Throws ConfigError for a topic that is not known, and for {bag} inside a word
/// where there are several.
std::vector<std::string> filled_in(const std::vector<std::string>& words, const ExternalPlaces& places);
std::string filled_in(const std::string& text, const ExternalPlaces& places);

/// The first {name} that is near to a place and none of them, or {run:..}; empty: there is none. `text`: a word.
std::string unknown_place(std::string_view text);

/// A method of a file in `folder`: {here} replaced by it, a program with a slash in its name, a finished trajectory
/// with its times, and an image that lies there made absolute. Throws ConfigError for keys in trajectory_set that are
/// wrong.
ExternalMethod placed_in(ExternalMethod method, const std::filesystem::path& folder);

/// YAML text (`schema: aslio/external/1`) with every key, and back. Throws ConfigError with all that is wrong.
std::string resolved_text(const ExternalMethod& method);
ExternalMethod load_external_method(const std::filesystem::path& file);

/// The command as it is started: in its container, if it has one, which is called `name`. `words`: filled in; `read`:
/// folders that it reads. Throws ConfigError for a folder that no container can be given.
std::vector<std::string> in_container(const ExternalMethod& method, std::vector<std::string> words,
                                      const std::filesystem::path& output, std::vector<std::filesystem::path> read,
                                      const std::string& name);

/// Names of what `aslio external` leaves in the folder of a run.
const std::vector<std::string>& files_of_a_run();

/// Files of this machine that decide what a run does, the first one before all: the program or a finished trajectory,
/// files among its words, times. An image is too large to be among them.
std::vector<std::filesystem::path> files_of(const ExternalMethod& method, const ExternalPlaces& places);

}  // namespace aslio::experiment
