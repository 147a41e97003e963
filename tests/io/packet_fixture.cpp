#include "io/packet_fixture.hpp"

#include <algorithm>
#include <bit>

namespace aslio::io::test {

void put_number(PacketBytes& bytes, std::size_t at, std::uint64_t value, std::size_t size) {
  for (std::size_t i = 0; i < size; ++i) bytes.at(at + i) = static_cast<std::uint8_t>(value >> (8 * i));
}

PacketBytes VelodynePacket::bytes() const {
  PacketBytes out(1206, 0);
  for (std::size_t block = 0; block < 12; ++block) {
    const std::size_t at = 100 * block;
    put_number(out, at, flag(block), 2);
    const int nth = mode == 0x39 ? static_cast<int>(block / 2) : static_cast<int>(block);
    put_number(out, at + 2, static_cast<std::uint64_t>((first + step * nth) % 36000), 2);
    for (std::size_t i = 0; i < 32; ++i) {
      put_number(out, at + 4 + 3 * i, distance(block, i), 2);
      out[at + 6 + 3 * i] = static_cast<std::uint8_t>(i);
    }
  }
  put_number(out, 1200, microseconds, 4);
  out[1204] = mode;
  out[1205] = product;
  return out;
}

PacketBytes HesaiPacket::bytes() const {
  const std::size_t blocks = channels == 64 ? 4 : 8, block_bytes = 2 + 4U * channels, end = 12 + blocks * block_bytes;
  PacketBytes out(end + 28, 0);
  put_number(out, 0, 0xFFEE, 2);
  out[6] = channels;
  out[7] = static_cast<std::uint8_t>(blocks);
  out[9] = 4;
  const bool dual = mode == 0x39 || mode == 0x3C;
  for (std::size_t block = 0; block < blocks; ++block) {
    const std::size_t at = 12 + block * block_bytes, nth = dual ? block / 2 : block;
    put_number(out, at, (first + step * nth) % 36000, 2);
    for (std::size_t i = 0; i < channels; ++i) {
      put_number(out, at + 2 + 4 * i, distance(block, i), 2);
      out[at + 4 + 4 * i] = static_cast<std::uint8_t>(i);
    }
  }
  const std::vector<std::uint8_t> date{120, 9, 13, 12, 26, 40};  // 2020-09-13 12:26:40 is kStart
  const bool qt = channels == 64;
  out[end + (qt ? 16 : 10)] = mode;
  for (std::size_t i = 0; i < 6; ++i) out[end + (qt ? 18 : 13) + i] = date[i];
  put_number(out, end + (qt ? 12 : 19), microseconds, 4);
  put_number(out, end + 24, sequence, 4);
  return out;
}

PacketBytes pandar40p_packet(unsigned first, std::uint16_t distance) {
  PacketBytes out(1262, 0);
  for (std::size_t block = 0; block < 10; ++block) {
    const std::size_t at = 124 * block;
    put_number(out, at, 0xEEFF, 2);
    put_number(out, at + 2, (first + 20 * block) % 36000, 2);
    for (std::size_t i = 0; i < 40; ++i) put_number(out, at + 4 + 3 * i, distance, 2);
  }
  const std::vector<std::uint8_t> date{20, 9, 13, 12, 26, 40};
  out[1240 + 14] = 0x37;
  for (std::size_t i = 0; i < 6; ++i) out[1240 + 16 + i] = date[i];
  return out;
}

std::string ouster_metadata(const std::string& profile) {
  std::string angles = "0";
  for (int i = 1; i < 16; ++i) angles += ", 0";
  return R"({"beam_altitude_angles": [)" + angles + R"(], "beam_azimuth_angles": [)" + angles +
         R"(], "data_format": {"columns_per_frame": 512, "columns_per_packet": 16, "pixels_per_column": 16,
"udp_profile_lidar": ")" +
         profile + R"("}, "lidar_origin_to_beam_origin_mm": 15, "prod_line": "OS-1-16",
"lidar_to_sensor_transform": [-1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1, 36, 0, 0, 0, 1],
"imu_to_sensor_transform": [1, 0, 0, 6.253, 0, 1, 0, -11.775, 0, 0, 1, 7.645, 0, 0, 0, 1]})";
}

PacketBytes ouster_packet(bool legacy, std::uint16_t frame, std::uint16_t first_column, TimeNs time, std::uint32_t mm) {
  const std::size_t head = legacy ? 0 : 32, column_head = legacy ? 16 : 12, tail = legacy ? 4 : 0;
  const std::size_t column_bytes = column_head + 16 * 12 + tail;
  PacketBytes out(head + 16 * column_bytes + head, 0);
  if (!legacy) put_number(out, 0, 1, 2);
  if (!legacy) put_number(out, 2, frame, 2);
  for (std::size_t column = 0; column < 16; ++column) {
    const std::size_t at = head + column * column_bytes;
    put_number(out, at, static_cast<std::uint64_t>(time) + 195312 * column, 8);
    put_number(out, at + 8, first_column + column, 2);
    put_number(out, at + 10, legacy ? frame : 1U, 2);
    for (std::size_t row = 0; row < 16; ++row) {
      const std::size_t pixel = at + column_head + 12 * row;
      put_number(out, pixel, mm, 4);
      put_number(out, pixel + 4, row, legacy ? 2 : 1);
    }
    if (legacy) put_number(out, at + column_bytes - 4, 0xFFFFFFFF, 4);
  }
  return out;
}

PacketBytes ouster_imu(TimeNs time, float acc_z, float gyro_z) {
  PacketBytes out(48, 0);
  for (const std::size_t at : {0U, 8U, 16U}) put_number(out, at, static_cast<std::uint64_t>(time), 8);
  put_number(out, 32, std::bit_cast<std::uint32_t>(acc_z), 4);
  put_number(out, 44, std::bit_cast<std::uint32_t>(gyro_z), 4);
  return out;
}

std::vector<std::uint8_t> velodyne_scan(TimeNs stamp, const std::vector<std::pair<TimeNs, PacketBytes>>& packets,
                                        bool cdr) {
  std::vector<std::uint8_t> out;
  const auto put = [&out](std::uint32_t value) {
    for (unsigned shift = 0; shift < 32; shift += 8) out.push_back(static_cast<std::uint8_t>(value >> shift));
  };
  const auto align = [&out, cdr] {
    while (cdr && out.size() % 4 != 0) out.push_back(0);
  };
  const auto put_time = [&](TimeNs time) {
    put(static_cast<std::uint32_t>(time / kSecond));
    put(static_cast<std::uint32_t>(time % kSecond));
  };
  put(cdr ? 0x00000100U : 7U);  // encapsulation, or the sequence number
  put_time(stamp);
  const std::string frame = cdr ? std::string("velodyne") + '\0' : "velodyne";
  put(static_cast<std::uint32_t>(frame.size()));
  out.insert(out.end(), frame.begin(), frame.end());
  align();
  put(static_cast<std::uint32_t>(packets.size()));
  for (const auto& [time, bytes] : packets) {
    align();
    put_time(time);
    out.insert(out.end(), bytes.begin(), bytes.end());
  }
  return out;
}

namespace {

void append(std::vector<std::uint8_t>& out, std::uint64_t value, std::size_t size) {
  for (std::size_t i = 0; i < size; ++i) out.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}

void append_big(std::vector<std::uint8_t>& out, std::uint64_t value, std::size_t size) {
  for (std::size_t i = size; i-- > 0;) out.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}

void append_record(std::vector<std::uint8_t>& out, TimeNs time, const PacketBytes& frame, CaptureForm form) {
  const auto size = frame.size(), padded = (size + 3) / 4 * 4, ns = static_cast<std::size_t>(time);
  if (form == CaptureForm::pcap) {
    append(out, ns / 1'000'000'000, 4);
    append(out, ns % 1'000'000'000, 4);
    append(out, size, 4);
    append(out, size, 4);
    out.insert(out.end(), frame.begin(), frame.end());
    return;
  }
  append(out, 6, 4);  // enhanced packet block
  append(out, 32 + padded, 4);
  append(out, 0, 4);
  append(out, ns >> 32U, 4);
  append(out, ns & 0xFFFFFFFFU, 4);
  append(out, size, 4);
  append(out, size, 4);
  out.insert(out.end(), frame.begin(), frame.end());
  out.resize(out.size() + padded - size, 0);
  append(out, 32 + padded, 4);
}

}  // namespace

std::vector<PacketBytes> ethernet_frames(const SentDatagram& datagram) {
  PacketBytes udp;
  append_big(udp, 2368, 2);
  append_big(udp, datagram.port, 2);
  append_big(udp, 8 + datagram.payload.size(), 2);
  append_big(udp, 0, 2);
  udp.insert(udp.end(), datagram.payload.begin(), datagram.payload.end());
  const std::size_t step = datagram.fragment_bytes == 0 ? udp.size() : datagram.fragment_bytes;
  std::vector<PacketBytes> frames;
  for (std::size_t from = 0; from < udp.size(); from += step) {
    const std::size_t to = std::min(udp.size(), from + step);
    PacketBytes frame(12, 0x02);
    if (datagram.vlan) append_big(frame, 0x81000005, 4);
    append_big(frame, 0x0800, 2);
    append_big(frame, 0x4500, 2);
    append_big(frame, 20 + to - from, 2);
    append_big(frame, datagram.id, 2);
    append_big(frame, (to < udp.size() ? 0x2000U : 0U) | from / 8, 2);
    append_big(frame, 0x40110000, 4);
    frame.insert(frame.end(), datagram.source.begin(), datagram.source.end());
    append_big(frame, 0xFFFFFFFF, 4);
    frame.insert(frame.end(), udp.begin() + static_cast<std::ptrdiff_t>(from),
                 udp.begin() + static_cast<std::ptrdiff_t>(to));
    frames.push_back(frame);
  }
  return frames;
}

std::vector<std::uint8_t> capture(const std::vector<SentDatagram>& datagrams, CaptureForm form) {
  constexpr std::size_t kEthernet = 1, kSnapshot = 262144;
  std::vector<std::uint8_t> out;
  if (form == CaptureForm::pcap) {
    append(out, 0xA1B23C4D, 4);
    append(out, 2, 2);
    append(out, 4, 2);
    append(out, 0, 8);
    append(out, kSnapshot, 4);
    append(out, kEthernet, 4);
  } else {
    append(out, 0x0A0D0D0A, 4);  // section header block
    append(out, 28, 4);
    append(out, 0x1A2B3C4D, 4);
    append(out, 1, 4);
    append(out, 0xFFFFFFFFFFFFFFFF, 8);
    append(out, 28, 4);
    append(out, 1, 4);  // interface description block, times in 1e-9 s
    append(out, 32, 4);
    append(out, kEthernet, 4);
    append(out, kSnapshot, 4);
    append(out, 0x00010009, 4);
    append(out, 9, 4);
    append(out, 0, 4);
    append(out, 32, 4);
  }
  for (const SentDatagram& datagram : datagrams) {
    for (const PacketBytes& frame : ethernet_frames(datagram)) append_record(out, datagram.time, frame, form);
  }
  return out;
}

}  // namespace aslio::io::test
