#pragma once
/// References: trajectories of the truth, in the formats in which data sets publish them.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "aslio/core/types.hpp"
#include "aslio/io/time_unit.hpp"
#include "aslio/io/transforms.hpp"

namespace aslio::io {

/// How the poses are written. `automatic`: by the content.
enum class ReferenceFormat : std::uint8_t { automatic, tum, csv, euroc, kitti, recording };
/// The key `format`.
void describe_format(config::Binder& b, ReferenceFormat& format, std::string_view doc);
/// Whether the reference tells positions alone. `automatic`: by the content.
enum class PositionsOnly : std::uint8_t { automatic, yes, no };
/// Which pose of the reference belongs to which of the estimate.
enum class Association : std::uint8_t {
  interpolated,  ///< the reference at the stamps of the estimate
  nearest,       ///< nearest stamps
  at_reference   ///< the estimate at the stamps of the reference: for a sparse one
};
/// The rules by which a data set is measured by its authors.
enum class Protocol : std::uint8_t { none, ntu_viral, hilti_2022, hilti_2023 };

/// A reference and what there is to know of it (`schema: aslio/reference/1`; the block `reference` of a dataset).
struct ReferenceSpec {
  std::string file;   ///< trajectory, table or recording; empty: no reference
  std::string times;  ///< stamps of poses without, a line each (KITTI)
  ReferenceFormat format = ReferenceFormat::automatic;
  std::vector<std::string> columns;  ///< `x` in the order of the file, or `x=pos_x` by the names of its header
  TimeUnit time_unit = TimeUnit::automatic;
  std::string topic;                      ///< of a recording; empty: the only one that fits
  std::string parent_frame, child_frame;  ///< of a TF topic
  PositionsOnly positions_only = PositionsOnly::automatic;
  TransformBlock T_imu_reference;  ///< pose of the frame of the reference in the IMU frame
  std::string frame;               ///< name of that frame, for a chain of `transforms`; empty: T_imu_reference
  std::vector<NamedTransform> transforms;
  std::vector<double> lever_arm;  ///< position of the reference point in the IMU frame [m]; empty: none
  double time_offset = 0;         ///< added to the stamps of the reference [s]
  double min_spacing = 0;         ///< poses nearer to the last one are left out [s]
  Association association = Association::interpolated;
  std::optional<double> max_gap;        ///< of the reference, to interpolate across [s]; 2.5 usual steps
  std::optional<double> max_neighbour;  ///< from a stamp to either neighbour in the reference [s]; any
  double max_difference = 0.01;         ///< of nearest stamps [s]
  Protocol protocol = Protocol::none;

  ReferenceSpec() = default;
  /// A plain path stands for a file of which all else is found. Not explicit: it is one wherever a path is.
  ReferenceSpec(const std::filesystem::path& path) : file(path.string()) {}

  static void describe(config::Binder& b, ReferenceSpec& spec);
};

/// The reference that `path` stands for: a YAML file with `schema: aslio/reference/1`, whose paths are relative to its
/// folder, or any other file as it is; then `overrides`, `key=value` each. Throws ConfigError with all that is wrong.
ReferenceSpec load_reference_spec(const std::filesystem::path& path, const std::vector<std::string>& overrides = {});

/// YAML text (`schema: aslio/reference/1`) with every key, and back. The text is that of resolved_text().
std::string resolved_text(const ReferenceSpec& spec);
ReferenceSpec parse_reference_spec(const std::string& text, const std::string& source);

/// The same with `key=value` each. Throws as load_reference_spec() does.
ReferenceSpec with_overrides(const ReferenceSpec& spec, const std::vector<std::string>& overrides);

/// The same with its frame given by this transform alone, so that no other file is needed to know it.
ReferenceSpec in_place(ReferenceSpec spec, const Pose& T_imu_reference);

/// The keys with what its protocol says where they say nothing.
ReferenceSpec with_protocol(ReferenceSpec spec);

/// What was read: poses of the frame of the reference in its world.
struct Reference {
  std::vector<StampedPose> poses;  ///< strictly later one after the other; orientation I where positions_only
  bool positions_only = false;
  std::vector<std::string> notes;     ///< what was found and decided
  std::vector<std::string> warnings;  ///< what may be wrong
};

/// Reads the file of `spec`, with its stamps, unit, columns, offset and spacing; frames are not changed. Rows that are
/// not in order are sorted, copies left out, both told. Throws DataError that names file, line, value and remedy, and
/// ConfigError where the keys do not fit the file.
Reference read_reference(const ReferenceSpec& spec);

/// Pose of the frame of the reference in the IMU frame: its own T_imu_reference or lever arm, or a chain of its
/// transforms and `more` (those of a sensor file) from `imu` to `frame`, or to `reference` where no frame is named.
Pose pose_in_imu(const ReferenceSpec& spec, std::vector<NamedTransform> more = {});

}  // namespace aslio::io
