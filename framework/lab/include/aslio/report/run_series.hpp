#pragma once
/// What a run did over time, thinned out for a page.

#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "aslio/core/trajectory.hpp"
#include "aslio/report/study_folder.hpp"

namespace aslio::report {

/// Named columns of numbers of a CSV file; NaN where a cell is empty or no number.
struct Columns {
  std::vector<TimeNs> t;  ///< t_ns
  std::map<std::string, std::vector<double>> numbers;
  std::map<std::string, std::vector<std::string>> texts;  ///< of the columns that hold words
};

/// Reads a CSV file with a column t_ns. Nothing when it is not there or has no line; a last line cut short is left out.
std::optional<Columns> read_columns(const std::filesystem::path& path);

/// What belongs to a recording and not to a run.
struct DataTruth {
  std::optional<Trajectory> truth;
  TimeNs origin = 0;          ///< time 0 of the page
  Vec3 point = Vec3::Zero();  ///< [m] in the IMU frame: what the truth is of
};

/// Truth of a recording: data/DATA/truth.tum of the study, or the reference that the manifest of a run names. None
/// where that is gone, or cannot be read.
DataTruth read_truth(const StudyFolder& study, const std::string& data);

/// Truth and true overlap of a recording as the page takes them; `unreadable` says what of overlap.csv cannot be read.
nlohmann::ordered_json data_json(const StudyFolder& study, const std::string& data, const DataTruth& truth);

/// Trajectory (in the world of the truth, if there is one), telemetry, errors and timings of a run; null when it has
/// left none. Lengths are within 5 mm and other values within 0.4 % of their usual range (that
/// of all but the smallest and largest hundredth) of what the files say.
nlohmann::ordered_json series_json(const FolderRun& run, const DataTruth& truth);

/// A thinned-out map of the run (map.ply or map.pcd in its folder, as `aslio run --save-map` writes them), at most
/// `max_points`, placed as its trajectory is; null when there is none.
nlohmann::ordered_json map_json(const FolderRun& run, const DataTruth& truth, std::size_t max_points);

}  // namespace aslio::report
