#include "velodyne.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace aslio::io::packets {
namespace {

constexpr std::size_t kBlocks = 12, kBlockBytes = 100, kReturns = 32, kReturnBytes = 3, kBlockHead = 4;
constexpr std::size_t kTimeAt = 1200, kModeAt = 1204, kProductAt = 1205;
constexpr int kFullTurn = 36000;  ///< azimuths are in 0.01 deg
constexpr double kRadians = std::numbers::pi / 180;

/// Modes with two returns: strongest and last, and the same with confidences.
bool is_dual(Bytes packet) { return packet[kModeAt] == 0x39 || packet[kModeAt] == 0x3B; }

/// Firing times of a model, from the first firing of a packet [ns].
struct Timing {
  double cycle = 0;             ///< between two firings of one laser
  double step = 0;              ///< between groups of lasers
  std::size_t group = 1;        ///< lasers that fire together
  std::size_t pause_after = 0;  ///< groups; 0: no pause. It lasts one step
  double lead = 0;              ///< how much later than the first firing the stamp of the packet is

  double of_laser(std::size_t laser) const {
    const std::size_t at = laser / group;
    const std::size_t paused = pause_after > 0 && at >= pause_after ? 1 : 0;
    return step * static_cast<double>(at + paused) - lead;
  }
};

struct Traits {
  VelodyneModel model;
  std::uint8_t product;
  const char* name;
  double unit;  ///< of a distance [m]
  Timing timing;
  std::size_t lasers;
};

constexpr std::array<Traits, 5> kTraits{
    {{VelodyneModel::vlp16, 0x22, "VLP-16", 0.002, {55296, 2304}, 16},
     {VelodyneModel::vlp16_hires, 0x24, "Puck Hi-Res", 0.002, {55296, 2304}, 16},
     {VelodyneModel::hdl32e, 0x21, "HDL-32E", 0.002, {46080, 1152}, 32},
     {VelodyneModel::vlp32c, 0x28, "VLP-32C", 0.004, {55296, 2304, 2}, 32},
     {VelodyneModel::vls128, 0xA1, "VLS-128", 0.004, {53300, 2665, 8, 8, 8700}, 128}}};

const Traits& traits_of(VelodyneModel model) {
  return *std::find_if(kTraits.begin(), kTraits.end(), [model](const Traits& t) { return t.model == model; });
}

/// The flag of a block: EEFF, and DDFF, CCFF, BBFF for further banks of 32 lasers. Nothing for any other.
std::optional<std::size_t> bank_of(std::uint16_t flag) {
  const std::size_t below = 0xEEFFU - std::min<std::size_t>(flag, 0xEEFFU);
  if (flag > 0xEEFFU || below % 0x1100U != 0 || below > 3 * 0x1100U) return std::nullopt;
  return below / 0x1100U;
}

std::string problem_of(Bytes packet) {
  if (packet.size() != kVelodyneDataBytes) {
    return fmt::format("a data packet of {} bytes where Velodyne's have {}", packet.size(), kVelodyneDataBytes);
  }
  if (!bank_of(number<std::uint16_t>(packet, 0))) {
    return fmt::format("its first block begins with {:02x}{:02x}, not with ffee", packet[0], packet[1]);
  }
  if (number<std::uint16_t>(packet, 2) >= kFullTurn) {
    return fmt::format("its azimuth {} is beyond {}", number<std::uint16_t>(packet, 2), kFullTurn);
  }
  return {};
}

/// Precomputed for one laser.
struct Beam {
  double azimuth = 0;  ///< [rad]
  double cos_elevation = 1, sin_elevation = 0, height = 0;
  int line = 0;
  double time = 0;  ///< within the cycle [ns]
};

/// A block of returns that is used.
struct Block {
  std::size_t at = 0;     ///< of its first return in the packet
  std::size_t bank = 0;   ///< of 32 lasers each
  std::size_t cycle = 0;  ///< in the packet
  int azimuth = 0;        ///< [0.01 deg]
  double rate = 0;        ///< [rad/ns]
};

class VelodyneFormat final : public PacketFormat {
 public:
  VelodyneFormat(VelodyneModel model, bool dual) : traits_(traits_of(model)), dual_(dual) {
    const auto lasers = velodyne_lasers(model);
    for (std::size_t i = 0; i < lasers.size(); ++i) {
      const double elevation = kRadians * lasers[i].elevation;
      beams_.push_back({kRadians * lasers[i].azimuth, std::cos(elevation), std::sin(elevation), lasers[i].height,
                        lasers[i].line, traits_.timing.of_laser(i)});
    }
  }

  std::string verdict() const override {
    return fmt::format("Velodyne {}, {}, angles of the manual", traits_.name,
                       dual_ ? "dual return: the strongest one is kept" : "one return");
  }

  std::string head(Bytes packet, PacketHead& head) const override {
    if (std::string why = problem_of(packet); !why.empty()) return why;
    head.time = TimeNs{number<std::uint32_t>(packet, kTimeAt)} * 1000;
    head.turn = number<std::uint16_t>(packet, 2) / double{kFullTurn};
    return {};
  }

  std::string decode(Bytes packet, TimeNs begin, int scan_lines, LidarPacket& out) const override {
    if (std::string why = problem_of(packet); !why.empty()) return why;
    for (const Block& block : blocks_of(packet, out)) add_block(packet, block, begin, scan_lines, out);
    return {};
  }

  bool begins_sweep(const PacketHead& last, const PacketHead& next) const override {
    return turned_over(last.turn, next.turn);
  }

  std::uint32_t missing_between(const PacketHead& last, const PacketHead& next) const override {
    const double packets = static_cast<double>(clock_difference(next.time, last.time, kVelodyneClock)) / duration();
    // A longer gap is a sensor that was switched off, or a clock that was set.
    const bool counted = packets > 1.5 && packets < 1e5;
    return counted ? static_cast<std::uint32_t>(std::lround(packets)) - 1 : 0;
  }

  TimeNs clock_period() const override { return kVelodyneClock; }

 private:
  /// Of one packet [ns].
  double duration() const {
    const double returns = kBlocks * kReturns / (dual_ ? 2.0 : 1.0);
    return traits_.timing.cycle * returns / static_cast<double>(traits_.lasers);
  }

  /// Cycles of all lasers in a block: a VLP-16 fires twice.
  std::size_t cycles_per_block() const { return std::max<std::size_t>(1, kReturns / traits_.lasers); }

  std::vector<Block> blocks_of(Bytes packet, LidarPacket& out) const {
    const std::size_t returns = is_dual(packet) ? 2 : 1, banks = std::max<std::size_t>(1, traits_.lasers / kReturns);
    std::vector<Block> blocks;
    blocks.reserve(kBlocks);
    std::size_t cycle = 0;
    // Of a pair the second one holds the strongest return.
    for (std::size_t i = returns - 1; i < kBlocks; i += returns) {
      const std::size_t at = i * kBlockBytes;
      const auto bank = bank_of(number<std::uint16_t>(packet, at));
      const std::uint16_t azimuth = number<std::uint16_t>(packet, at + 2);
      if (i >= returns && (!bank || *bank == 0 || banks == 1)) cycle += cycles_per_block();
      if (bank && *bank < banks && azimuth < kFullTurn) {
        blocks.push_back({at + kBlockHead, *bank, cycle, azimuth, 0});
      } else {
        out.dropped_invalid += kReturns;
      }
    }
    set_rates(blocks);
    return blocks;
  }

  /// How fast the head turns at each block: by the next cycle, and by the one before at the end.
  void set_rates(std::vector<Block>& blocks) const {
    constexpr int kMost = 300;  ///< [0.01 deg] between cycles: at 20 Hz, 80
    double rate = 0;
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      const auto next = std::find_if(blocks.begin() + static_cast<std::ptrdiff_t>(i), blocks.end(),
                                     [&](const Block& b) { return b.cycle > blocks[i].cycle; });
      if (next != blocks.end()) {
        const int step = (next->azimuth - blocks[i].azimuth + kFullTurn) % kFullTurn;
        const double time = traits_.timing.cycle * static_cast<double>(next->cycle - blocks[i].cycle);
        if (step <= kMost) rate = kRadians * 0.01 * step / time;
      }
      blocks[i].rate = rate;
    }
  }

  void add_block(Bytes packet, const Block& block, TimeNs begin, int scan_lines, LidarPacket& out) const {
    for (std::size_t i = 0; i < kReturns; ++i) {
      const std::size_t at = block.at + i * kReturnBytes;
      const std::uint16_t distance = number<std::uint16_t>(packet, at);
      if (distance == 0) {
        ++out.dropped_invalid;
        continue;
      }
      const Beam& beam = beams_[(block.bank * kReturns + i) % traits_.lasers];
      const std::size_t cycles = i / traits_.lasers;
      const double since_block = traits_.timing.cycle * static_cast<double>(cycles) + beam.time;
      const double azimuth = kRadians * 0.01 * block.azimuth + block.rate * since_block + beam.azimuth;
      const double range = traits_.unit * distance, level = range * beam.cos_elevation;
      const Vec3 p(level * std::cos(azimuth), -level * std::sin(azimuth), range * beam.sin_elevation + beam.height);
      const double since = traits_.timing.cycle * static_cast<double>(block.cycle) + since_block;
      add_point(p, begin + std::llround(since), packet[at + 2], beam.line, scan_lines, out);
    }
  }

  const Traits& traits_;
  bool dual_;
  std::vector<Beam> beams_;
};

/// The time between packets of old VLP-16 that call themselves HDL-32E: 1.33 ms, where those of an HDL-32E take 0.55.
bool fires_like_vlp16(std::span<const Packet> first) {
  std::vector<TimeNs> steps;
  std::optional<TimeNs> last;
  for (const Packet& packet : first) {
    if (!problem_of(packet.bytes).empty()) continue;
    const TimeNs time = TimeNs{number<std::uint32_t>(packet.bytes, kTimeAt)} * 1000;
    if (last) steps.push_back(clock_difference(time, *last, kVelodyneClock) * (is_dual(packet.bytes) ? 2 : 1));
    last = time;
  }
  if (steps.empty()) return false;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  constexpr TimeNs kBetween = 940'000, kTooLong = 2'000'000;
  return *middle > kBetween && *middle < kTooLong;
}

}  // namespace

std::unique_ptr<PacketFormat> make_velodyne(VelodyneModel model, bool dual) {
  return std::make_unique<VelodyneFormat>(model, dual);
}

std::unique_ptr<PacketFormat> make_velodyne(std::span<const Packet> first, std::string& why) {
  why = "there is no packet";
  for (const Packet& packet : first) {
    why = problem_of(packet.bytes);
    if (!why.empty()) continue;
    const std::uint8_t product = packet.bytes[kProductAt];
    const auto traits =
        std::find_if(kTraits.begin(), kTraits.end(), [product](const Traits& t) { return t.product == product; });
    if (traits == kTraits.end()) {
      why = fmt::format(
          "product {:#04x} of Velodyne is not known (VLP-16 0x22, Puck Hi-Res 0x24, HDL-32E 0x21, "
          "VLP-32C 0x28, VLS-128 0xa1)",
          product);
      continue;
    }
    const bool old = traits->model == VelodyneModel::hdl32e && fires_like_vlp16(first);
    return make_velodyne(old ? VelodyneModel::vlp16 : traits->model, is_dual(packet.bytes));
  }
  return nullptr;
}

std::string decode_velodyne_position(Bytes packet, VelodynePosition& position) {
  if (packet.size() != kVelodynePositionBytes) {
    return fmt::format("a position packet of {} bytes where Velodyne's have {}", packet.size(), kVelodynePositionBytes);
  }
  constexpr std::size_t kValuesAt = 14, kStampAt = 198, kSentenceAt = 206, kSentenceBytes = 72;
  constexpr double kGyroUnit = 0.09766 * kRadians, kAccUnit = 0.001221 * kStandardGravity, kTemperatureUnit = 0.1453;
  position = {};
  position.time = TimeNs{number<std::uint32_t>(packet, kStampAt)} * 1000;
  // Of three boards: gyro, temperature, two axes of acceleration; 12 bits in two's complement, whatever is above.
  std::array<double, 12> v{};
  for (std::size_t i = 0; i < v.size(); ++i) {
    const int raw = number<std::uint16_t>(packet, kValuesAt + 2 * i);
    position.has_imu = position.has_imu || raw != 0;
    v[i] = (raw & 0x7FF) - (raw & 0x800);
  }
  if (position.has_imu) {
    // The boards stand upright at right angles: each axis is measured twice, and one board is turned around.
    position.gyro = kGyroUnit * Vec3(v[4], -v[0], v[8]);
    position.acc = 0.5 * kAccUnit * Vec3(v[3] - v[10], v[7] + v[11], v[2] + v[6]);
    position.temperature = 25 + kTemperatureUnit * (v[1] + v[5] + v[9]) / 3;
  }
  const auto text = packet.subspan(kSentenceAt, kSentenceBytes);
  for (auto c = text.begin(); c != text.end() && *c >= 0x20 && *c < 0x7F; ++c) {
    position.nmea.push_back(static_cast<char>(*c));
  }
  return {};
}

}  // namespace aslio::io::packets
