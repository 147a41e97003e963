/// The IMU of a simulated walk, without errors, leads back to the walk: by the framework's own motion stage with an
/// error of second order, by a fourth-order integrator to a fraction of a millimetre.
#include <spdlog/sinks/null_sink.h>

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>

#include "aslio/simulator/imu_params.hpp"
#include "aslio/simulator/scene.hpp"
#include "aslio/stages/motion.hpp"
#include "register_all.hpp"

using namespace aslio;
using namespace aslio::simulator;

namespace {

constexpr double kDuration = 60;  ///< [s]

/// The round of the quickstart scene, often enough to last a minute.
std::unique_ptr<Motion> minute_of_walking() {
  const Scene scene = load_scene(ASLIO_SOURCE_DIR "/configs/scenes/quickstart.yaml").scene;
  std::vector<Vec2> points;
  for (const RoutePoint& p : scene.route) points.emplace_back(p.x, p.y);
  WalkParams params = scene.walk;
  params.laps = 4;
  return make_route_walk(Route(std::move(points)), Ground{}, params, 1);
}

std::vector<ImuSample> perfect_imu(const Motion& motion, double rate) {
  ImuParams params;
  params.preset = ImuPreset::perfect;
  params.gyro_noise = params.acc_noise = 0;
  params.rate = rate;
  return simulate_imu(motion, 0, kDuration, imu_model(params), 1).samples;
}

double midpoint_error(const Motion& motion, double rate) {
  exec::Executor exec{1};
  const SensorModel sensor;
  const auto log = std::make_shared<spdlog::logger>("test", std::make_shared<spdlog::sinks::null_sink_st>());
  plugin::Catalog catalog;
  plugins::register_all(catalog);
  const plugin::Entry* entry = catalog.find("motions", "imu_midpoint");
  REQUIRE(entry != nullptr);
  const BuildContext context{.exec = exec, .sensor = sensor, .log = log, .order_seed = 0};
  const std::unique_ptr<Stage> stage = entry->make(entry->defaults().get(), context);
  const auto& model = dynamic_cast<const MotionModel&>(*stage);

  const MotionState start = motion.at(0), end = motion.at(kDuration);
  NavState state;
  state.R = start.R;
  state.p = start.p;
  state.v = start.v;
  state.g = Vec3(0, 0, -kStandardGravity);
  const std::vector<ImuSample> samples = perfect_imu(motion, rate);
  REQUIRE(samples.back().t == to_ns(kDuration));
  for (std::size_t k = 1; k < samples.size(); ++k) model.step(state, samples[k - 1], samples[k]);
  return (state.p - end.p).norm();
}

struct Strapdown {
  Eigen::Vector4d q;  ///< x y z w
  Vec3 p, v;
};

Strapdown derivative(const Strapdown& s, const Vec3& gyro, const Vec3& acc) {
  const Eigen::Quaterniond q(s.q), w(0, gyro.x(), gyro.y(), gyro.z());
  return {0.5 * (q * w).coeffs(), s.v, q.normalized() * acc - Vec3(0, 0, kStandardGravity)};
}

Strapdown moved(const Strapdown& s, double h, const Strapdown& d) {
  return {s.q + h * d.q, s.p + h * d.p, s.v + h * d.v};
}

/// Error of the classical Runge-Kutta method on samples at twice its rate: begin, middle and end of each step.
double runge_kutta_error(const Motion& motion, double rate) {
  const std::vector<ImuSample> samples = perfect_imu(motion, 2 * rate);
  const MotionState start = motion.at(0), end = motion.at(kDuration);
  Strapdown s{Eigen::Quaterniond(start.R).coeffs(), start.p, start.v};
  const double h = 1 / rate;
  for (std::size_t k = 2; k < samples.size(); k += 2) {
    const ImuSample &from = samples[k - 2], &middle = samples[k - 1], &to = samples[k];
    const Strapdown a = derivative(s, from.gyro, from.acc);
    const Strapdown b = derivative(moved(s, h / 2, a), middle.gyro, middle.acc);
    const Strapdown c = derivative(moved(s, h / 2, b), middle.gyro, middle.acc);
    const Strapdown d = derivative(moved(s, h, c), to.gyro, to.acc);
    s = moved(moved(moved(moved(s, h / 6, a), h / 3, b), h / 3, c), h / 6, d);
    s.q.normalize();
  }
  return (s.p - end.p).norm();
}

}  // namespace

TEST_CASE("a minute of dead reckoning by the framework's midpoint misses by little, and with the square of the step") {
  const auto walk = minute_of_walking();
  REQUIRE(walk->duration() >= kDuration);
  const double at_200 = midpoint_error(*walk, 200), at_2000 = midpoint_error(*walk, 2000);
  CAPTURE(at_200, at_2000, at_200 / at_2000);
  CHECK(at_200 <= 0.3);
  CHECK(at_200 / at_2000 > 80);
  CHECK(at_200 / at_2000 < 125);
  WARN("after 60 s: " << at_200 << " m at 200 Hz, " << at_2000 << " m at 2 kHz, ratio " << at_200 / at_2000);
}

TEST_CASE("a minute of dead reckoning by a fourth-order integrator misses by less than 0.1 mm at 2 kHz") {
  const double error = runge_kutta_error(*minute_of_walking(), 2000);
  CHECK(error < 1e-4);
  WARN("after 60 s: " << error << " m");
}
