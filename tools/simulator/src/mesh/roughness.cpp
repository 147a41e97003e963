#include "mesh/roughness.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "aslio/core/spread.hpp"

namespace aslio::simulator {
namespace {

constexpr double kMillimetre = 1e-3;
/// Distances of the lattice [m]: about half of the wavelength.
constexpr double kUnevennessStep = 1.0, kReliefStep = 0.04;
/// Inverse of the standard deviation that smooth interpolation leaves of unit variance, mean over a cell: 0.743^(3/2).
constexpr double kLost = 1 / 0.6404;

double smooth(double u) { return u * u * (3 - 2 * u); }

/// Smooth noise of unit variance: uniform values on the corners of a cubic lattice, interpolated.
double lattice_noise(const Vec3& p, double step, std::uint64_t seed) {
  std::array<std::uint64_t, 3> cell{};
  std::array<double, 3> w{};
  for (int axis = 0; axis < 3; ++axis) {
    const double x = p[axis] / step, floor = std::floor(x);
    cell.at(static_cast<std::size_t>(axis)) = static_cast<std::uint64_t>(static_cast<std::int64_t>(floor));
    w.at(static_cast<std::size_t>(axis)) = smooth(x - floor);
  }
  double sum = 0;
  for (unsigned corner = 0; corner < 8; ++corner) {
    const std::uint64_t i = corner & 1U, j = corner >> 1U & 1U, k = corner >> 2U;
    const std::uint64_t key =
        mixed(seed + (cell[0] + i) * 0x9e3779b97f4a7c15U + mixed((cell[1] + j) * 0xbf58476d1ce4e5b9U + cell[2] + k));
    const double value = static_cast<double>(key >> 11U) * 0x1p-53 - 0.5;
    sum += (i ? w[0] : 1 - w[0]) * (j ? w[1] : 1 - w[1]) * (k ? w[2] : 1 - w[2]) * value;
  }
  return std::sqrt(12.0) * kLost * sum;
}

}  // namespace

// Unevenness: DIN 18202 allows 10 mm over 4 m for finished walls and 12 mm for floors, which is some 3 mm of standard
// deviation. Relief: joints of brickwork 5 to 10 mm, texture depth of asphalt 1 to 2 mm, blades of grass 20 to 50 mm.
MaterialRoughness roughness_of(std::uint8_t reflectivity) {
  const auto of = [](double unevenness, double relief) {
    return MaterialRoughness{unevenness * kMillimetre, relief * kMillimetre};
  };
  switch (reflectivity) {
    case material::kPlaster:
    case material::kWhitePaint:
      return of(3, 0.3);
    case material::kConcrete:
      return of(3, 0.7);
    case material::kAsphalt:
      return of(3, 1.5);
    case material::kBrick:
      return of(3, 2.5);
    case material::kGrass:
      return of(10, 12);
    case material::kFoliage:
      return of(0, 10);
    case material::kCloth:
      return of(2, 2);
    case material::kGlass:  // float glass
      return of(0, 0);
    default:
      return of(1, 0.3);
  }
}

Roughness::Roughness(const SurfaceRealism& surface, std::uint64_t world_seed)
    : surface_(surface), seed_(mixed(world_seed)) {}

double Roughness::displacement(const Vec3& p_W, std::uint8_t reflectivity) const {
  const MaterialRoughness rough = roughness_of(reflectivity);
  const double unevenness = surface_.unevenness * rough.unevenness, relief = surface_.relief * rough.relief;
  double sum = 0;
  if (unevenness > 0) sum += unevenness * lattice_noise(p_W, kUnevennessStep, seed_);
  if (relief > 0) sum += relief * lattice_noise(p_W, kReliefStep, seed_ + 1);
  return sum;
}

void Roughness::apply(const Vec3& origin, const Vec3& direction, SurfaceHit& hit) const {
  if (flat() || hit.moving || !std::isfinite(hit.range)) return;
  const Vec3 p_W = origin + hit.range * direction;
  const double along = hit.normal.dot(direction) > 0 ? 1 : -1;
  const double shift = along * displacement(p_W, hit.material) / std::max(hit.cos_incidence, kSteepest);
  hit.range = std::max(0.5 * hit.range, hit.range + shift);
}

}  // namespace aslio::simulator
