#pragma once
/// A schedule of updates from a file, moved in time or put into another order. (WIN-7)

#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "aslio/core/time.hpp"

namespace aslio::plugins {

/// When updates end, and how far their windows reach back before their fresh interval.
class ReplaySchedule {
 public:
  struct Update {
    TimeNs end = 0;
    TimeNs history = 0;                                           ///< [ns] before the fresh interval, >= 0
    double turn_rate = std::numeric_limits<double>::quiet_NaN();  ///< over the fresh interval [rad/s]; NaN: not known
  };

  /// Reads a CSV file: a header that names `t_ns` (end of an update) and maybe `window_begin_ns` and `gyro_rms_rad_s`;
  /// other columns are skipped, so the updates.csv of a run will do. Throws ConfigError when the file cannot be opened,
  /// DataError with file, line and value when it cannot be understood or the ends do not increase.
  static ReplaySchedule read(const std::filesystem::path& path);
  /// The same from text; `source` is named in errors.
  static ReplaySchedule parse(std::string_view text, const std::string& source);

  /// Takes the updates that end up to `warmup` after the first end off the front, but for the last of them, with which
  /// the rest begins, and gives them back as they are; maybe none. `prepend` puts them there again: what is done in
  /// between leaves them, and the end at which they meet the rest, in their places.
  std::vector<Update> split(TimeNs warmup);
  void prepend(const std::vector<Update>& head);

  /// Moves the rhythm by `shift` around the circle from the first end to the last, which both stay: as many updates
  /// (one more where the seam falls inside an interval), at other times.
  void rotate(TimeNs shift);
  /// Puts the intervals between the ends, each with its history, into an order drawn from `seed`. The first and the
  /// last end stay.
  void shuffle(std::uint64_t seed);
  /// Puts the ends at equal distances between the first and the last. Every window keeps its length, unless that is
  /// less than the distance.
  void steady();
  /// As many updates, and about as much time spent in intervals of each length (all are stretched by the one factor
  /// that makes the number the same), but the shorter the faster the sensor turns there: where its turn rate is above
  /// that of a share q of the time, the interval is the one that a share q of the time has longer ones than. The first
  /// and the last end stay; a window is as long as those of such intervals were.
  /// Throws DataError when a turn rate is not known.
  void by_turn_rate();

  /// First update that ends after t, or null when none does. Pre: t never decreases from call to call.
  const Update* after(TimeNs t);

  const std::vector<Update>& updates() const { return updates_; }
  TimeNs longest_history() const;

 private:
  std::string source_;           ///< named in errors
  std::vector<Update> updates_;  ///< ends strictly increasing, never empty
  std::size_t next_ = 0;
};

}  // namespace aslio::plugins
