#pragma once
/// sensor_msgs/PointCloud2: a table of fields, read with memcpy, and a verdict on the time of each point.

#include <array>
#include <optional>
#include <string>

#include "decode.hpp"

namespace aslio::io::decode {

struct CloudField {
  std::uint32_t offset = 0;
  std::uint8_t datatype = 0;  ///< 0: absent
  bool present() const { return datatype != 0; }
};

/// The parts of the field table that are used.
struct CloudTable {
  std::array<CloudField, 3> xyz;
  CloudField intensity, ring, tag, time;
  std::string time_name, all_names;
  bool livox_lines = false;  ///< the ring field is a Livox `line`
};

struct CloudView {
  TimeNs stamp = 0;
  CloudTable table;
  std::uint32_t width = 0, height = 0, point_step = 0, row_step = 0;
  Bytes data;
};

/// Checks sizes and fields. `systematic` tells that every message of this topic will fail alike.
std::string parse_cloud(const Message& message, CloudView& view, bool& systematic);

struct CloudTimeRule {
  bool known = false;
  double to_ns = 1;           ///< field value times this is ns
  bool absolute = false;      ///< otherwise relative to the header stamp
  std::uint8_t datatype = 0;  ///< of the time field it was judged by
  std::string verdict;        ///< what was decided, or why it cannot be known
};

/// Decides unit and reference of the time field by the span of one cloud against the sweep period [s].
CloudTimeRule judge_cloud_times(const CloudView& view, double sweep_period);

struct CloudRule {
  CloudTimeRule time;
  bool tag_filter = true;
  int scan_lines = 128;
  TimeNs longest_offset = kSecond;  ///< points farther from the stamp are damage
};

/// Points of one cloud. With a known time rule, a cloud is refused that lacks its field or has it in another type, and
/// one whose points all share one time (zero-filled field).
std::string decode_cloud(const CloudView& view, const CloudRule& rule, LidarPacket& packet);

}  // namespace aslio::io::decode
