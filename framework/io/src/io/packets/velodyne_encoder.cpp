#include "velodyne_encoder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "aslio/core/errors.hpp"
#include "velodyne.hpp"

namespace aslio::io::packets {
namespace {

constexpr TimeNs kCycle = 55'296, kTurn = kSecond / 10;
constexpr double kLaserStep = 2'304;                          ///< [ns]
constexpr double kRate = 360.0 / static_cast<double>(kTurn);  ///< [deg/ns]
constexpr std::size_t kLasers = 16, kCyclesPerBlock = 2, kBlocks = 12, kBlockBytes = 100;
constexpr std::size_t kCyclesPerPacket = kCyclesPerBlock * kBlocks;
constexpr double kUnit = 0.002;
constexpr double kDegrees = 180 / std::numbers::pi;

struct Laser {
  double cos_elevation = 1, sin_elevation = 0, height = 0;
  std::size_t number = 0;
};

/// By scan line.
std::array<Laser, kLasers> lasers_by_line() {
  std::array<Laser, kLasers> by_line{};
  const auto lasers = velodyne_lasers(VelodyneModel::vlp16);
  for (std::size_t i = 0; i < kLasers; ++i) {
    const double elevation = lasers[i].elevation / kDegrees;
    by_line[static_cast<std::size_t>(lasers[i].line)] = {std::cos(elevation), std::sin(elevation), lasers[i].height, i};
  }
  return by_line;
}

void put(std::uint64_t value, std::size_t size, std::uint8_t* to) {
  for (std::size_t i = 0; i < size; ++i) to[i] = static_cast<std::uint8_t>(value >> (8 * i));
}

/// Empty packets with their azimuths and times.
void begin_packets(TimeNs begin, double azimuth, std::vector<rosbag::VelodynePacketFields>& packets) {
  constexpr std::uint8_t kStrongest = 0x37, kVlp16 = 0x22;
  constexpr std::uint64_t kFullTurn = 36'000;
  for (std::size_t i = 0; i < packets.size(); ++i) {
    rosbag::VelodynePacketFields& packet = packets[i];
    packet.data.fill(0);
    const TimeNs since = kCycle * static_cast<TimeNs>(i * kCyclesPerPacket);
    packet.stamp = begin + since;
    for (std::size_t block = 0; block < kBlocks; ++block) {
      const double at =
          azimuth + kRate * static_cast<double>(since + kCycle * static_cast<TimeNs>(kCyclesPerBlock * block));
      std::uint8_t* to = packet.data.data() + kBlockBytes * block;
      put(0xEEFF, 2, to);
      put(static_cast<std::uint64_t>(std::llround(100 * std::fmod(at, 360.0))) % kFullTurn, 2, to + 2);
    }
    const TimeNs microseconds = (packet.stamp % kVelodyneClock + 500) / 1000;
    put(static_cast<std::uint64_t>(microseconds), 4, packet.data.data() + kBlockBytes * kBlocks);
    packet.data[kBlockBytes * kBlocks + 4] = kStrongest;
    packet.data[kBlockBytes * kBlocks + 5] = kVlp16;
  }
}

}  // namespace

TimeNs Vlp16Encoder::find_hits(const LidarPacket& sweep) {
  static const auto kByLine = lasers_by_line();
  constexpr TimeNs kOffCycle = 1000;  // ns
  constexpr double kOffBeam = 2e-3;   // m, and as much for each metre
  const TimeNs first = sweep.points.front().t, begin = sweep.stamp + (first - sweep.stamp) % kCycle;
  hits_.clear();
  for (const TimedPoint& p : sweep.points) {
    const TimeNs since = p.t - begin;
    const TimeNs off = since % kCycle;
    const double level = std::hypot(double{p.x}, double{p.y});
    const bool in_time = since >= 0 && since <= 2 * kTurn && std::min(off, kCycle - off) <= kOffCycle;
    const Laser* laser = p.line < kLasers ? &kByLine[p.line] : nullptr;
    const double range = laser != nullptr ? level / laser->cos_elevation : 0;
    const double wrong = laser != nullptr ? std::abs(range * laser->sin_elevation + laser->height - p.z) : 0;
    if (!in_time || laser == nullptr || wrong > kOffBeam * (1 + range)) {
      throw DataError(
          fmt::format("a point of line {} at ({:.3f}, {:.3f}, {:.3f}) m, {} ns from the start of its sweep, is "
                      "none of a VLP-16: its packets hold no other sensor",
                      p.line, p.x, p.y, p.z, p.t - sweep.stamp));
    }
    const double units = range / kUnit;
    if (!(units >= 1 && units < 65535)) continue;
    Hit hit;
    hit.cycle = static_cast<std::size_t>((since + kCycle / 2) / kCycle);
    hit.laser = laser->number;
    hit.azimuth = std::atan2(-double{p.y}, double{p.x}) * kDegrees;
    hit.distance = static_cast<std::uint16_t>(std::lround(units));
    hit.intensity = static_cast<std::uint8_t>(std::clamp(std::round(p.intensity), 0.0F, 255.0F));
    hits_.push_back(hit);
  }
  return begin;
}

double Vlp16Encoder::first_azimuth() const {
  double sine = 0, cosine = 0;
  for (const Hit& hit : hits_) {
    const double since =
        static_cast<double>(kCycle) * static_cast<double>(hit.cycle) + kLaserStep * static_cast<double>(hit.laser);
    const double angle = (hit.azimuth - kRate * since) / kDegrees;
    sine += std::sin(angle);
    cosine += std::cos(angle);
  }
  const double azimuth = std::atan2(sine, cosine) * kDegrees;
  return azimuth < 0 ? azimuth + 360 : azimuth;
}

void Vlp16Encoder::encode(const LidarPacket& sweep, std::vector<rosbag::VelodynePacketFields>& packets) {
  packets.clear();
  if (sweep.points.empty()) return;
  const TimeNs begin = find_hits(sweep);
  std::size_t last = 0;
  for (const Hit& hit : hits_) last = std::max(last, hit.cycle);
  packets.resize(last / kCyclesPerPacket + 1);
  begin_packets(begin, first_azimuth(), packets);
  constexpr std::size_t kHead = 4, kReturnBytes = 3;
  for (const Hit& hit : hits_) {
    const std::size_t cycle = hit.cycle % kCyclesPerPacket, block = cycle / kCyclesPerBlock;
    const std::size_t place = cycle % kCyclesPerBlock * kLasers + hit.laser;
    std::uint8_t* to =
        packets[hit.cycle / kCyclesPerPacket].data.data() + kBlockBytes * block + kHead + kReturnBytes * place;
    put(hit.distance, 2, to);
    to[2] = hit.intensity;
  }
}

}  // namespace aslio::io::packets
