#pragma once
/// The overlap metric of a pipeline by itself: frames of equal length, placed at known poses, scored one after another.

#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "aslio/experiment/run.hpp"
#include "aslio/io/reference.hpp"
#include "aslio/io/source.hpp"
#include "aslio/plugin/registry.hpp"
#include "aslio/stages/window.hpp"

namespace aslio::experiment {

struct OverlapSeriesOptions {
  std::filesystem::path pipeline;             ///< of which only `overlap` counts
  std::vector<std::string> overrides;         ///< `key.path=value`, in order
  std::vector<std::filesystem::path> inputs;  ///< read as one recording; at least one
  std::filesystem::path sensor;
  io::ReferenceSpec trajectory;  ///< with orientations
  io::Section section;
  double period = 0.1;  ///< [s] length of a frame
  /// Each frame is scored a second time with its pose moved by this much in a direction of its own [m], and turned by
  /// this much about an axis of its own through the IMU at the end of the frame [rad]. What is known stays unmoved.
  double position_error = 0, rotation_error = 0;
  std::uint64_t seed = 0;  ///< of those directions and axes
};

struct OverlapSample {
  TimeNs t = 0;  ///< end of the frame
  OverlapScore score;
  std::optional<double> moved;  ///< the score at the moved pose
};

struct OverlapSeriesEnd {
  std::size_t frames = 0, scored = 0;
  std::size_t points_without_pose = 0;
  bool interrupted = false, truncated = false;
  std::optional<std::string> failure;      ///< what ended it early; the frames before stand
  bool bad_data = false;                   ///< the failure is due to what was read or could not be written
  std::vector<std::string> late_warnings;  ///< of the input, found after RunMonitor::on_start()
};

/// Points outside the sensor's range, or at times without a pose, are left out. Throws ConfigError for a configuration
/// that cannot be used and DataError for data that cannot be opened; what fails later is in the result.
OverlapSeriesEnd score_overlap(const OverlapSeriesOptions& options, const plugin::Catalog& catalog,
                               const std::function<void(const OverlapSample&)>& take, RunMonitor& monitor);

/// Header of the CSV file of samples and the line of one (both with a line feed).
std::string overlap_series_header();
std::string overlap_series_line(const OverlapSample& sample);

}  // namespace aslio::experiment
