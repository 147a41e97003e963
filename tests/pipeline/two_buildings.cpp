#include "pipeline/two_buildings.hpp"

#include <numbers>

#include "aslio/simulator/avia.hpp"
#include "aslio/simulator/imu_model.hpp"

namespace aslio::test {

namespace {

using simulator::Box;
using simulator::BoxScene;

/// A yard of 24 deg to either side seen from the origin: back wall, two side walls, floor, roof, and a few boxes.
std::vector<Box> building(double side) {
  const auto box = [&](const Vec3& low, const Vec3& high) {
    Box b = simulator::box_between(low, high);
    b.centre.head<2>() *= side;  // the other building: turned by half a turn
    return b;
  };
  return {box({8, -3.2, -1.5}, {8.3, 3.2, 2}),    box({5.5, -3.2, -1.5}, {8, -2.9, 2}),
          box({5.5, 2.9, -1.5}, {8, 3.2, 2}),     box({5.5, -3.2, -1.7}, {8.3, 3.2, -1.5}),
          box({5.5, -3.2, 2}, {8.3, 3.2, 2.2}),   box({6.5, -1.8, -1.5}, {7.2, -0.9, 0.4}),
          box({6.9, 0.6, -1.5}, {7.6, 1.6, 1.1}), box({6.1, 1.9, -1.5}, {6.6, 2.4, -0.2})};
}

BoxScene scene() {
  std::vector<Box> boxes = building(1);
  for (const Box& b : building(-1)) boxes.push_back(b);
  return BoxScene(std::move(boxes));
}

simulator::Gait standing() { return {.height = 0, .roll = 0, .pitch = 0}; }

}  // namespace

TwoBuildings::TwoBuildings(double turn_duration, double duration)
    : scene_(scene()),
      motion_({{0, 0, 0, 0, 0}, {duration, 0, 0, 0, 0}}, {{kTurnBegin, turn_duration, std::numbers::pi}}, standing(),
              1) {
  const auto imu = simulator::simulate_imu(motion_, kBegin, duration, {}, sensor, true, 1);
  constexpr TimeNs period = kSecond / 10;
  std::uint32_t sweep = 0;
  for (const ImuSample& sample : imu.samples) {
    recording.push_back(sample);
    const TimeNs begin = kBegin + sweep * period;
    if (sample.t >= begin + period) recording.push_back(packet(sweep++, begin));
  }
}

Pose TwoBuildings::pose(TimeNs t) const {
  const auto m = motion_.at(to_seconds(t - kBegin));
  return {m.R, m.p};
}

LidarPacket TwoBuildings::packet(std::uint32_t sweep, TimeNs begin) const {
  LidarPacket out;
  out.stamp = begin;
  out.sweep_id = sweep;
  for (TimeNs t = begin; t < begin + kSecond / 10; t += simulator::avia::kFiringPeriod) {
    const Pose T = pose(t) * sensor.T_imu_lidar;
    const auto beams = simulator::avia::firing(to_seconds(t - kBegin));
    for (std::size_t line = 0; line < beams.size(); ++line) {
      const simulator::Hit hit = scene_.cast(T.p, T.R * beams[line].direction);
      if (hit.solid < 0 || hit.cos_incidence < 0.17) continue;
      const Eigen::Vector3f p = (hit.range * beams[line].direction).cast<float>();
      TimedPoint point;
      point.x = p.x();
      point.y = p.y();
      point.z = p.z();
      point.t = t;
      point.sweep_id = sweep;
      point.line = static_cast<std::uint8_t>(line);
      out.points.push_back(point);
    }
  }
  return out;
}

}  // namespace aslio::test
