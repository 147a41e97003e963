#pragma once
/// Writes measurements in the layout of a data set.

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "aslio/core/measurement.hpp"
#include "aslio/io/layout.hpp"

namespace aslio::io {

/// The beams of a sweep.
struct SweepGrid {
  double period = 0.1;  ///< of a sweep [s]
  int lines = 16;
  int columns = 0;  ///< firings in a sweep, evenly in time; 0: unknown, such a sweep cannot be organised
};

/// What a layout is filled in with.
struct LayoutPlace {
  std::filesystem::path folder;  ///< all files lie below; folders are created
  std::string sequence;          ///< for {sequence}
  TimeNs begin = 0, end = 0;     ///< extent of the record times, for parts
  SweepGrid grid;
  Pose T_imu_lidar;  ///< for the calibration file of KITTI
};

/// Takes measurements in the order in which they are received. Memory does not grow with the recording. Each file
/// appears under its name once it is whole; those not closed are removed.
class LayoutWriter {
 public:
  virtual ~LayoutWriter() = default;
  /// `sample.t` is its stamp [ns], `received` the record time.
  virtual void add_imu(const ImuSample& sample, TimeNs received) = 0;
  /// Points in the LiDAR frame with absolute times, by time; `sweep.stamp` is the start of the sweep. Throws DataError
  /// for what the form cannot hold: a line or column outside the grid, a time out of range.
  virtual void add_sweep(const LidarPacket& sweep, TimeNs received) = 0;
  /// True pose T_W_I, later than the last one. It is taken when the rate of the reference asks for it.
  virtual void add_reference(const StampedPose& T_W_I) = 0;
  virtual void close() = 0;
  /// Written so far, relative to the folder: files, and folders of rosbag2 or scans. After close(): all.
  virtual const std::vector<std::filesystem::path>& files() const = 0;
};

/// Throws ConfigError for a layout that contradicts itself, DataError for what cannot be written.
std::unique_ptr<LayoutWriter> open_layout_writer(const Layout& layout, const LayoutPlace& place);

/// What an IMU with that driver and clock tells of a sample.
ImuSample as_told(const ImuLayout& layout, ImuSample sample);
/// A sweep by the clock of the sensor; `scratch` holds it where that differs.
const LidarPacket& as_told(const LidarLayout& layout, const LidarPacket& sweep, LidarPacket& scratch);

/// `name` with {key} replaced; for names of files in layouts and families.
std::string filled_in(std::string name, std::string_view key, std::string_view value);

}  // namespace aslio::io
