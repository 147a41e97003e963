#include "worlds/flight.hpp"

#include "worlds/curved.hpp"

namespace aslio::simulator {

void add_ramps(Ground& ground, const Flight& flight, double heading, double begin, double up) {
  const double reach = kReach * flight.tread;
  for (int k = 0; k < flight.steps; ++k)
    ground.ramps.push_back({heading, begin + k * flight.tread - reach, 2 * reach, up * flight.rise});
}

void add_steps(MeshBuilder& builder, const Flight& flight, std::uint8_t reflectivity) {
  const double slope = flight.rise / flight.tread, right = flight.right, left = flight.left;
  const auto soffit = [&](double x) { return slope * x - flight.thickness; };
  for (int k = 0; k < flight.steps; ++k) {
    const double x0 = k * flight.tread, x1 = x0 + flight.tread, z0 = k * flight.rise, z1 = z0 + flight.rise;
    builder.quad({x0, right, z0}, {x0, left, z0}, {x0, left, z1}, {x0, right, z1}, reflectivity);
    if (k + 1 == flight.steps) break;
    builder.quad({x0, right, z1}, {x1, right, z1}, {x1, left, z1}, {x0, left, z1}, reflectivity);
    for (const double y : {right, left})
      builder.quad({x0, y, soffit(x0)}, {x1, y, soffit(x1)}, {x1, y, z1}, {x0, y, z1}, reflectivity);
  }
  const double end = flight.length();
  builder.quad({0, right, soffit(0)}, {0, left, soffit(0)}, {end, left, soffit(end)}, {end, right, soffit(end)},
               reflectivity);
}

void add_handrail(MeshBuilder& builder, const Flight& flight, double y, bool posts) {
  constexpr double kUp = 0.9, kThick = 0.022, kPost = 0.014;
  const double slope = flight.rise / flight.tread, end = flight.length();
  const auto line = [&](double x) { return slope * x + 0.5 * flight.rise; };
  curved::add_bar(builder, {0, y, line(0) + kUp}, {end, y, line(end) + kUp}, kThick, material::kWood);
  if (!posts) return;
  for (int k = 0; k + 1 < flight.steps; ++k) {
    const double x = (k + 0.5) * flight.tread;
    curved::add_bar(builder, {x, y, (k + 1) * flight.rise}, {x, y, line(x) + kUp}, kPost, material::kMetal);
  }
  for (const double up : {0.3, 0.6})
    curved::add_bar(builder, {0, y, line(0) + up}, {end, y, line(end) + up}, kPost, material::kMetal);
}

}  // namespace aslio::simulator
