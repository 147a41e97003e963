#include <algorithm>
#include <array>
#include <numeric>

#include "velodyne.hpp"

namespace aslio::io::packets {
namespace {

template <std::size_t N>
std::array<VelodyneLaser, N> with_lines(std::array<VelodyneLaser, N> lasers) {
  for (VelodyneLaser& laser : lasers) {
    laser.line = static_cast<int>(std::count_if(
        lasers.begin(), lasers.end(), [&](const VelodyneLaser& other) { return other.elevation < laser.elevation; }));
  }
  return lasers;
}

/// Vertical offsets of VLP-16 follow from the elevation: the beams meet behind the origin. The manual's table, in mm.
std::array<VelodyneLaser, 16> vlp16() {
  constexpr std::array<double, 8> kHeights = {11.2, 9.7, 8.1, 6.6, 5.1, 3.7, 2.2, 0.7};
  std::array<VelodyneLaser, 16> lasers{};
  for (std::size_t i = 0; i < 16; ++i) {
    const std::size_t pair = i / 2;
    lasers[i].elevation = (i % 2 == 0 ? -15.0 : 1.0) + 2.0 * static_cast<double>(pair);
    lasers[i].height = 1e-3 * (i % 2 == 0 ? kHeights[pair] : -kHeights[7 - pair]);
  }
  return with_lines(lasers);
}

std::array<VelodyneLaser, 16> vlp16_hires() {
  constexpr std::array<double, 8> kHeights = {7.4, 6.5, 5.5, 4.6, 3.7, 2.7, 1.8, 0.9};
  std::array<VelodyneLaser, 16> lasers{};
  for (std::size_t i = 0; i < 16; ++i) {
    const std::size_t pair = i / 2;
    lasers[i].elevation = (i % 2 == 0 ? -10.0 : 2.0 / 3.0) + 4.0 / 3.0 * static_cast<double>(pair);
    lasers[i].height = 1e-3 * (i % 2 == 0 ? kHeights[pair] : -kHeights[7 - pair]);
  }
  return with_lines(lasers);
}

/// Steps of 4/3 degrees; the lower half alternates with the upper one.
std::array<VelodyneLaser, 32> hdl32e() {
  std::array<VelodyneLaser, 32> lasers{};
  for (std::size_t i = 0; i < 32; ++i) {
    const std::size_t pair = i / 2;
    const auto step = static_cast<double>(pair);
    lasers[i].elevation = (i % 2 == 0 ? -92.0 / 3.0 : -28.0 / 3.0) + 4.0 / 3.0 * step;
  }
  return with_lines(lasers);
}

std::array<VelodyneLaser, 32> vlp32c() {
  constexpr std::array<double, 32> kElevations = {-25,    -1,    -1.667, -15.639, -11.31, 0,     -0.667, -8.843,
                                                  -7.254, 0.333, -0.333, -6.148,  -5.333, 1.333, 0.667,  -4,
                                                  -4.667, 1.667, 1,      -3.667,  -3.333, 3.333, 2.333,  -2.667,
                                                  -3,     7,     4.667,  -2.333,  -2,     15,    10.333, -1.333};
  constexpr std::array<double, 32> kAzimuths = {1.4,  -4.2, 1.4,  -1.4, 1.4,  -1.4, 4.2,  -1.4, 1.4,  -4.2, 1.4,
                                                -1.4, 4.2,  -1.4, 4.2,  -1.4, 1.4,  -4.2, 1.4,  -4.2, 4.2,  -1.4,
                                                1.4,  -1.4, 1.4,  -1.4, 1.4,  -4.2, 4.2,  -1.4, 1.4,  -1.4};
  std::array<VelodyneLaser, 32> lasers{};
  for (std::size_t i = 0; i < 32; ++i) lasers[i] = {kElevations[i], kAzimuths[i], 0, 0};
  return with_lines(lasers);
}

std::array<VelodyneLaser, 128> vls128() {
  constexpr std::array<double, 128> kElevations = {
      -11.742, -1.99, 3.4,   -5.29,  -0.78, 4.61,  -4.08, 1.31,    -6.5,  -1.11,   4.28,   -4.41, 0.1,     6.48,  -3.2,
      2.19,    -3.86, 1.53,  -9.244, -1.77, 2.74,  -5.95, -0.56,   4.83,  -2.98,   2.41,   -6.28, -0.89,   3.62,  -5.07,
      0.32,    7.58,  -0.34, 5.18,   -3.64, 1.75,  -25,   -2.43,   2.96,  -5.73,   0.54,   9.7,   -2.76,   2.63,  -7.65,
      -1.55,   3.84,  -4.85, 3.18,   -5.51, -0.12, 5.73,  -4.3,    1.09,  -16.042, -2.21,  4.06,  -4.63,   0.76,  15,
      -3.42,   1.97,  -6.85, -1.33,  -5.62, -0.23, 5.43,  -3.53,   0.98,  -19.582, -2.32,  3.07,  -4.74,   0.65,  11.75,
      -2.65,   1.86,  -7.15, -1.44,  3.95,  -2.1,  3.29,  -5.4,    -0.01, 4.5,     -4.19,  1.2,   -13.565, -1.22, 4.17,
      -4.52,   0.87,  6.08,  -3.31,  2.08,  -6.65, 1.42,  -10.346, -1.88, 3.51,    -6.06,  -0.67, 4.72,    -3.97, 2.3,
      -6.39,   -1,    4.39,  -5.18,  0.21,  6.98,  -3.09, 4.98,    -3.75, 1.64,    -8.352, -2.54, 2.85,    -5.84, -0.45,
      8.43,    -2.87, 2.52,  -6.17,  -1.66, 3.73,  -4.96, 0.43};
  constexpr std::array<double, 8> kAzimuths = {6.354, 4.548, 2.732, 0.911, -0.911, -2.732, -4.548, -6.354};
  std::array<VelodyneLaser, 128> lasers{};
  for (std::size_t i = 0; i < 128; ++i) lasers[i] = {kElevations[i], kAzimuths[i % 8], 0, 0};
  return with_lines(lasers);
}

}  // namespace

std::span<const VelodyneLaser> velodyne_lasers(VelodyneModel model) {
  static const auto kVlp16 = vlp16();
  static const auto kHires = vlp16_hires();
  static const auto kHdl32e = hdl32e();
  static const auto kVlp32c = vlp32c();
  static const auto kVls128 = vls128();
  switch (model) {
    case VelodyneModel::vlp16:
      return kVlp16;
    case VelodyneModel::vlp16_hires:
      return kHires;
    case VelodyneModel::hdl32e:
      return kHdl32e;
    case VelodyneModel::vlp32c:
      return kVlp32c;
    case VelodyneModel::vls128:
      return kVls128;
  }
  return {};
}

}  // namespace aslio::io::packets
