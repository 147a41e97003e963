#pragma once
/// The axes of `vary`: what each of their points sets, and what tables call it; and what assignments stand for.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "aslio/experiment/study.hpp"

namespace aslio::experiment {

/// What a name of data or of a method may hold: letters, digits, '_', '.', '+' and '-', not '.' or '-' in front.
bool valid_name(const std::string& name);
inline constexpr std::string_view kNameRule =
    "is no name: use letters, digits, '_', '.', '+' and '-', without '.' or '-' in front";

/// One point of an axis.
struct AxisPoint {
  std::string suffix;                    ///< of the method's name
  std::vector<std::string> assignments;  ///< `key.path=value`
  std::vector<std::string> values;       ///< by column
};

/// Columns that the axis has in tables. Pre: the axis is valid.
std::vector<std::string> axis_columns(const StudyAxisConfig& axis);
std::vector<AxisPoint> axis_points(const StudyAxisConfig& axis);

/// Points by axis.
using Grid = std::vector<std::vector<AxisPoint>>;
/// Those of a method: along an axis of other methods it stands still, at a point without values.
Grid grid_of(Grid points, const std::vector<StudyAxisConfig>& axes, const std::string& method);
/// The next combination, the last axis fastest; false behind the last one.
bool advance(const Grid& grid, std::vector<std::size_t>& at_axes);

/// The stages that read what a run of the study makes: "window" for `window.file={run:as_lio_plus}/updates.csv`.
std::vector<std::string> made_later(const std::vector<std::string>& assignments);
/// What a scene sets, with the seed of the recording for {seed}.
std::vector<std::string> with_seed(std::vector<std::string> assignments, std::uint64_t seed);

}  // namespace aslio::experiment
