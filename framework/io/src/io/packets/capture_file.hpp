#pragma once
/// UDP datagrams of a network capture, by libpcap: pcap and pcapng; Ethernet with VLAN tags, Linux cooked, raw IP and
/// loopback; IPv4 and IPv6, with fragments put together.

#include <array>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "aslio/io/source.hpp"
#include "format.hpp"

struct pcap;

namespace aslio::io::packets {

struct Datagram {
  TimeNs time = 0;         ///< when it was captured; of its last fragment
  std::string address;     ///< of the sender, as people write it
  std::uint16_t port = 0;  ///< that it was sent to
  Bytes payload;           ///< valid until the next call
};

/// True for a file that begins as pcap or pcapng does. False for what cannot be read.
bool is_capture(const std::filesystem::path& path);

class CaptureFile {
 public:
  /// Throws DataError when it is no capture, or of a link that is not known.
  explicit CaptureFile(std::filesystem::path path);
  ~CaptureFile();
  CaptureFile(const CaptureFile&) = delete;
  CaptureFile& operator=(const CaptureFile&) = delete;

  /// Next datagram in the order of the file; what is no UDP is passed over. False at the end.
  bool next(Datagram& datagram);
  /// Starts over.
  void rewind();
  InputStatus status() const { return status_; }
  /// Why the status is `truncated`; empty otherwise.
  const std::string& damage() const { return damage_; }
  /// Datagrams so far that were captured in part, or of which fragments are missing.
  std::uint64_t incomplete() const { return incomplete_; }

 private:
  /// Addresses, identification and protocol of a datagram in fragments.
  using FragmentKey = std::array<std::uint8_t, 40>;
  struct Fragments {
    TimeNs first = 0;
    std::map<std::size_t, std::size_t> parts;  ///< end by begin
    std::vector<std::uint8_t> bytes;
    std::size_t total = 0;  ///< 0: the last one has not come
  };
  struct Internet;

  bool read_frame(Bytes frame, TimeNs time, Datagram& datagram);
  bool read_udp(const Internet& packet, Datagram& datagram);
  bool complete(const Internet& packet, TimeNs time, Bytes& whole);

  std::filesystem::path path_;
  std::unique_ptr<pcap, void (*)(pcap*)> pcap_;
  int link_ = 0;
  std::map<FragmentKey, Fragments> pending_;
  std::vector<std::uint8_t> whole_;  ///< of the last datagram that came in fragments
  InputStatus status_ = InputStatus::complete;
  std::string damage_;
  std::uint64_t incomplete_ = 0;
};

}  // namespace aslio::io::packets
