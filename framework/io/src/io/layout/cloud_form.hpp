#pragma once
/// Points of a sweep as the fields of a PointCloud2 or of a file of points.

#include <cstdint>
#include <vector>

#include "aslio/io/layout_writer.hpp"
#include "aslio/io/rosbag/messages.hpp"

namespace aslio::io {

/// What a field holds.
enum class PointPart : std::uint8_t { x, y, z, intensity, line, time, reflectivity, tag, range_mm, nothing };

/// As sensor_msgs/PointField numbers them, and one more that only files have.
enum class NumberType : std::uint8_t { u8 = 2, u16 = 4, i32 = 5, u32 = 6, f32 = 7, f64 = 8, u64 = 9 };

struct FormField {
  const char* name;
  std::uint32_t offset;
  NumberType type;
  PointPart part;
};

struct CloudForm {
  std::vector<FormField> fields;
  std::uint32_t point_step = 0;
  PointOrigin origin = PointOrigin::start;  ///< of the driver
  double tick = 1;                          ///< a unit of the time field [ns]
  bool zero_invalid = false;                ///< beams without a return are (0, 0, 0), otherwise nan
};
/// Pre: a form of points, not of a message of its own.
const CloudForm& cloud_form(LidarForm form);
/// livox, livox2 and velodyne_packets are messages of their own.
bool is_cloud_form(LidarForm form);
bool is_livox_form(LidarForm form);

/// Time of a moment of the sweep that begins at `start`.
TimeNs moment_of(SweepMoment moment, TimeNs start, double period);

/// Fills in the points of sweeps.
class CloudEncoder {
 public:
  CloudEncoder(const LidarLayout& layout, const SweepGrid& grid);
  /// Points as they lie one after the other. Valid until the next call. Throws DataError for a point outside the grid,
  /// or a time that its field does not hold.
  const std::vector<std::uint8_t>& encode(const LidarPacket& sweep);
  /// Of the sweep encoded last.
  rosbag::CloudLayout layout() const;

 private:
  void order(const LidarPacket& sweep);
  void place_in_grid(const LidarPacket& sweep);
  void put(const TimedPoint& point, TimeNs origin, std::uint8_t* to) const;
  double number(const FormField& field, const TimedPoint& point, TimeNs origin) const;
  [[noreturn]] void refuse_time(const TimedPoint& point, double value) const;

  const LidarLayout layout_;
  const SweepGrid grid_;
  const CloudForm& form_;
  PointOrigin origin_;
  std::vector<TimedPoint> points_;
  std::vector<std::uint8_t> data_;
};

}  // namespace aslio::io
