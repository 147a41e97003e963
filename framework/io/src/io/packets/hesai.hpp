#pragma once
/// Hesai's packets: XT16, XT32 (568 and 1080 bytes), QT64 (1072), Pandar40P (1262, or 1266 with a sequence number).
/// Facts: user manuals of PandarXT, PandarQT and Pandar40P.
/// Frame, as of the vendor's driver: y where the azimuth is 0, x to the right, z up.

#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "format.hpp"

namespace aslio::io::packets {

enum class HesaiModel : std::uint8_t { xt16, xt32, pandar40p, qt64 };

/// Direction of a channel [deg].
struct HesaiBeam {
  double elevation = 0, azimuth = 0;
};
using HesaiBeams = std::vector<HesaiBeam>;

/// As the manual tells them; each sensor differs from these by a few hundredths of a degree.
HesaiBeams hesai_beams(HesaiModel model);

/// A sensor's own angles: the vendor's table with lines `channel,elevation,azimuth` in degrees, channels from 1. Throws
/// DataError that names file, line and value.
HesaiBeams read_hesai_beams(const std::string& name, std::string_view text);

/// Channels of a model.
std::size_t hesai_channels(HesaiModel model);

/// Nothing for packets of another kind.
std::optional<HesaiModel> hesai_model(Bytes packet);

/// By the first packet of a known model; without one nothing, and `why` says what there was. `beams`: the sensor's own
/// angles; empty for those of the manual. Throws DataError when they are not of as many channels as the sensor has.
std::unique_ptr<PacketFormat> make_hesai(std::span<const Packet> first, const HesaiBeams& beams, std::string& why);

}  // namespace aslio::io::packets
