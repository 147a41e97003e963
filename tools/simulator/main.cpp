/// Command line of the analytic world.

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <string>

#include "aslio/core/errors.hpp"
#include "aslio/simulator/analytic_world.hpp"

int main(int argc, char** argv) {
  aslio::simulator::Options options;
  std::string output;
  bool quiet = false, no_noise = false;
  CLI::App app("Simulates a walk through two rooms and a corridor with a Livox Avia: world.bag and truth.tum.");
  app.add_option("--output", output, "folder for the recording; created if need be")->required();
  app.add_option("--seed", options.seed, "seed of all noise")->capture_default_str();
  app.add_option("--scale", options.duration_scale, "stretches the 20 s walk; turn rates are divided by it")
      ->check(CLI::Range(0.5, 100.0))
      ->capture_default_str();
  app.add_option("--imu-rate", options.imu_rate, "IMU samples per second")
      ->check(CLI::Range(20.0, 10000.0))
      ->capture_default_str();
  app.add_flag("--people", options.people, "two people walk about");
  app.add_flag("--no-noise", no_noise, "ideal LiDAR and IMU");
  app.add_flag("--quiet", quiet, "no progress");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  options.lidar_noise = options.imu_noise = !no_noise;
  try {
    const aslio::simulator::AnalyticWorld world(options);
    const bool terminal = isatty(STDERR_FILENO) != 0;
    const int step = terminal ? 5 : 25;  // in percent: a line that is redrawn, or a few plain ones
    int shown = 0;
    aslio::simulator::write_recording(world, output, [&](double share) {
      const int percent = static_cast<int>(100 * share);
      if (quiet || percent / step == shown) return;
      shown = percent / step;
      std::fprintf(stderr, terminal ? "\rsimulating: %3d %%" : "simulating: %3d %%\n", percent);
    });
    if (!quiet)
      std::fprintf(stderr, "%swrote %s/world.bag and truth.tum\n", terminal ? "\r\033[K" : "", output.c_str());
  } catch (const aslio::ConfigError& error) {
    std::fprintf(stderr, "\naslio_simulate_world: %s\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "\naslio_simulate_world: %s\n", error.what());
    return 3;
  }
  return 0;
}
