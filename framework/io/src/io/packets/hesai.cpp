#include "hesai.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <numbers>

#include "aslio/core/errors.hpp"

namespace aslio::io::packets {
namespace {

constexpr double kRadians = std::numbers::pi / 180;
constexpr unsigned kFullTurn = 36000;  ///< azimuths are in 0.01 deg

/// Where the parts of a packet lie [bytes], and when its channels fire [ns from the stamp of the packet].
struct Layout {
  HesaiModel model;
  const char* name;
  std::size_t channels, blocks, head, block_head, unit;  ///< unit: bytes of a return
  std::size_t mode_at, date_at, time_at;                 ///< from the end of the blocks
  std::optional<std::size_t> sequence_at;
  int year;                        ///< which the date counts from
  double first_block, block_step;  ///< of the last block where `backward`, else of the first one
  bool backward;                   ///< the stamp is at the end of the packet
  std::size_t tail;

  std::size_t block_bytes() const { return block_head + channels * unit; }
  std::size_t body_end() const { return head + blocks * block_bytes(); }
  std::size_t size() const { return body_end() + tail; }
};

constexpr std::array<Layout, 4> kLayouts{
    {{HesaiModel::xt16, "XT16", 16, 8, 12, 2, 4, 10, 13, 19, 24, 1900, 5632, 50000, true, 28},
     {HesaiModel::xt32, "XT32", 32, 8, 12, 2, 4, 10, 13, 19, 24, 1900, 5632, 50000, true, 28},
     {HesaiModel::qt64, "QT64", 64, 4, 12, 2, 4, 16, 18, 12, 24, 1900, 25710, 500000.0 / 3, false, 28},
     {HesaiModel::pandar40p, "Pandar40P", 40, 10, 0, 4, 3, 14, 16, 10, {}, 2000, -28580, 55560, true, 22}}};

constexpr std::array<double, 40> k40pTimes = {
    -42220, -28470, -16040, -3620,  -45490, -31740, -47460, -54670, -20620, -33710, -40910, -8190,  -20620, -27160,
    -50730, -8190,  -14740, -36980, -45490, -52700, -23890, -31740, -38950, -11470, -18650, -25190, -48760, -6230,
    -12770, -35010, -21920, -9500,  -43520, -29770, -17350, -4920,  -42220, -28470, -16040, -3620};
constexpr std::array<double, 64> kQt64Times = {
    12310,  14370,  16430,  18490,  20540,  22600,  24660,  26710,  29160,  31220,  33280,  35340,  37390,
    39450,  41500,  43560,  46610,  48670,  50730,  52780,  54840,  56900,  58950,  61010,  63450,  65520,
    67580,  69630,  71690,  73740,  75800,  77860,  80900,  82970,  85020,  87080,  89140,  91190,  93250,
    95300,  97750,  99820,  101870, 103930, 105980, 108040, 110100, 112150, 115200, 117260, 119320, 121380,
    123430, 125490, 127540, 129600, 132050, 134110, 136170, 138220, 140280, 142340, 144390, 146450};

double channel_time(HesaiModel model, std::size_t channel) {
  switch (model) {
    case HesaiModel::xt16:
      return 368 + 3024 * static_cast<double>(channel);
    case HesaiModel::xt32:
      return 368 + 1512 * static_cast<double>(channel);
    case HesaiModel::pandar40p:
      return k40pTimes[channel];
    case HesaiModel::qt64:
      return kQt64Times[channel];
  }
  return 0;
}

const Layout* layout_of(Bytes packet) {
  const auto fits = [&](const Layout& layout) {
    const bool numbered = layout.model == HesaiModel::pandar40p && packet.size() == layout.size() + 4;
    if (packet.size() != layout.size() && !numbered) return false;
    // EE FF comes before the packet, FF EE before each block of those without a head.
    if (layout.head == 0) return packet[0] == 0xFF && packet[1] == 0xEE;
    return packet[0] == 0xEE && packet[1] == 0xFF && packet[6] == layout.channels && packet[7] == layout.blocks;
  };
  const auto found = std::find_if(kLayouts.begin(), kLayouts.end(), fits);
  return found == kLayouts.end() ? nullptr : &*found;
}

/// Two returns in a pair of blocks with one azimuth: last and strongest, last and first, first and strongest.
constexpr unsigned kLastAndStrongest = 0x39, kLastAndFirst = 0x3B, kFirstAndStrongest = 0x3C;

bool is_dual_mode(unsigned mode) {
  return mode == kLastAndStrongest || mode == kLastAndFirst || mode == kFirstAndStrongest;
}

struct Beam {
  double azimuth = 0, cos_elevation = 1, sin_elevation = 0, time = 0;
};

class HesaiFormat final : public PacketFormat {
 public:
  HesaiFormat(const Layout& layout, const HesaiBeams& own, unsigned mode)
      : layout_(layout), own_(!own.empty()), mode_(mode) {
    const HesaiBeams beams = own_ ? own : hesai_beams(layout.model);
    for (std::size_t i = 0; i < beams.size(); ++i) {
      const double elevation = kRadians * beams[i].elevation;
      beams_.push_back(
          {kRadians * beams[i].azimuth, std::cos(elevation), std::sin(elevation), channel_time(layout.model, i)});
    }
  }

  std::string verdict() const override {
    const char* returns = mode_ == kFirstAndStrongest ? "dual return: the strongest one is kept"
                          : is_dual_mode(mode_)       ? "dual return: the last one is kept"
                                                      : "one return";
    return fmt::format("Hesai {}, {}, angles of {}", layout_.name, returns,
                       own_ ? "the sensor's own table"
                            : "the manual, which a sensor may differ from by some 0.1 deg "
                              "(`lidar_calibration` names its own)");
  }

  std::string head(Bytes packet, PacketHead& head) const override {
    if (std::string why = problem_of(packet); !why.empty()) return why;
    head.time = stamp_of(packet) + std::llround(block_time(packet, 0));
    head.turn = azimuth_of(packet, 0) / double{kFullTurn};
    const std::size_t end = layout_.body_end();
    if (layout_.sequence_at) head.sequence = number<std::uint32_t>(packet, end + *layout_.sequence_at);
    if (!layout_.sequence_at && packet.size() > layout_.size()) {
      head.sequence = number<std::uint32_t>(packet, layout_.size());
    }
    return {};
  }

  std::string decode(Bytes packet, TimeNs begin, int scan_lines, LidarPacket& out) const override {
    if (std::string why = problem_of(packet); !why.empty()) return why;
    const std::size_t returns = returns_of(packet);
    const std::size_t kept = mode_of(packet) == kFirstAndStrongest ? 1 : 0;
    const double unit = layout_.head == 0 ? 0.004 : 0.001 * packet[9];
    const double first = block_time(packet, 0);
    for (std::size_t block = kept; block < layout_.blocks; block += returns) {
      const double since = block_time(packet, block) - first;
      add_block(packet, block, begin + std::llround(since), unit, scan_lines, out);
    }
    return {};
  }

  bool begins_sweep(const PacketHead& last, const PacketHead& next) const override {
    return turned_over(last.turn, next.turn);
  }

  std::uint32_t missing_between(const PacketHead& last, const PacketHead& next) const override {
    const std::uint32_t step = next.sequence - last.sequence;
    constexpr std::uint32_t kMost = 100'000;  // beyond, the sensor was started anew
    return step > 1 && step < kMost ? step - 1 : 0;
  }

 private:
  std::string problem_of(Bytes packet) const {
    const Layout* layout = layout_of(packet);
    if (layout == &layout_) return azimuth_of(packet, 0) < kFullTurn ? "" : "its azimuth is beyond a full turn";
    if (layout != nullptr) return fmt::format("a packet of a {} among those of a {}", layout->name, layout_.name);
    return fmt::format("{} bytes that are no packet of a {}", packet.size(), layout_.name);
  }

  unsigned azimuth_of(Bytes packet, std::size_t block) const {
    const std::size_t at = layout_.head + block * layout_.block_bytes() + (layout_.block_head - 2);
    return number<std::uint16_t>(packet, at);
  }

  unsigned mode_of(Bytes packet) const { return packet[layout_.body_end() + layout_.mode_at]; }
  std::size_t returns_of(Bytes packet) const { return is_dual_mode(mode_of(packet)) ? 2 : 1; }

  /// From the stamp of the packet [ns].
  double block_time(Bytes packet, std::size_t block) const {
    const std::size_t returns = returns_of(packet), nth = layout_.backward ? layout_.blocks - 1 - block : block;
    const std::size_t whole = nth / returns;  // blocks of one moment count once
    const auto steps = static_cast<double>(whole);
    return layout_.first_block + (layout_.backward ? -steps : steps) * layout_.block_step;
  }

  /// By the sensor's clock: a date to the second, and microseconds. Clocks that were never set tell odd dates.
  TimeNs stamp_of(Bytes packet) const {
    const std::size_t end = layout_.body_end(), at = end + layout_.date_at;
    using namespace std::chrono;
    const year_month_day date{year{layout_.year + packet[at]}, month{packet[at + 1]}, day{packet[at + 2]}};
    const TimeNs days = date.ok() ? TimeNs{sys_days{date}.time_since_epoch().count()} : 0;
    const TimeNs seconds = days * 86400 + packet[at + 3] * 3600 + packet[at + 4] * 60 + packet[at + 5];
    return seconds * kSecond + TimeNs{number<std::uint32_t>(packet, end + layout_.time_at)} * 1000;
  }

  void add_block(Bytes packet, std::size_t block, TimeNs begin, double unit, int scan_lines, LidarPacket& out) const {
    const unsigned azimuth = azimuth_of(packet, block);
    const std::size_t first = layout_.head + block * layout_.block_bytes() + layout_.block_head;
    for (std::size_t i = 0; i < layout_.channels; ++i) {
      const std::size_t at = first + i * layout_.unit;
      const std::uint16_t distance = number<std::uint16_t>(packet, at);
      if (distance == 0 || azimuth >= kFullTurn || unit == 0) {
        ++out.dropped_invalid;
        continue;
      }
      const Beam& beam = beams_[i];
      const double angle = kRadians * 0.01 * azimuth + beam.azimuth, range = unit * distance;
      const double level = range * beam.cos_elevation;
      const Vec3 p(level * std::sin(angle), level * std::cos(angle), range * beam.sin_elevation);
      add_point(p, begin + std::llround(beam.time), packet[at + 2], static_cast<int>(i), scan_lines, out);
    }
  }

  const Layout& layout_;
  bool own_;
  unsigned mode_;  ///< of the first packet
  std::vector<Beam> beams_;
};

}  // namespace

std::size_t hesai_channels(HesaiModel model) {
  return std::find_if(kLayouts.begin(), kLayouts.end(), [model](const Layout& l) { return l.model == model; })
      ->channels;
}

std::optional<HesaiModel> hesai_model(Bytes packet) {
  const Layout* layout = layout_of(packet);
  return layout == nullptr ? std::nullopt : std::optional(layout->model);
}

std::unique_ptr<PacketFormat> make_hesai(std::span<const Packet> first, const HesaiBeams& beams, std::string& why) {
  why = "there is no packet";
  for (const Packet& packet : first) {
    const Layout* layout = layout_of(packet.bytes);
    if (layout == nullptr) {
      why = fmt::format("a packet of {} bytes is none of XT16, XT32, QT64, Pandar40P", packet.bytes.size());
      continue;
    }
    if (!beams.empty() && beams.size() != layout->channels) {
      throw DataError(fmt::format("the table of angles has {} channels, a {} has {}; name the table of this sensor",
                                  beams.size(), layout->name, layout->channels));
    }
    const unsigned mode = packet.bytes[layout->body_end() + layout->mode_at];
    return std::make_unique<HesaiFormat>(*layout, beams, mode);
  }
  return nullptr;
}

}  // namespace aslio::io::packets
