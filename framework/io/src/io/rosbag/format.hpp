#pragma once
/// Constants and little-endian access of the ROS bag format 2.0 (http://wiki.ros.org/Bags/Format/2.0).

#include <bit>
#include <concepts>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "aslio/core/time.hpp"

namespace aslio::io::rosbag {

static_assert(std::endian::native == std::endian::little, "bags are little-endian and read with memcpy");

inline constexpr std::string_view kMagic = "#ROSBAG V2.0\n";
inline constexpr std::size_t kFileHeaderBytes = 4096;  ///< the bag header record is padded to this

enum class Op : std::uint8_t {
  message = 0x02,
  bag_header = 0x03,
  index_data = 0x04,
  chunk = 0x05,
  chunk_info = 0x06,
  connection = 0x07
};

template <class T>
requires std::is_trivially_copyable_v<T> T load(const std::uint8_t* from) {
  T value;
  std::memcpy(&value, from, sizeof(T));
  return value;
}

template <class T>
requires std::is_trivially_copyable_v<T>
void append(std::vector<std::uint8_t>& out, T value) {
  const std::size_t at = out.size();
  out.resize(at + sizeof(T));
  std::memcpy(out.data() + at, &value, sizeof(T));
}

inline void append_text(std::vector<std::uint8_t>& out, std::string_view text) {
  out.insert(out.end(), text.begin(), text.end());
}

inline void append_time(std::vector<std::uint8_t>& out, TimeNs t) {
  append(out, static_cast<std::uint32_t>(t / kSecond));
  append(out, static_cast<std::uint32_t>(t % kSecond));
}

/// With its length in front.
inline void append_string(std::vector<std::uint8_t>& out, std::string_view text) {
  append(out, static_cast<std::uint32_t>(text.size()));
  append_text(out, text);
}

struct HeaderFields;
/// Replaces the content of `out` with a std_msgs/Header.
void append_header(std::vector<std::uint8_t>& out, const HeaderFields& header);

inline TimeNs load_time(const std::uint8_t* from) {
  return static_cast<TimeNs>(load<std::uint32_t>(from)) * kSecond + load<std::uint32_t>(from + 4);
}

}  // namespace aslio::io::rosbag
