#include "aslio/simulator/imu_model.hpp"

#include <cmath>

#include "aslio/simulator/random.hpp"
#include "purposes.hpp"

namespace aslio::simulator {
namespace {

Vec3 normal3(RandomStream& random) {
  const double x = random.normal(), y = random.normal(), z = random.normal();
  return {x, y, z};
}

Vec3 uniform3(RandomStream& random, double bound) {
  const double x = random.uniform(-bound, bound), y = random.uniform(-bound, bound), z = random.uniform(-bound, bound);
  return {x, y, z};
}

Vec3 clipped(const Vec3& v, double range) { return v.cwiseMax(-range).cwiseMin(range); }

}  // namespace

ImuRecord simulate_imu(const Motion& motion, TimeNs begin, double duration, const ImuModel& model,
                       const SensorModel& sensor, bool noise, std::uint64_t seed) {
  RandomStream initial(seed, purpose::kInitialBias), walk(seed, purpose::kBiasWalk);
  RandomStream gyro_noise(seed, purpose::kGyroNoise), acc_noise(seed, purpose::kAccNoise);
  const Vec3 gravity(0, 0, -kStandardGravity);
  const double root_rate = std::sqrt(model.rate);
  Vec3 gyro_bias = Vec3::Zero(), acc_bias = Vec3::Zero();
  if (noise) {
    gyro_bias = uniform3(initial, model.initial_gyro_bias);
    acc_bias = uniform3(initial, model.initial_acc_bias);
  }
  ImuRecord record;
  const auto count = static_cast<std::int64_t>(std::floor(duration * model.rate + 1e-6)) + 1;
  for (std::int64_t k = 0; k < count; ++k) {
    const TimeNs since = to_ns(static_cast<double>(k) / model.rate);
    const MotionState m = motion.at(to_seconds(since));
    ImuSample sample{begin + since, m.w + gyro_bias, m.R.transpose() * (m.a - gravity) + acc_bias};
    record.gyro_bias.push_back(gyro_bias);
    record.acc_bias.push_back(acc_bias);
    if (noise) {
      sample.gyro += sensor.gyro_noise * root_rate * normal3(gyro_noise);
      sample.acc += sensor.acc_noise * root_rate * normal3(acc_noise);
      gyro_bias += sensor.gyro_bias_walk / root_rate * normal3(walk);
      acc_bias += sensor.acc_bias_walk / root_rate * normal3(walk);
    }
    sample.gyro = clipped(sample.gyro, model.gyro_range);
    sample.acc = clipped(sample.acc, model.acc_range);
    record.samples.push_back(sample);
  }
  return record;
}

}  // namespace aslio::simulator
