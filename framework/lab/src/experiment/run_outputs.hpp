#pragma once
/// The files of a run that grow with it.

#include <exception>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "aslio/core/sensor.hpp"
#include "aslio/experiment/run.hpp"
#include "aslio/io/writers.hpp"
#include "folder_lock.hpp"

namespace aslio::experiment {

/// Header of updates.csv and the line of one update (both with a line feed). Numbers are the shortest decimals that
/// read back to the same bits.
std::string updates_header();
std::string updates_line(const pipeline::UpdateRecord& record);
std::string timings_header();
std::string timings_line(const pipeline::UpdateRecord& record);

/// Writes while the run goes on. A failure to write is kept until raise() (observers must not throw) and stops
/// writing.
class RunOutputs final : public pipeline::UpdateObserver {
 public:
  /// Opens every file; throws DataError when one cannot be created.
  RunOutputs(const RunOptions& options, const SensorModel& sensor);

  void on_update(const pipeline::UpdateRecord& record) override;
  /// Throws the DataError that a write met.
  void raise() const;
  /// Gives the files their names. Throws DataError.
  void close();

 private:
  void write(const pipeline::UpdateRecord& record);

  Pose T_imu_lidar_;
  io::AtomicFile trajectory_, trajectory_lidar_, updates_, timings_;
  std::unique_ptr<io::AtomicFile> dense_;
  std::optional<std::filesystem::path> map_path_;
  std::unique_ptr<io::MapWriter> map_;
  std::uint32_t segment_ = 0;  ///< that `map_` is of
  std::uint32_t maps_ = 0;     ///< finished
  TimeNs last_dense_ = kTimeMin;
  std::exception_ptr failure_;
};

/// Where the next map goes when `finished` are: a run that began anew has built another one, and how it lies to the one
/// before is not known. "map.ply", "map.segment_2.ply", ..
std::filesystem::path map_path(const std::filesystem::path& first, std::uint32_t finished);

/// Throws ConfigError when a file of the run would replace one that it reads: results are no place for inputs.
void refuse_to_overwrite_inputs(const RunOptions& options);
/// Throws ConfigError when `output` holds a trajectory.tum of somebody else.
void refuse_to_replace_strangers(const std::filesystem::path& output);

/// Creates the folder and every file that grows. Throws ConfigError when that cannot be: nothing has been read yet, and
/// another --output is the remedy.
std::unique_ptr<RunOutputs> open_outputs(const RunOptions& options, const SensorModel& sensor);

/// Creates the folder, and keeps other runs out of it for as long as the lock lives; nothing where its file system has
/// no locks. Throws ConfigError when it cannot be created, or another run is at work there.
std::optional<FolderLock> lock_output(const std::filesystem::path& output);

/// Removes the results of an earlier run, whatever becomes of this one; maps have names of their own and stay, but for
/// those of its further segments.
void remove_stale(const RunOptions& options);

/// A whole small file, on the disk before it has its name.
void write_file(const std::filesystem::path& path, const std::string& text);

}  // namespace aslio::experiment
