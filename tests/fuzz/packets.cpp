#include <array>
#include <string>

#include "../../framework/io/src/io/packets/capture_file.hpp"
#include "../../framework/io/src/io/packets/hesai.hpp"
#include "../../framework/io/src/io/packets/ouster.hpp"
#include "../../framework/io/src/io/packets/sweep_decoder.hpp"
#include "../../framework/io/src/io/packets/sweep_message.hpp"
#include "../../framework/io/src/io/packets/velodyne.hpp"
#include "aslio/io/inspect.hpp"
#include "fuzz/points.hpp"

namespace aslio::fuzz {
namespace {

constexpr int kLines = 64;

/// The rest is one packet: of each format in turn, and of the one that its own bytes tell.
void decode_packet(Bytes bytes, const io::packets::PacketFormat& format) {
  io::packets::PacketHead head;
  LidarPacket packet;
  const bool known = format.head(bytes, head).empty();
  const bool decoded = format.decode(bytes, 0, kLines, packet).empty();
  must(!known || (head.turn >= 0 && head.turn < 1), "a turn is within [0, 1)");
  must(decoded || packet.points.empty(), "a refused packet gives no points");
  must_be_returns(packet);
}

void decode_packets(Bytes bytes) {
  using namespace io::packets;
  const std::array<Packet, 1> one{{{0, bytes}}};
  std::string why;
  for (const auto model : {VelodyneModel::vlp16, VelodyneModel::vls128})
    decode_packet(bytes, *make_velodyne(model, true));
  if (const auto format = make_velodyne(one, why)) decode_packet(bytes, *format);
  if (const auto format = make_hesai(one, {}, why)) decode_packet(bytes, *format);
  VelodynePosition position;
  decode_velodyne_position(bytes, position);
  OusterImu imu;
  decode_ouster_imu(bytes, imu);
}

/// Metadata up to the first zero, then a packet.
void decode_ouster(Bytes bytes) {
  const std::string_view text = text_of(bytes);
  const std::size_t end = std::min(text.find('\0'), text.size());
  accepts([&] {
    const auto metadata = io::packets::parse_ouster_metadata("metadata", text.substr(0, end));
    const auto format = io::packets::make_ouster(metadata);
    const Bytes rest = bytes.subspan(std::min(end + 1, bytes.size()));
    decode_packet(rest, *format);
    // Whatever the metadata says, a packet of that length is within bounds.
    const std::vector<std::uint8_t> filled(metadata.packet_bytes(), rest.empty() ? 0xFF : rest[0]);
    decode_packet(filled, *format);
  });
}

void decode_scan(Bytes bytes, bool cdr) {
  io::Connection connection;
  connection.encoding = cdr ? io::Encoding::cdr : io::Encoding::ros1;
  for (const char* type : {"velodyne_msgs/msg/VelodyneScan", "pandar_msgs/msg/PandarScan"}) {
    connection.type = type;
    const auto decoder = io::packets::make_sweep_decoder(connection, {}, "scan");
    const io::decode::Message message(bytes, connection.encoding);
    io::SourceNotes notes;
    accepts([&] {
      if (!decoder->judge(message, notes)) decoder->assume(notes);
      LidarPacket packet;
      if (decoder->decode(message, packet).empty()) must_be_returns(packet);
    });
  }
}

}  // namespace
}  // namespace aslio::fuzz

// The first byte: what the rest is.
ASLIO_FUZZ_TARGET(packets) {
  if (bytes.empty()) return;
  const Bytes rest = bytes.subspan(1);
  switch (bytes[0] % 6) {
    case 0:
      return decode_packets(rest);
    case 1:
      return decode_ouster(rest);
    case 2:
      return decode_scan(rest, false);
    case 3:
      return decode_scan(rest, true);
    case 4: {
      accepts([&] { io::packets::read_hesai_beams("table", text_of(rest)); });
      return;
    }
    default: {
      const auto path = written("capture.pcap", rest);
      accepts([&] { io::render(io::inspect(path)); });
    }
  }
}
