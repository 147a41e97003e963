#include "capture_file.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <pcap/pcap.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "../input_file.hpp"
#include "aslio/core/errors.hpp"

namespace aslio::io::packets {
namespace {

constexpr std::uint8_t kUdp = 17, kFragmentHeader = 44;
constexpr std::uint16_t kIpv4 = 0x0800, kIpv6 = 0x86DD, kVlan = 0x8100, kServiceVlan = 0x88A8;

/// Numbers of the network are big-endian. Pre: they lie within.
unsigned big16(Bytes bytes, std::size_t at) { return static_cast<unsigned>(bytes[at]) << 8U | bytes[at + 1]; }

/// The part behind the header of the link, and what it says of it (an EtherType; 0: the version tells).
struct LinkPayload {
  unsigned type = 0;
  Bytes bytes;
};

std::optional<std::size_t> link_header(int link) {
  switch (link) {
    case DLT_EN10MB:
      return 14;
    case DLT_LINUX_SLL:
      return 16;
    case DLT_LINUX_SLL2:
      return 20;
    case DLT_NULL:
    case DLT_LOOP:
      return 4;
    case DLT_RAW:
    case DLT_IPV4:
    case DLT_IPV6:
      return 0;
    default:
      return std::nullopt;
  }
}

std::optional<LinkPayload> link_payload(int link, Bytes frame) {
  const std::size_t header = link_header(link).value_or(0);
  if (frame.size() < header) return std::nullopt;
  LinkPayload payload{0, frame.subspan(header)};
  if (link == DLT_EN10MB || link == DLT_LINUX_SLL) payload.type = big16(frame, header - 2);
  if (link == DLT_LINUX_SLL2) payload.type = big16(frame, 0);
  constexpr std::size_t kVlanBytes = 4;
  while ((payload.type == kVlan || payload.type == kServiceVlan) && payload.bytes.size() >= kVlanBytes) {
    payload.type = big16(payload.bytes, 2);
    payload.bytes = payload.bytes.subspan(kVlanBytes);
  }
  if (payload.type == 0 && !payload.bytes.empty()) payload.type = payload.bytes[0] >> 4U == 6 ? kIpv6 : kIpv4;
  return payload;
}

std::string text_of(Bytes address) {
  std::array<char, INET6_ADDRSTRLEN> text{};
  inet_ntop(address.size() == 4 ? AF_INET : AF_INET6, address.data(), text.data(), text.size());
  return text.data();
}

}  // namespace

/// An IP packet with UDP in it, or a fragment of one.
struct CaptureFile::Internet {
  Bytes source, destination, payload;
  std::uint32_t id = 0;
  std::size_t offset = 0;  ///< of a fragment [bytes]
  bool more = false;       ///< fragments follow
  bool cut = false;        ///< captured in part

  bool fragment() const { return more || offset > 0; }

  static std::optional<Internet> read(const LinkPayload& link) {
    if (link.type == kIpv4) return read4(link.bytes);
    return link.type == kIpv6 ? read6(link.bytes) : std::nullopt;
  }

  static std::optional<Internet> read4(Bytes bytes) {
    if (bytes.size() < 20 || bytes[0] >> 4U != 4 || bytes[9] != kUdp) return std::nullopt;
    const std::size_t header = 4 * (bytes[0] & 0xFU), total = big16(bytes, 2);
    if (header < 20 || total < header || bytes.size() < header) return std::nullopt;
    Internet packet;
    packet.source = bytes.subspan(12, 4);
    packet.destination = bytes.subspan(16, 4);
    packet.id = big16(bytes, 4);
    packet.more = (bytes[6] & 0x20U) != 0;
    packet.offset = 8 * (big16(bytes, 6) & 0x1FFFU);
    packet.take(bytes, header, total);
    return packet;
  }

  static std::optional<Internet> read6(Bytes bytes) {
    constexpr std::size_t kHeader = 40, kFragment = 8;
    if (bytes.size() < kHeader || bytes[0] >> 4U != 6) return std::nullopt;
    Internet packet;
    packet.source = bytes.subspan(8, 16);
    packet.destination = bytes.subspan(24, 16);
    const std::size_t total = kHeader + big16(bytes, 4);
    if (bytes[6] == kUdp) {
      packet.take(bytes, kHeader, total);
      return packet;
    }
    const bool in_fragments = bytes[6] == kFragmentHeader && bytes.size() >= kHeader + kFragment;
    if (!in_fragments || total < kHeader + kFragment || bytes[kHeader] != kUdp) return std::nullopt;
    packet.offset = big16(bytes, kHeader + 2) & 0xFFF8U;
    packet.more = (bytes[kHeader + 3] & 1U) != 0;
    packet.id = big16(bytes, kHeader + 4) << 16U | big16(bytes, kHeader + 6);
    packet.take(bytes, kHeader + kFragment, total);
    return packet;
  }

 private:
  /// The link may add bytes behind the packet, and a capture leave some out.
  void take(Bytes bytes, std::size_t header, std::size_t total) {
    cut = bytes.size() < total;
    payload = bytes.first(std::min(total, bytes.size())).subspan(header);
  }
};

bool is_capture(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return false;
  std::array<std::uint8_t, 4> head{};
  try {
    const InputFile file(path);
    if (file.size() < head.size()) return false;
    file.read(0, head);
  } catch (const DataError&) {
    return false;  // who opens it says why
  }
  const std::uint32_t magic = number<std::uint32_t>(head, 0);
  constexpr std::array<std::uint32_t, 5> kMagics = {0xA1B2C3D4, 0xD4C3B2A1, 0xA1B23C4D, 0x4D3CB2A1, 0x0A0D0D0A};
  return std::find(kMagics.begin(), kMagics.end(), magic) != kMagics.end();
}

CaptureFile::CaptureFile(std::filesystem::path path) : path_(std::move(path)), pcap_(nullptr, &pcap_close) { rewind(); }

CaptureFile::~CaptureFile() = default;

void CaptureFile::rewind() {
  std::array<char, PCAP_ERRBUF_SIZE> error{};
  pcap_.reset(pcap_open_offline_with_tstamp_precision(path_.c_str(), PCAP_TSTAMP_PRECISION_NANO, error.data()));
  if (!pcap_) {
    throw DataError(fmt::format("{}: it cannot be read as a network capture: {}; copy it again from its origin",
                                path_.string(), error.data()));
  }
  link_ = pcap_datalink(pcap_.get());
  if (!link_header(link_)) {
    const char* name = pcap_datalink_val_to_name(link_);
    throw DataError(
        fmt::format("{}: it was captured on a link of type {} ({}), where Ethernet, Linux cooked, raw IP "
                    "and loopback can be read; write it anew with one of these",
                    path_.string(), link_, name == nullptr ? "unknown" : name));
  }
  pending_.clear();
  status_ = InputStatus::complete;
  damage_.clear();
  incomplete_ = 0;
}

bool CaptureFile::next(Datagram& datagram) {
  while (status_ == InputStatus::complete) {
    pcap_pkthdr* head = nullptr;
    const u_char* data = nullptr;
    const int got = pcap_next_ex(pcap_.get(), &head, &data);
    if (got == PCAP_ERROR_BREAK) return false;
    if (got != 1) {
      status_ = InputStatus::truncated;
      damage_ = pcap_geterr(pcap_.get());
      return false;
    }
    // In nanoseconds, as asked for when it was opened. Damaged times must not overflow.
    constexpr TimeNs kMostSeconds = std::int64_t{1} << 32;
    const TimeNs seconds = std::clamp<TimeNs>(head->ts.tv_sec, 0, kMostSeconds);
    const TimeNs time = seconds * kSecond + std::clamp<TimeNs>(head->ts.tv_usec, 0, kSecond - 1);
    if (read_frame({data, head->caplen}, time, datagram)) return true;
  }
  return false;
}

bool CaptureFile::read_frame(Bytes frame, TimeNs time, Datagram& datagram) {
  const auto link = link_payload(link_, frame);
  auto packet = link ? Internet::read(*link) : std::nullopt;
  if (!packet) return false;
  if (packet->cut) {
    ++incomplete_;
    return false;
  }
  datagram.time = time;
  if (packet->fragment() && !complete(*packet, time, packet->payload)) return false;
  return read_udp(*packet, datagram);
}

bool CaptureFile::read_udp(const Internet& packet, Datagram& datagram) {
  constexpr std::size_t kHeader = 8;
  if (packet.payload.size() < kHeader) return false;
  const std::size_t length = big16(packet.payload, 4);
  if (length < kHeader || length > packet.payload.size()) {
    ++incomplete_;
    return false;
  }
  datagram.address = text_of(packet.source);
  datagram.port = static_cast<std::uint16_t>(big16(packet.payload, 2));
  datagram.payload = packet.payload.subspan(kHeader, length - kHeader);
  return true;
}

/// Takes a fragment; true with all of the datagram once it is there.
bool CaptureFile::complete(const Internet& packet, TimeNs time, Bytes& whole) {
  constexpr std::size_t kMostPending = 64, kMostBytes = 65'536;
  constexpr TimeNs kLongest = 5 * kSecond;  // identifications come back after 65536 packets
  const std::size_t begin = packet.offset, end = begin + packet.payload.size();
  if (end > kMostBytes || packet.payload.empty()) return false;
  FragmentKey key{};
  std::copy(packet.source.begin(), packet.source.end(), key.begin());
  std::copy(packet.destination.begin(), packet.destination.end(), key.begin() + 16);
  for (unsigned i = 0; i < 4; ++i) key[32 + i] = static_cast<std::uint8_t>(packet.id >> (8 * i));
  auto at = pending_.find(key);
  const bool stale =
      at != pending_.end() && (std::abs(time - at->second.first) > kLongest || at->second.parts.contains(begin));
  if (stale) {
    ++incomplete_;
    pending_.erase(at);
  }
  if (pending_.size() >= kMostPending) {
    const auto oldest = std::min_element(pending_.begin(), pending_.end(),
                                         [](const auto& a, const auto& b) { return a.second.first < b.second.first; });
    ++incomplete_;
    pending_.erase(oldest);
  }
  Fragments& all = pending_[key];
  if (all.parts.empty()) all.first = time;
  all.parts[begin] = end;
  if (all.bytes.size() < end) all.bytes.resize(end);
  std::copy(packet.payload.begin(), packet.payload.end(), all.bytes.begin() + static_cast<std::ptrdiff_t>(begin));
  if (!packet.more) all.total = end;
  std::size_t reached = 0;
  for (const auto& [from, to] : all.parts) {
    if (from > reached) break;
    reached = std::max(reached, to);
  }
  if (all.total == 0 || reached < all.total) return false;
  whole_ = std::move(all.bytes);
  whole_.resize(all.total);
  pending_.erase(key);
  whole = whole_;
  return true;
}

}  // namespace aslio::io::packets
