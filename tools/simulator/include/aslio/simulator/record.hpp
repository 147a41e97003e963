#pragma once
/// From a simulation to files that any LIO can use.

#include <array>
#include <filesystem>
#include <functional>
#include <string>

#include "aslio/simulator/simulation.hpp"

namespace aslio::simulator {

struct RecordOptions {
  std::filesystem::path folder;  ///< created; files of an earlier recording are replaced
  int threads = 1;               ///< the files are the same for any number
  bool compress = true;          ///< lz4
  std::string name;              ///< of the dataset; as a rule the stem of the scene file
};

struct RecordResult {
  std::size_t packets = 0, points = 0, rays = 0, imu_samples = 0;
  double data_s = 0, wall_s = 0, path_length_m = 0;
  std::string bag_sha256;
};

/// Share of the data in [0, 1]; returns false to stop.
using RecordProgress = std::function<bool(double)>;

/// Writes, each file whole or not at all, the dataset file last (its presence says that the others are whole; that of
/// an earlier recording is removed first):
///   <name>.bag     LiDAR and IMU by record time: Livox CustomMsg and acceleration in g as its driver sends them, or
///                  PointCloud2 as Velodyne's (x, y, z, intensity, ring, time) and acceleration in m/s^2
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
///   a
///                  closed loop
/// Stopped by `progress`, nothing but whole files remains and false is returned. Throws DataError naming the path for
/// what cannot be written, and when no ray has returned (a mesh in another unit or frame).
bool record(const Simulation& simulation, const SceneFile& scene, const RecordOptions& options,
            const RecordProgress& progress, RecordResult& result);

}  // namespace aslio::simulator
