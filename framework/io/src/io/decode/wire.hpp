#pragma once
/// Bounded reading of a serialised message, ROS1 or CDR. Past the end, every read yields zero and ok() turns false.

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

#include "aslio/core/time.hpp"
#include "decode.hpp"

namespace aslio::io::decode {

/// A value as it lies in memory, `swapped` when it is of the other byte order.
template <class T>
T load(const std::uint8_t* from, bool swapped) {
  std::array<std::uint8_t, sizeof(T)> bytes;
  std::memcpy(bytes.data(), from, sizeof(T));
  if (swapped) std::reverse(bytes.begin(), bytes.end());
  T value;
  std::memcpy(&value, bytes.data(), sizeof(T));
  return value;
}

class Wire {
 public:
  explicit Wire(const Message& message) : bytes_(message.bytes), cdr_(message.encoding == Encoding::cdr) {
    if (cdr_) read_encapsulation();
  }

  template <class T>
  requires std::is_arithmetic_v<T> T get() {
    align(sizeof(T));
    const auto from = take(sizeof(T));
    return from.empty() ? T{} : load<T>(from.data(), swapped_);
  }
  /// Empty when fewer than `count` bytes are left.
  std::span<const std::uint8_t> take(std::uint64_t count) {
    if (count > bytes_.size() - at_) {
      ok_ = false;
      at_ = bytes_.size();
      return {};
    }
    const auto part = bytes_.subspan(at_, static_cast<std::size_t>(count));
    at_ += part.size();
    return part;
  }
  /// Steps over `count` numbers of one type.
  template <class T>
  requires std::is_arithmetic_v<T>
  void skip(std::uint64_t count) {
    align(sizeof(T));
    take(count * sizeof(T));
  }
  /// Without the zero that ends it in CDR.
  std::string_view text() {
    const auto from = take(get<std::uint32_t>());
    const std::string_view all(reinterpret_cast<const char*>(from.data()), from.size());
    return cdr_ && all.ends_with('\0') ? all.substr(0, all.size() - 1) : all;
  }
  TimeNs time() {
    const TimeNs seconds = cdr_ ? TimeNs{get<std::int32_t>()} : TimeNs{get<std::uint32_t>()};
    return seconds * kSecond + get<std::uint32_t>();
  }
  /// A std_msgs/Header (seq in ROS1 alone, stamp, frame_id); returns the stamp.
  TimeNs header() {
    if (!cdr_) get<std::uint32_t>();
    const TimeNs stamp = time();
    frame_ = text();
    return stamp;
  }

  /// To a multiple of `size` from the begin of the values; ROS1 packs.
  void align(std::size_t size) {
    if (!cdr_) return;
    const std::size_t step = std::min(size, largest_alignment_), beyond = (at_ - kEncapsulation) % step;
    if (beyond != 0) take(step - beyond);
  }

  bool ok() const { return ok_; }
  bool cdr() const { return cdr_; }
  /// Numbers are of the other byte order than this machine's.
  bool swapped() const { return swapped_; }
  std::size_t left() const { return bytes_.size() - at_; }
  /// frame_id of the header that was read; as long as the message lives.
  std::string_view frame() const { return frame_; }
  /// Why `ok()` is false, for a message that should be a `what`.
  std::string problem(std::string_view what) const {
    if (!foreign_.empty()) return foreign_;
    return "the message is too short for " + std::string(what);
  }

 private:
  static constexpr std::size_t kEncapsulation = 4;

  /// Representation identifiers: OMG DDSI-RTPS 2.5, 10.5. Plain CDR (0, 1) and plain CDR2 (6, 7), even: big-endian.
  void read_encapsulation() {
    const auto head = take(kEncapsulation);
    if (head.empty()) return;
    const unsigned id = static_cast<unsigned>(head[0]) << 8U | head[1];
    swapped_ = id % 2 == 0;
    largest_alignment_ = id >= 6 ? 4 : 8;
    if (id <= 1 || id == 6 || id == 7) return;
    ok_ = false;
    at_ = bytes_.size();
    foreign_ = "its encapsulation " + std::to_string(id) + " is none of plain CDR (0, 1, 6, 7)";
  }

  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0, largest_alignment_ = 8;
  std::string_view frame_;
  std::string foreign_;
  bool ok_ = true, cdr_ = false, swapped_ = false;
};

}  // namespace aslio::io::decode
