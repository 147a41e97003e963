// Poses in order of time, each stamp once.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "aslio/core/errors.hpp"
#include "aslio/io/writers.hpp"
#include "rows.hpp"

namespace aslio::io {
namespace {

/// More equal stamps than this share are no slip of a recorder: digits are missing.
constexpr double kFewDigitsShare = 0.01;
/// On a shorter way an orientation may well stay what it is [m].
constexpr double kTellingPath = 5;

bool same_pose(const StampedPose& a, const StampedPose& b) { return a.T.p == b.T.p && a.T.R == b.T.R; }

class Ordering {
 public:
  Ordering(ReferenceRows rows, const ReferenceSpec& spec) : in_(std::move(rows)), spec_(spec) {
    out_.notes = std::move(in_.notes);
    out_.warnings = std::move(in_.warnings);
    out_.positions_only = in_.positions_only;
  }

  Reference finish() {
    sort();
    leave_out_equal();
    space_out();
    shift();
    judge_orientation();
    for (const ReferenceRow& row : in_.rows) out_.poses.push_back(row.pose);
    if (out_.positions_only) {
      for (StampedPose& pose : out_.poses) pose.T.R = Mat3::Identity();
    }
    return std::move(out_);
  }

 private:
  void sort() {
    const auto earlier = [](const ReferenceRow& a, const ReferenceRow& b) { return a.pose.t < b.pose.t; };
    std::size_t count = 0, first = 0;
    for (std::size_t i = 1; i < in_.rows.size(); ++i) {
      if (!earlier(in_.rows[i], in_.rows[i - 1])) continue;
      if (count++ == 0) first = in_.rows[i].line;
    }
    if (count == 0) return;
    std::stable_sort(in_.rows.begin(), in_.rows.end(), earlier);
    out_.warnings.push_back(
        fmt::format("{}: {} of {} poses are earlier than the one before them, the first in {} {}: sorted by their "
                    "stamps; check that the file is of one recording",
                    in_.source, count, in_.rows.size(), in_.place, first));
  }

  void leave_out_equal() {
    const std::size_t all = in_.rows.size();
    std::vector<ReferenceRow> kept;
    std::size_t copies = 0, others = 0, first_other = 0, leading = 1;
    for (const ReferenceRow& row : in_.rows) {
      if (kept.empty() || row.pose.t != kept.back().pose.t) {
        kept.push_back(row);
      } else {
        if (kept.size() == 1) ++leading;
        const bool copy = same_pose(row.pose, kept.back().pose);
        if (!copy && others == 0) first_other = row.line;
        ++(copy ? copies : others);
      }
    }
    if (others > 1 && static_cast<double>(others) > kFewDigitsShare * static_cast<double>(all)) {
      refuse_few_digits(kept.front().pose.t, leading, others);
    }
    if (others > 0) {
      out_.warnings.push_back(fmt::format(
          "{}: {} poses have the stamp of the one before them and are others, the first in {} {}: left out; "
          "write stamps with more digits",
          in_.source, others, in_.place, first_other));
    }
    if (copies > 0) {
      out_.notes.push_back(fmt::format("{} poses repeat the one before them: left out", copies));
    }
    in_.rows = std::move(kept);
  }

  [[noreturn]] void refuse_few_digits(TimeNs first, std::size_t leading, std::size_t equal) const {
    const std::string which = leading > 1 ? fmt::format("the first {} stamps are equal", leading)
                                          : fmt::format("{} stamps are equal to the one before", equal);
    if (first == 0 && leading == in_.rows.size()) {
      throw DataError(fmt::format("{}: all {} stamps are 0: who wrote it did not fill them; take another reference",
                                  in_.source, leading));
    }
    throw DataError(
        fmt::format("{}: {} ({:.9g} s): they were written with too few digits; write them anew with 6 decimals of a "
                    "second at least",
                    in_.source, which, to_seconds(first)));
  }

  void space_out() {
    if (spec_.min_spacing <= 0) return;
    const TimeNs least = to_ns(spec_.min_spacing);
    const std::size_t before = in_.rows.size();
    std::vector<ReferenceRow> kept;
    for (const ReferenceRow& row : in_.rows) {
      if (kept.empty() || row.pose.t - kept.back().pose.t >= least) kept.push_back(row);
    }
    in_.rows = std::move(kept);
    if (in_.rows.size() == before) return;
    out_.notes.push_back(fmt::format("{} poses come less than {} s after the last: left out (min_spacing)",
                                     before - in_.rows.size(), spec_.min_spacing));
  }

  void shift() {
    if (spec_.time_offset == 0) return;
    const TimeNs by = to_ns(spec_.time_offset);
    for (ReferenceRow& row : in_.rows) {
      row.pose.t += by;
      if (is_time(row.pose.t)) continue;
      throw ConfigError(fmt::format("time_offset: {} s moves stamps of {} out of the clock; give a smaller one",
                                    spec_.time_offset, in_.source));
    }
    out_.notes.push_back(fmt::format("{:+.6f} s added to all stamps (time_offset)", spec_.time_offset));
  }

  void judge_orientation() {
    if (out_.positions_only || spec_.positions_only != PositionsOnly::automatic) return;
    const auto& rows = in_.rows;
    double path = 0;
    for (std::size_t i = 1; i < rows.size(); ++i) {
      path += (rows[i].pose.T.p - rows[i - 1].pose.T.p).norm();
      if ((rows[i].pose.T.R - rows[0].pose.T.R).cwiseAbs().maxCoeff() > 1e-9) return;
    }
    if (path < kTellingPath) return;
    out_.positions_only = true;
    out_.notes.push_back(
        fmt::format("positions only: the orientation is the same over {:.1f} m of path, so no rotation error is "
                    "measured; set `positions_only: no` if it is meant",
                    path));
  }

  ReferenceRows in_;
  const ReferenceSpec& spec_;
  Reference out_;
};

}  // namespace

Reference in_order(ReferenceRows rows, const ReferenceSpec& spec) { return Ordering(std::move(rows), spec).finish(); }

Reference read_reference(const ReferenceSpec& spec) {
  const bool messages = spec.format == ReferenceFormat::recording ||
                        (spec.format == ReferenceFormat::automatic && (!spec.topic.empty() || is_recording(spec.file)));
  if (!messages && !spec.topic.empty()) {
    throw ConfigError(fmt::format("{}: `topic` goes with a recording; leave it out", spec.file));
  }
  return in_order(messages ? read_message_rows(spec) : read_text_rows(spec), spec);
}

}  // namespace aslio::io
