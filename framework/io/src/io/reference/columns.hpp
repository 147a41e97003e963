#pragma once
/// Which column of a table of poses holds what.

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "aslio/io/reference.hpp"

namespace aslio::io {

enum class Role : std::uint8_t { t, sec, nsec, x, y, z, qx, qy, qz, qw, r11, r12, r13, r21, r22, r23, r31, r32, r33 };
inline constexpr std::size_t kRoles = 19;

/// What needs no word.
inline constexpr std::string_view kTumColumns = "t x y z qx qy qz qw";

struct Columns {
  std::array<std::optional<std::size_t>, kRoles> at;  ///< index of the column of each role
  std::size_t width = 0;                              ///< columns of a row
  std::string how;                                    ///< "t x y z qx qy qz qw", for people
  std::string time_name;                              ///< of the column in the header; empty: none

  std::optional<std::size_t> operator[](Role role) const { return at[static_cast<std::size_t>(role)]; }
  bool has(Role role) const { return (*this)[role].has_value(); }
  bool timed() const { return has(Role::t) || has(Role::sec); }
  bool has_quaternion() const { return has(Role::qx); }
  bool has_matrix() const { return has(Role::r11); }
};

/// The columns that `written` lists: roles in order with `-` between, or `role=name` of the header. Throws ConfigError
/// for a role that there is not, is there twice or is missing, and for a name that the header does not have.
Columns listed_columns(std::span<const std::string> written, std::span<const std::string_view> header);

/// The columns by the names of a header; nothing where they do not tell a time and a position.
std::optional<Columns> named_columns(std::span<const std::string_view> header);

/// The columns by their number, for the formats that have no header. `first` is the first row. Nothing where the number
/// tells nothing.
std::optional<Columns> counted_columns(std::span<const std::string_view> first, ReferenceFormat format, char separator);

}  // namespace aslio::io
