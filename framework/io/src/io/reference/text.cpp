// Poses in text: TUM, EuRoC, KITTI and tables.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>

#include "aslio/core/errors.hpp"
#include "columns.hpp"
#include "rows.hpp"
#include "stamps.hpp"
#include "text_rows.hpp"

namespace aslio::io {
namespace {

constexpr double kTolerance = 1e-2;  ///< of norms and orthogonality, for digits that were cut

/// What a table is, found from its first rows.
struct Layout {
  Columns columns;
  TimeUnit unit = TimeUnit::s;
  bool has_header = false;  ///< the first row is no pose
};

std::vector<std::string_view> views_of(const std::vector<std::string>& texts) { return {texts.begin(), texts.end()}; }

class TextReader {
 public:
  explicit TextReader(const ReferenceSpec& spec) : spec_(spec), text_(read_whole(spec.file)) {
    out_.source = spec.file;
  }

  ReferenceRows read() {
    find_layout();
    const std::vector<TimeNs> times = read_times();
    TextRows rows(text_, spec_.file);
    for (bool first = true; rows.next(); first = false) {
      if (first && layout_.has_header) continue;
      if (out_.rows.size() == kMostPoses) rows.refuse(fmt::format("has more than {} poses", kMostPoses), "");
      out_.rows.push_back(row_of(rows, times));
    }
    if (out_.rows.empty()) throw DataError(fmt::format("{}: holds no pose: is it the right file?", spec_.file));
    if (!layout_.columns.timed() && out_.rows.size() != times.size()) {
      throw DataError(fmt::format("{}: has {} poses, {} has {} stamps: are they of one drive?", spec_.file,
                                  out_.rows.size(), spec_.times, times.size()));
    }
    judge_orientations();
    return std::move(out_);
  }

 private:
  [[noreturn]] void refuse_layout(const TextRows& rows, std::size_t count) const {
    if (count == 8 && spec_.format == ReferenceFormat::automatic) {
      rows.refuse(
          "8 columns by commas, stamps in ns: the order of the quaternion cannot be told; set `format: euroc` "
          "(w first) or `format: tum` (w last)",
          rows.cells().front());
    }
    if (spec_.format == ReferenceFormat::tum) {
      rows.refuse(fmt::format("{} columns where TUM has 8 (t tx ty tz qx qy qz qw)", count), rows.cells().front());
    }
    rows.refuse(
        fmt::format("{} columns tell no pose; list them in `columns`, as in [t, x, y, z, qx, qy, qz, qw]", count),
        rows.cells().front());
  }

  /// Header, columns and unit. The first rows are read for it, and read again with the others.
  void find_layout() {
    TextRows rows(text_, spec_.file);
    if (!rows.next()) throw DataError(fmt::format("{}: holds no pose: is it the right file?", spec_.file));
    std::vector<std::string> header;
    if (!parse_number(rows.cells().front())) {
      layout_.has_header = true;
      header.assign(rows.cells().begin(), rows.cells().end());
      if (!rows.next()) rows.refuse("no row of numbers follows: is it the right file?", header.front());
    } else {
      const auto cells = rows.split(rows.comment());
      // Of a comment that is a header, each name stands for a column.
      if (cells.size() == rows.cells().size()) header.assign(cells.begin(), cells.end());
    }
    choose_columns(rows, views_of(header));
    if (layout_.columns.timed()) choose_unit(rows);
    if (layout_.columns.how != kTumColumns) out_.notes.push_back(fmt::format("columns: {}", layout_.columns.how));
  }

  void choose_columns(const TextRows& rows, const std::vector<std::string_view>& header) {
    if (!spec_.columns.empty()) {
      layout_.columns = listed_columns(spec_.columns, header);
      return;
    }
    const bool by_name = spec_.format == ReferenceFormat::automatic || spec_.format == ReferenceFormat::csv;
    std::optional<Columns> found = by_name ? named_columns(header) : std::nullopt;
    if (!found) found = counted_columns(rows.cells(), spec_.format, rows.separator());
    if (!found) refuse_layout(rows, rows.cells().size());
    layout_.columns = std::move(*found);
    if (!header.empty() && layout_.columns.has(Role::t) && layout_.columns.time_name.empty()) {
      layout_.columns.time_name = header[*layout_.columns[Role::t]];
    }
  }

  void choose_unit(TextRows& rows) {
    layout_.unit = spec_.time_unit;
    if (layout_.columns.has(Role::sec) || spec_.time_unit != TimeUnit::automatic) return;
    constexpr std::size_t kLooked = 1000;
    const std::size_t column = *layout_.columns[Role::t];
    std::vector<std::string> stamps;
    do {
      if (column < rows.cells().size()) stamps.emplace_back(rows.cells()[column]);
    } while (stamps.size() < kLooked && rows.next());
    const auto verdict = judge_unit(views_of(stamps), layout_.columns.time_name);
    if (!verdict) {
      throw DataError(fmt::format("{}: the stamps ({}, {}, ..) tell no unit; set `time_unit` to s, ms, us or ns",
                                  spec_.file, stamps[0], stamps.size() > 1 ? stamps[1] : "none"));
    }
    layout_.unit = verdict->unit;
    if (verdict->unit != TimeUnit::s) {
      out_.notes.push_back(fmt::format("stamps are in {} ({})", name(verdict->unit), verdict->how));
    }
  }

  /// Stamps of a file of their own; none where the poses have theirs.
  std::vector<TimeNs> read_times() const {
    std::vector<TimeNs> times;
    if (layout_.columns.timed()) {
      if (!spec_.times.empty())
        throw ConfigError(fmt::format("{}: its poses have stamps: leave `times` out", spec_.file));
      return times;
    }
    if (spec_.times.empty()) {
      throw ConfigError(
          fmt::format("{}: rows of 12 numbers are poses without stamps; name the file of the stamps in `times` "
                      "(times.txt of KITTI)",
                      spec_.file));
    }
    const std::string text = read_whole(spec_.times);
    TextRows rows(text, spec_.times);
    const TimeUnit unit = spec_.time_unit == TimeUnit::automatic ? TimeUnit::s : spec_.time_unit;
    while (rows.next()) {
      const auto t = parse_time(rows.cells().front(), unit);
      if (!t) rows.refuse(fmt::format("not a time in {}; set `time_unit`", name(unit)), rows.cells().front());
      if (times.size() == kMostPoses) rows.refuse(fmt::format("has more than {} stamps", kMostPoses), "");
      times.push_back(*t);
    }
    return times;
  }

  ReferenceRow row_of(const TextRows& rows, const std::vector<TimeNs>& times) {
    const Columns& columns = layout_.columns;
    const auto& cells = rows.cells();
    const bool trailing = cells.size() == columns.width + 1 && cells.back().empty();
    if (cells.size() != columns.width && !trailing) {
      rows.refuse(fmt::format("{} columns, where there are {} ({})", cells.size(), columns.width, columns.how),
                  cells.front());
    }
    ReferenceRow row;
    row.line = rows.line();
    row.pose.t = columns.timed() ? time_of(rows) : times.size() > out_.rows.size() ? times[out_.rows.size()] : 0;
    const auto value = [&](Role role) { return number(rows, role); };
    row.pose.T.p = Vec3(value(Role::x), value(Role::y), value(Role::z));
    if (spec_.positions_only == PositionsOnly::yes) return row;
    if (columns.has_quaternion()) row.pose.T.R = quaternion_of(rows);
    if (columns.has_matrix()) row.pose.T.R = matrix_of(rows);
    return row;
  }

  double number(const TextRows& rows, Role role) const {
    const std::string_view cell = rows.cells()[*layout_.columns[role]];
    const auto value = parse_number(cell);
    if (!value || std::abs(*value) > 1e12) rows.refuse("not a finite number; leave the row out", cell);
    return *value;
  }

  TimeNs time_of(const TextRows& rows) const {
    const Columns& columns = layout_.columns;
    if (const auto column = columns[Role::t]) {
      const auto t = parse_time(rows.cells()[*column], layout_.unit);
      if (!t) {
        rows.refuse(fmt::format("not a time in {}; set `time_unit`, or mend the row", name(layout_.unit)),
                    rows.cells()[*column]);
      }
      return *t;
    }
    const std::string_view sec = rows.cells()[*columns[Role::sec]], nsec = rows.cells()[*columns[Role::nsec]];
    const auto whole = parse_time(sec, TimeUnit::s), part = parse_time(nsec, TimeUnit::ns);
    if (!whole) rows.refuse("not whole seconds", sec);
    if (!part || *part < 0 || *part >= kSecond) rows.refuse("not nanoseconds of a second (0 to 999999999)", nsec);
    return *whole + *part;
  }

  Mat3 quaternion_of(const TextRows& rows) {
    const auto value = [&](Role role) { return number(rows, role); };
    const Eigen::Quaterniond q(value(Role::qw), value(Role::qx), value(Role::qy), value(Role::qz));
    if (q.norm() == 0) {
      if (zeros_++ == 0) first_zero_ = rows.line();
      return Mat3::Identity();
    }
    if (std::abs(q.norm() - 1) > kTolerance) {
      rows.refuse(fmt::format("a quaternion of norm {:.4f}; is the order of the columns another one?", q.norm()),
                  rows.cells().front());
    }
    return q.normalized().toRotationMatrix();
  }

  Mat3 matrix_of(const TextRows& rows) const {
    Mat3 R;
    for (int i = 0; i < 9; ++i) R(i / 3, i % 3) = number(rows, static_cast<Role>(static_cast<int>(Role::r11) + i));
    if ((R.transpose() * R - Mat3::Identity()).cwiseAbs().maxCoeff() > kTolerance || R.determinant() < 0) {
      rows.refuse("the 9 numbers are no rotation; is the order of the columns another one?", rows.cells().front());
    }
    return Eigen::Quaterniond(R).normalized().toRotationMatrix();
  }

  void judge_orientations() {
    const bool written = layout_.columns.has_quaternion() || layout_.columns.has_matrix();
    const bool all_zero = zeros_ == out_.rows.size();
    if (zeros_ > 0 && !all_zero) {
      throw DataError(
          fmt::format("{}:{}: a quaternion 0 0 0 0, as have {} of {} rows; leave those out, or set "
                      "`positions_only: yes`",
                      spec_.file, first_zero_, zeros_, out_.rows.size()));
    }
    out_.positions_only = !written || all_zero || spec_.positions_only == PositionsOnly::yes;
    if (!out_.positions_only) return;
    if (spec_.positions_only == PositionsOnly::no) {
      throw ConfigError(fmt::format("{}: has no orientation, which `positions_only: no` asks for", spec_.file));
    }
    out_.notes.push_back(fmt::format("positions only ({}): no rotation error is measured",
                                     spec_.positions_only == PositionsOnly::yes ? "as set"
                                     : all_zero && written                      ? "all quaternions are 0 0 0 0"
                                                                                : "there is no orientation"));
  }

  const ReferenceSpec& spec_;
  std::string text_;
  Layout layout_;
  ReferenceRows out_;
  std::size_t zeros_ = 0, first_zero_ = 0;
};

}  // namespace

ReferenceRows read_text_rows(const ReferenceSpec& spec) { return TextReader(spec).read(); }

}  // namespace aslio::io
