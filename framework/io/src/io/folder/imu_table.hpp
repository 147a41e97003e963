#pragma once
/// Tables of IMU samples whose columns are found by their names.

#include <array>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "folder_recording.hpp"

namespace aslio::io {

/// Places of the columns in a line, from 0.
struct ImuColumns {
  std::optional<std::size_t> time, nanoseconds;  ///< nanoseconds: of the second that `time` then counts
  std::array<std::optional<std::size_t>, 3> gyro, acc;

  bool complete() const;
  std::size_t last() const;  ///< the largest place. Pre: complete()
};

/// By names as `timestamp`, `sec` and `nsec`; `wx`, `gyro_x`, `angular_velocity_x`; `ax`, `acc_x`,
/// `linear_acceleration_x`. Case, separators, units in brackets and a leading `#` do not matter.
ImuColumns find_imu_columns(std::span<const std::string_view> names);

/// Whether the first lines of a file name the columns of an IMU. False for what cannot be read.
bool is_imu_table(const std::filesystem::path& path);

/// The samples, in the order and the units of the file. `columns`: the names where the file has none; empty where it
/// must. The unit of time is that in which samples come 3.3 to 3300 times a second. What was found is said in
/// `verdicts`, and a last line that is cut off in `warnings`. Throws DataError with file and line.
std::vector<ImuSample> read_imu_table(const std::filesystem::path& path, const std::string& columns,
                                      std::vector<std::string>& verdicts, std::vector<std::string>& warnings);

}  // namespace aslio::io
