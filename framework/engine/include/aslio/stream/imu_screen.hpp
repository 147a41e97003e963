#pragma once
/// What is judged of the readings of an IMU before they are taken: spikes are refused, and what is clipped or stuck is
/// marked. A sample that nothing speaks against passes at once and as it is.

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "aslio/core/types.hpp"

namespace aslio::stream {

/// What the screen found, in samples.
struct ImuFindings {
  std::uint64_t spikes = 0;        ///< far from their neighbours on both sides: refused
  std::uint64_t gyro_clipped = 0;  ///< an axis of the gyro at the end of its range
  std::uint64_t acc_clipped = 0;
  std::uint64_t stuck = 0;  ///< the gyro, or the accelerometer, repeats its reading
  std::uint64_t zero = 0;   ///< both read zero, which no accelerometer does
};

/// Largest readings of a sensor's axes; 0 where they are not known.
struct ImuRange {
  double gyro = 0;  ///< [rad/s]
  double acc = 0;   ///< [m/s^2]
};

/// Refuses up to three samples in a row that lie far from those before and after them, which agree with each other. A
/// motion is no spike: what a body does within 5 ms, the sample after shows as well. Holds back what it doubts until
/// the next samples show it; the others pass.
class ImuSpikes {
 public:
  /// Pre: stamps differ from those that are held. Appends to `out` what has been judged, in the order of arrival.
  void push(const ImuSample& sample, std::vector<ImuSample>& out);
  /// There are no more: what is held is refused.
  void finish() { refuse(); }
  bool holds(TimeNs t) const;
  std::uint64_t refused() const { return refused_; }
  void forget();

 private:
  static constexpr std::size_t kMaxInARow = 3, kRecent = 32;
  static constexpr TimeNs kLongest = 50'000'000;  ///< from the sample before to the last of several

  void accept(const ImuSample& sample, std::vector<ImuSample>& out);
  void accept_held(std::vector<ImuSample>& out);
  void refuse();
  bool far(const ImuSample& from, const ImuSample& to) const;
  bool are_spikes(const ImuSample& after) const;
  double usual_step(int axis) const;

  std::optional<ImuSample> last_;  ///< the newest that passed
  std::vector<ImuSample> held_;
  std::array<std::array<double, 6>, kRecent> steps_{};  ///< between neighbours that passed, of every axis
  std::size_t step_count_ = 0;
  std::uint64_t refused_ = 0;
};

/// Marks readings at the end of a sensor's range, and a sensor that repeats what it read. Where the range is not
/// declared it is found: an extreme reading that an axis repeats exactly while others vary, or that steep peaks, as
/// those of steps, meet exactly again and again. Holds back readings that are repeated, up to 0.2 s, until it is known
/// whether it means anything.
class ImuRepeats {
 public:
  explicit ImuRepeats(const ImuRange& declared) : declared_(declared) {}

  /// Appends to `out` what has been judged, with its faults marked.
  void push(const ImuSample& sample, std::vector<ImuSample>& out);
  /// There are no more: what is held passes.
  void finish(std::vector<ImuSample>& out) { release(out); }
  bool holds(TimeNs t) const;
  void forget();
  /// The range where readings were found to end, not as it was declared; 0: not found.
  ImuRange found() const { return {limit_[0], limit_[1]}; }
  const ImuFindings& findings() const { return findings_; }

 private:
  static constexpr std::size_t kRecent = 64;

  /// How long something has been repeated.
  struct Run {
    TimeNs since = 0;  ///< the first reading of it
    int repeats = 0;   ///< beyond that one
    void take(bool same, TimeNs t);
  };

  /// What may be the end of a sensor's range.
  struct End {
    double value = 0;         ///< the largest reading, met after a steep step
    int hits = 0, below = 0;  ///< readings of exactly that size at steep peaks, and of a little less
  };
  /// Of an axis: whether the last step was steep, and whether the last reading was one of the hits.
  struct Peak {
    bool steep = false, at_end = false;
  };

  double limit(int sensor) const;
  void note_extremes(const ImuSample& sample);
  void note_steep_ends(const ImuSample& sample);
  bool is_plateau(int axis, const ImuSample& sample, std::span<const bool> changed) const;
  bool varies(std::size_t what, std::ptrdiff_t percent) const;
  void mark_clipped(ImuSample& sample) const;
  void count(const ImuSample& sample);
  void release(std::vector<ImuSample>& out);
  bool doubts_axes(const ImuSample& sample);
  bool doubts_sensor(int sensor, const ImuSample& sample);

  ImuRange declared_;
  std::array<double, 2> limit_{};    ///< as found, of gyro and accelerometer; 0: not
  std::array<double, 2> never_{};    ///< up to here it was found, and larger readings came
  std::array<double, 2> largest_{};  ///< reading of any axis
  std::array<End, 2> end_{};
  std::array<Peak, 6> peak_{};
  std::optional<ImuSample> last_;  ///< the newest that was pushed
  std::vector<ImuSample> held_;
  std::array<Run, 6> axis_run_{};   ///< of a reading of one axis
  std::array<Run, 2> stuck_run_{};  ///< of all axes of a sensor
  /// Whether axes 0 to 5, and sensors 6 and 7, differed from the sample before: rings.
  std::array<std::array<bool, kRecent>, 8> changed_{};
  std::size_t changed_count_ = 0;
  ImuFindings findings_;
};

/// Both, one after the other.
class ImuScreen {
 public:
  explicit ImuScreen(const ImuRange& declared = {}) : repeats_(declared) {}

  /// What has been judged by now, in the order of arrival. Valid until the next call.
  std::span<const ImuSample> push(const ImuSample& sample);
  std::span<const ImuSample> finish();
  /// Whether a sample of this time waits for the next ones.
  bool holds(TimeNs t) const { return spikes_.holds(t) || repeats_.holds(t); }
  /// What comes next does not continue what came before.
  void forget();
  ImuFindings findings() const;
  /// What the user should know: ranges that were found and not declared, with their keys.
  std::vector<std::string> warnings() const;

 private:
  ImuSpikes spikes_;
  ImuRepeats repeats_;
  std::vector<ImuSample> passed_, judged_;
};

}  // namespace aslio::stream
