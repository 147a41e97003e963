#pragma once
/// What all histories but `none` share: the points of earlier updates still inside the window, how many of them take
/// part, and what they may match. (HIS-1, HIS-4)

#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

#include "aslio/config/binder.hpp"
#include "aslio/stages/history.hpp"

namespace aslio {
struct MatchRecord;  // stages/estimator.hpp
}

namespace aslio::plugins {

/// How a point enters whose match a gate refused at its own update: as one that found no surface, whatever max_residual
/// says, or by its residual as any other.
enum class Refused : std::uint8_t { enter, by_residual };

/// Rules of re-use; the defaults take every point as it is.
struct Reuse {
  bool self_match_exclusion = false;
  HistoryCovariance covariance = HistoryCovariance::all;
  std::optional<double> cap = std::nullopt;           ///< history points per fresh point; 0: no history
  std::optional<double> age_taper = std::nullopt;     ///< [s]
  std::optional<double> gate = std::nullopt;          ///< [sigma]
  std::optional<double> max_residual = std::nullopt;  ///< [m]
  Refused refused = Refused::enter;
  bool redeskew = false;

  static void describe(config::Binder& b, Reuse& p);
};

void describe_self_match_exclusion(config::Binder& b, bool& value);
void describe_covariance(config::Binder& b, HistoryCovariance& value);
void describe_age_taper(config::Binder& b, std::optional<double>& value);
void describe_refused(config::Binder& b, Refused& value);
inline constexpr std::string_view kCapDoc = "most history points per fresh point";
inline constexpr std::string_view kGateDoc = "largest residual of a history point that takes part";
inline constexpr std::string_view kMaxResidualDoc =
    "largest residual at its own update with which a matched point enters the history; one that found no surface "
    "enters";

/// With `redeskew`, old points follow the newest posterior: between two updates the IMU moves them, with the
/// velocity and biases that it had then (HIS-5).
///
/// Pre: points of an update come in time order, and history_begin never decreases from window to window (what lies
/// before it is forgotten).
class WindowHistory : public HistoryPolicy {
 public:
  HistorySelection select(const Window& window) final;
  double gate(double sigma) const final {
    return reuse_.gate ? *reuse_.gate * sigma : std::numeric_limits<double>::infinity();
  }
  void commit(const Window& window, const Update& update) final;
  void reset() final;

 protected:
  explicit WindowHistory(const Reuse& reuse) : reuse_(reuse) {}

 private:
  /// When the points of an update entered the map (if they did).
  struct UpdateEnd {
    std::uint32_t sequence = 0;
    TimeNs t = 0;
  };

  /// HistoryPoint::residual: what max_residual judges a point by.
  float residual_of(const MatchRecord& match) const;
  void link(const Window& window, const Update& update);
  /// Where the points of each update of links_ belong, seen from where they are.
  void follow_imu();
  void forget(TimeNs until);
  std::size_t most(const Window& window, std::size_t offered) const;

  /// An update, and the motion since the one before. Fresh intervals tile the stream, so that links are a chain.
  struct Link {
    std::uint32_t sequence = 0;
    TimeNs end = 0;
    Pose posterior;        ///< T_W_I at `end`
    Pose predicted_begin;  ///< of the update before, seen from the end that the IMU predicted
    Pose move;             ///< in W
  };

  Reuse reuse_;
  std::vector<HistoryPoint> points_;  ///< in time order; those before head_ are forgotten
  std::size_t head_ = 0;
  std::vector<HistoryPoint> selected_;
  std::vector<Link> links_;         ///< in time order, of updates whose points may still be inside
  std::vector<UpdateEnd> ends_;     ///< in time order, of windows that may still be inside a later one
  std::uint32_t max_stamp_ = 0;     ///< newest update older than any window to come
  double matched_per_fresh_ = 1.0;  ///< points offered to matching per raw point, at the last update
};

}  // namespace aslio::plugins
