#pragma once

#include <algorithm>

#include "aslio/simulator/simulation.hpp"
#include "pipeline/runs.hpp"

namespace aslio::test {

/// What a recording of the first `duration` seconds would hold: IMU samples, and each packet once it is complete.
inline Recording record(const simulator::Simulation& simulation, double duration) {
  Recording out;
  std::size_t sample = 0;
  const auto& imu = simulation.imu().samples;
  const auto imu_until = [&](TimeNs t) {
    for (; sample < imu.size() && imu[sample].t <= t; ++sample) out.push_back(imu[sample]);
  };
  const auto packets = static_cast<std::size_t>(to_ns(duration) / simulator::Simulation::kPacketPeriod);
  for (std::size_t i = 0; i < std::min(packets, simulation.packet_count()); ++i) {
    LidarPacket packet = simulation.packet(i).packet;
    imu_until(packet.stamp + simulator::Simulation::kPacketPeriod);
    out.push_back(std::move(packet));
  }
  return out;
}

}  // namespace aslio::test
