#pragma once
/// Bounded reading of a serialised ROS1 message. Past the end, every read yields zero and ok() turns false.

#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>
#include <type_traits>

#include "aslio/core/time.hpp"

namespace aslio::io::decode {

class Wire {
 public:
  explicit Wire(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  template <class T>
  requires std::is_arithmetic_v<T> T get() {
    T value{};
    if (const auto from = take(sizeof(T)); !from.empty()) std::memcpy(&value, from.data(), sizeof(T));
    return value;
  }
  /// Empty when fewer than `count` bytes are left.
  std::span<const std::uint8_t> take(std::uint64_t count) {
    if (count > bytes_.size()) {
      ok_ = false;
      bytes_ = {};
      return {};
    }
    const auto front = bytes_.first(static_cast<std::size_t>(count));
    bytes_ = bytes_.subspan(static_cast<std::size_t>(count));
    return front;
  }
  std::string_view text() {
    const auto from = take(get<std::uint32_t>());
    return {reinterpret_cast<const char*>(from.data()), from.size()};
  }
  TimeNs time() {
    const TimeNs seconds = get<std::uint32_t>();
    return seconds * kSecond + get<std::uint32_t>();
  }
  /// seq, stamp, frame_id of a std_msgs/Header; returns the stamp.
  TimeNs header() {
    get<std::uint32_t>();
    const TimeNs stamp = time();
    text();
    return stamp;
  }

  bool ok() const { return ok_; }
  std::size_t left() const { return bytes_.size(); }

 private:
  std::span<const std::uint8_t> bytes_;
  bool ok_ = true;
};

}  // namespace aslio::io::decode
