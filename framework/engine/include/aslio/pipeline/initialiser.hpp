#pragma once
/// Where the first state comes from (docs/equations.md INI-1..).

#include <optional>
#include <string>

#include "aslio/pipeline/sweep_motion.hpp"
#include "aslio/stages/estimator.hpp"
#include "aslio/stream/measurement_stream.hpp"

namespace aslio::pipeline {

enum class InitialisationMode : std::uint8_t { automatic, static_start, dynamic_start };

struct InitialisationParams {
  InitialisationMode mode = InitialisationMode::automatic;
  double time = 0.1;            ///< [s] of IMU data averaged
  double static_acc_std = 0.3;  ///< [m/s^2]
  double static_rate = 0.05;    ///< [rad/s]
  bool register_sweeps = true;  ///< rest is proved, and a velocity found, by the first sweeps (INI-6)
  /// The mean specific force of the start is taken for one of the length of gravity, as are all after it (INI-7).
  bool scale_specific_force = false;

  static void describe(config::Binder& b, InitialisationParams& p);
};

/// What was found, for the summary.
struct Initialisation {
  InitialState initial;
  double mean_force = 0;  ///< length of the mean specific force [m/s^2]; 0 without IMU
  std::string verdict;    ///< "static: |mean rate| 0.003 rad/s, acc std 0.04 m/s^2 over 21 samples"
  /// Why the first velocity may be wrong, for the status of the run; empty: nothing speaks against it.
  std::string doubt;
};

/// How much later the first window begins for an order seed [ns], in [0, 0.1 s): 0 for 0, and spread evenly over any
/// run of seeds (multiples of the golden ratio).
TimeNs start_offset(std::uint64_t order_seed);

/// Tries to find the initial state at or after the first point and `offset`. Nothing while the IMU data does not yet
/// reach over `params.time`. Throws DataError when acceleration cannot be gravity in m/s^2 (|mean| outside [7, 13] at
/// rest, [3, 20] in motion), naming the factor.
std::optional<Initialisation> initialise(const stream::MeasurementStream& stream, const InitialisationParams& params,
                                         const SensorModel& sensor, TimeNs offset = 0);

/// What the first sweeps make of a start (eq. INI-6): a rest that they contradict is none, and a velocity that they
/// bind is known; otherwise it says what is doubted. `heading`: R_W_I whose heading is kept; without it the yaw is
/// zero. Adds to the verdict.
void apply_sweep_motion(Initialisation& found, const SweepMotion& motion, const Mat3* heading = nullptr);

/// What the first sweeps say of a rest that the user has declared: it stays one, and where they show a motion the run
/// is doubted. Adds to the verdict.
void doubt_declared_rest(Initialisation& found, const SweepMotion& motion);

/// The initial state for an estimator without IMU: `offset` after the first point, in the origin of W, the axes of W
/// those of I.
std::optional<Initialisation> initialise_without_imu(const stream::MeasurementStream& stream, TimeNs offset = 0);

}  // namespace aslio::pipeline
