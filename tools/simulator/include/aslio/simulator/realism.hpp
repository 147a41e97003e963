#pragma once
/// What real sensors, mounts, surfaces and people do, and clean simulations leave out. All of it is off by default.
///
/// Each part has its magnitudes. The preset fills those that a scene file leaves out; a magnitude of 0 is off.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace aslio::config {
class Binder;
}

namespace aslio::simulator {

/// Time constant with which a sensor warms from switching on, in ranges and in biases [s].
inline constexpr double kWarmUpTime = 300;

enum class RealismPreset : std::uint8_t {
  none,       ///< nothing beyond the other keys of the scene
  realistic,  ///< every part of `parts`, with values of the literature (docs/simulator.md)
};

/// The sensor file is wrong. Drawn by the seed: direction and axis at random.
struct MountRealism {
  double angle = 0;   ///< drawn from [1/5, 1] of it [deg]
  double offset = 0;  ///< drawn from [3/10, 1] of it [m]
};

/// The stamps of the IMU, against the clock of the LiDAR.
struct ClockRealism {
  double drift = 0;   ///< drawn from [1/20, 1] of it, either sign [ppm]
  double jitter = 0;  ///< standard deviation, drawn from [1/10, 1] of it [us]
};

/// Systematic errors of a range, and noise that depends on the echo.
struct RangingRealism {
  double offset = 0;        ///< of the sensor, uniform up to this [m]
  double line = 0;          ///< of each line, uniform up to this [m]
  double incidence = 0;     ///< too short by this at 10 m and 80 deg: grows with range and tangent, at most 0.2 m [m]
  double reflectivity = 0;  ///< of a black surface against a white one, uniform up to this [m]
  double near = 0;          ///< at range 0, uniform up to this; falls to 0 at 2 m with the square [m]
  double warm_up = 0;       ///< drift from switching on, uniform up to this; time constant 300 s [m]
  double noise_growth = 0;  ///< at the end of its reach an echo has 1 + this times the noise
};

/// Multiples of the values of each material.
struct SurfaceRealism {
  double unevenness = 0;  ///< over metres
  double relief = 0;      ///< over centimetres
};

/// Multiples of the values of each gait.
struct GaitRealism {
  double heel = 0;    ///< the jolt of each step
  double sway = 0;    ///< from side to side with every second step
  double tremor = 0;  ///< of the hand, 8 to 12 Hz, about all axes
  double turns = 0;   ///< roll and pitch of the head in each turn
};

struct ImuRealism {
  double filter = 0;       ///< a sample is the mean over so many sample times
  double temperature = 0;  ///< warming from switching on, time constant 300 s [K]
  double vibration = 0;    ///< of the LiDAR's motor, amplitude per axis [m/s^2]
};

/// All magnitudes; 0: off.
struct Realism {
  MountRealism mount;
  ClockRealism clock;
  RangingRealism ranging;
  double footprint = 0;  ///< multiple of the data sheet's, on every pulse
  SurfaceRealism surface;
  double glass = 0;  ///< share of the pulses for which a pane is clear: they pass it or are mirrored
  GaitRealism gait;
  ImuRealism imu;
};

/// `realism:` of a scene file.
struct RealismParams {
  RealismPreset preset = RealismPreset::none;
  std::vector<std::string> parts = {"mount", "clock", "ranging", "footprint", "surface", "glass", "gait", "imu"};

  struct Mount {
    std::optional<double> angle, offset;
    static void describe(config::Binder& b, Mount& params);
  };
  struct Clock {
    std::optional<double> drift, jitter;
    static void describe(config::Binder& b, Clock& params);
  };
  struct Ranging {
    std::optional<double> offset, line, incidence, reflectivity, near, warm_up, noise_growth;
    static void describe(config::Binder& b, Ranging& params);
  };
  struct Surface {
    std::optional<double> unevenness, relief;
    static void describe(config::Binder& b, Surface& params);
  };
  struct Gait {
    std::optional<double> heel, sway, tremor, turns;
    static void describe(config::Binder& b, Gait& params);
  };
  struct Imu {
    std::optional<double> filter, temperature, vibration;
    static void describe(config::Binder& b, Imu& params);
  };
  Mount mount;
  Clock clock;
  Ranging ranging;
  std::optional<double> footprint;
  Surface surface;
  std::optional<double> glass;
  Gait gait;
  Imu imu;
  static void describe(config::Binder& b, RealismParams& params);
};

/// The magnitudes with the preset's and the given values.
Realism realism(const RealismParams& params);

}  // namespace aslio::simulator
