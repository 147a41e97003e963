#pragma once
/// sensor_msgs/PointCloud2: a table of fields, read with memcpy, and a verdict on the time of each point.

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "decode.hpp"

namespace aslio::io::decode {

struct CloudField {
  std::uint32_t offset = 0;
  std::uint8_t datatype = 0;  ///< 0: absent
  bool swapped = false;       ///< of the other byte order than this machine's
  bool present() const { return datatype != 0; }
};

/// The parts of the field table that are used.
struct CloudTable {
  std::array<CloudField, 3> xyz;
  CloudField intensity, ring, tag, time;
  std::string time_name, all_names;
  std::string time_like;     ///< a field that is not used, but whose name speaks of time
  bool livox_lines = false;  ///< the ring field is a Livox `line`
};

struct CloudView {
  TimeNs stamp = 0;
  std::string_view frame;  ///< frame_id; as long as the message lives
  CloudTable table;
  std::uint32_t width = 0, height = 0, point_step = 0, row_step = 0;
  Bytes data;
  bool flagged_big_endian = false, row_step_wrong = false;  ///< what was read all the same

  /// The fields are of the other byte order than this machine's.
  bool swapped() const { return table.xyz[0].swapped; }
};

/// Checks sizes and fields. `systematic` tells that every message of this topic will fail alike. `time_field`: that
/// with the time of a point; empty: by the names that drivers use.
std::string parse_cloud(const Message& message, CloudView& view, bool& systematic, std::string_view time_field = {});

struct CloudTimeRule {
  bool known = false;
  double to_ns = 1;           ///< field value times this is ns
  bool absolute = false;      ///< otherwise relative to the header stamp and `shift`
  bool own_clock = false;     ///< absolute times of another clock than the header's
  TimeNs shift = 0;           ///< from the header stamp to what relative times count from [ns]
  std::uint8_t datatype = 0;  ///< of the time field it was judged by
  std::string verdict;        ///< what was decided, or why it cannot be known
  std::string doubt;          ///< what is odd about it; empty: nothing
};

/// What times are judged by, besides the cloud.
struct CloudTimeFacts {
  double sweep_period = 0.1;  ///< [s]
  InputTimes declared;
  std::optional<TimeNs>
      imu_time;  ///< of the IMU at about that time: absolute times of its clock count, whatever the header
};

/// Decides unit and reference of the time field by the span of one cloud against the sweep period.
CloudTimeRule judge_cloud_times(const CloudView& view, const CloudTimeFacts& facts);

/// Smallest and largest time of all returns, and of their middle nine tenths, as they stand in the field.
struct CloudTimeExtent {
  double low = 0, high = 0;
  std::size_t count = 0;
};
std::array<CloudTimeExtent, 2> cloud_time_extents(const CloudView& view);

/// "uint32"
std::string_view cloud_datatype_name(std::uint8_t datatype);

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
