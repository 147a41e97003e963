#pragma once
/// From a simulation to files that any LIO can use.

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "aslio/io/layout.hpp"
#include "aslio/simulator/simulation.hpp"

namespace aslio::simulator {

/// How LiDAR and IMU are recorded.
enum class RecordFormat : std::uint8_t {
  bag,   ///< ROS1 bag
  db3,   ///< rosbag2 of a database, a folder with its metadata.yaml
  mcap,  ///< MCAP of ROS2 messages
};

/// A recording in the layout of a data set, in place of a format.
struct RecordLayout {
  io::Layout layout;
  std::filesystem::path folder;  ///< of the data set; the other files go to RecordOptions::folder
  std::string sequence;
  double sweep_period = 0.1;  ///< of a message [s]; a packet of 0.1 s holds a whole number of them
  int lines = 256;            ///< scan lines that a reader takes: higher ones are told as lower ones
};

struct RecordOptions {
  std::filesystem::path folder;  ///< created; files of an earlier recording are replaced
  int threads = 1;               ///< the files are the same for any number
  bool compress = true;          ///< bag: lz4, MCAP: zstd
  std::string name;              ///< of the dataset; as a rule the stem of the scene file
  RecordFormat format = RecordFormat::bag;
  std::int64_t parts = 1;                ///< files of equal time; several lie in a folder <name>
  std::optional<RecordLayout> layout{};  ///< in place of format, compression and parts
};

struct RecordResult {
  std::size_t packets = 0, points = 0, rays = 0, imu_samples = 0;
  double data_s = 0, wall_s = 0, path_length_m = 0;
  std::string input;                         ///< what dataset.yaml names as the recording; empty with a layout
  std::string bag_sha256;                    ///< of the recording, as a run tells it; empty with a layout
  std::vector<std::filesystem::path> files;  ///< with a layout: what was written, relative to its folder
};

/// Share of the data in [0, 1]; returns false to stop.
using RecordProgress = std::function<bool(double)>;

/// Writes, each file whole or not at all, the dataset file last (its presence says that the others are whole; that of
/// an earlier recording is removed first):
///   <name>.bag     LiDAR and IMU by record time: Livox CustomMsg and acceleration in g as its driver sends them, or
///                  PointCloud2 as Velodyne's (x, y, z, intensity, ring, time) and acceleration in m/s^2. Of other
///                  formats <name>.mcap, or a folder <name>
///   truth.tum      T_W_I at 200 Hz
///   truth.csv      t, position, velocity in W, quaternion, angular rate in I, biases at 200 Hz (of the IMU samples
///                  about that time, interpolated)
///   overlap.csv    t (end of each 10 ms), rays on the static world, true overlap: share of them whose cell a ray of an
///                  earlier block had hit (nan without such rays); rays on people
///   sensor.yaml    sensor file that fits the bag
///   scene.yaml     the scene with every key at its effective value, files by absolute path; seed and scale in a
///                  comment
///   preview.svg    top view of the accumulated true cloud with the path, start, scale bar
///   dataset.yaml   dataset file (schema: aslio/dataset/1); a motion that ends within 1 mm and 0.1 deg of its start is
///                  a closed loop
/// With a layout, the recording goes to its folder, and sensor.yaml and dataset.yaml are left out: they would not fit.
/// Stopped by `progress`, nothing but whole files remains and false is returned. Throws DataError naming the path for
/// what cannot be written, and when no ray has returned (a mesh in another unit or frame).
bool record(const Simulation& simulation, const SceneFile& scene, const RecordOptions& options,
            const RecordProgress& progress, RecordResult& result);

}  // namespace aslio::simulator
