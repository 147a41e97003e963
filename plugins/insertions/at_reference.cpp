#include "insertions/at_reference.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <array>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string_view>
#include <utility>
#include <vector>

#include "aslio/core/csv.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/core/parse.hpp"

namespace aslio::plugins {
namespace {

/// Poses farther apart than this are not interpolated.
constexpr TimeNs kMaxGap = kSecond / 5;

[[noreturn]] void refuse(const CsvTable& table, std::size_t row, std::string_view column, const std::string& cell) {
  throw DataError(
      fmt::format("{}:{}: {} '{}' is not a number", table.path.string(), table.lines[row], column, cell.substr(0, 40)));
}

constexpr std::array<const char*, 8> kColumns = {"t", "px", "py", "pz", "qx", "qy", "qz", "qw"};

/// A trajectory of the TUM benchmark as a table: eight numbers in a line, `#` begins a comment.
CsvTable read_tum(const std::string& file) {
  CsvTable table{.path = file, .header = {kColumns.begin(), kColumns.end()}, .rows = {}, .lines = {}};
  std::ifstream in(file);
  if (!in) throw DataError(fmt::format("{}: cannot be opened", file));
  std::string line;
  for (std::size_t number = 1; std::getline(in, line); ++number) {
    std::istringstream words(line.substr(0, line.find('#')));
    std::vector<std::string> cells{std::istream_iterator<std::string>(words), {}};
    if (cells.empty()) continue;
    if (cells.size() != kColumns.size())
      throw DataError(
          fmt::format("{}:{}: {} values, a pose has 8: t px py pz qx qy qz qw", file, number, cells.size()));
    table.rows.push_back(std::move(cells));
    table.lines.push_back(number);
  }
  return table;
}

Trajectory read_reference(const std::string& file) {
  const CsvTable table = file.ends_with(".tum") ? read_tum(file) : read_csv(file);
  std::array<std::size_t, kColumns.size()> columns{};
  for (std::size_t c = 0; c < columns.size(); ++c) columns.at(c) = table.column(kColumns.at(c));
  std::vector<StampedPose> poses;
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    std::array<double, kColumns.size()> v{};
    for (std::size_t c = 1; c < columns.size(); ++c) {
      const std::string& cell = table.rows[row][columns.at(c)];
      const auto value = parse_number(cell);
      if (!value) refuse(table, row, kColumns.at(c), cell);
      v.at(c) = *value;
    }
    const std::string& time = table.rows[row][columns.at(0)];
    const auto t = parse_time(time, 9);
    if (!t) refuse(table, row, "t", time);
    const Eigen::Quaterniond q(v[7], v[4], v[5], v[6]);
    if (!(q.norm() > 0.5 && q.norm() < 2)) refuse(table, row, "quaternion", fmt::format("{:g}", q.norm()));
    poses.push_back({*t, {q.normalized().toRotationMatrix(), Vec3(v[1], v[2], v[3])}});
  }
  return Trajectory(std::move(poses));
}

}  // namespace

void InsertAtReference::describe(config::Binder& b, Params& p) {
  b.text(
      "file", p.file,
      "T_W_I: a table with the columns t, px, py, pz, qx, qy, qz, qw, as the truth.csv of a simulated recording, or a "
      "trajectory NAME.tum; empty: as on_exit. The path is relative to the working directory");
}

InsertAtReference::InsertAtReference(const Params& params, const BuildContext& context)
    : file_(params.file), waiting_({}, context) {
  if (file_.empty()) return;
  reference_ = read_reference(file_);
  context.log->warn("insertion 'at_reference': {} places the points of the map, so this run is no result of a method",
                    file_);
}

void InsertAtReference::place(const Window& window, const Update& update) {
  const auto at_end = reference_.pose(window.plan.end, kMaxGap);
  if (at_end && (!T_W_reference_ || update.restart_map)) T_W_reference_ = update.state.pose() * at_end->inverse();
  placed_.clear();
  if (!T_W_reference_) {
    const auto seconds = [](TimeNs t) { return fmt::format("{:.3f}", to_seconds(t)); };
    throw DataError(
        fmt::format("{}: reaches from {} to {} s, the first update ends at {} s: give the truth of this data", file_,
                    reference_.empty() ? "-" : seconds(reference_.begin_time()),
                    reference_.empty() ? "-" : seconds(reference_.end_time()), seconds(window.plan.end)));
  }
  for (const WorldPoint& point : update.points(PointUse::map)) {
    const auto known = reference_.pose(point.t, kMaxGap);
    if (!known) continue;
    const Pose held = update.trajectory != nullptr ? update.trajectory->pose(point.t) : update.state.pose();
    placed_.push_back(point);
    placed_.back().p_W = *T_W_reference_ * (*known * (held.inverse() * point.p_W));
  }
}

InsertCount InsertAtReference::apply(const Window& window, const Update& update, Map& map) {
  if (file_.empty()) return waiting_.apply(window, update, map);
  place(window, update);
  Update known = update;
  known.map_points = placed_;
  known.revision = nullptr;
  return waiting_.apply(window, known, map);
}

}  // namespace aslio::plugins
