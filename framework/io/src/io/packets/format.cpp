#include "format.hpp"

#include <algorithm>

namespace aslio::io::packets {

void add_point(const Vec3& p, TimeNs t, double intensity, int line, int scan_lines, LidarPacket& out) {
  if (line >= scan_lines) {
    ++out.beyond_lines;
    ++out.dropped_invalid;
    out.highest_line = std::max(out.highest_line, static_cast<std::uint8_t>(line));
    return;
  }
  TimedPoint& point = out.points.emplace_back();
  point.x = static_cast<float>(p.x());
  point.y = static_cast<float>(p.y());
  point.z = static_cast<float>(p.z());
  point.intensity = static_cast<float>(intensity);
  point.t = t;
  point.sweep_id = out.sweep_id;
  point.line = static_cast<std::uint8_t>(line);
}

}  // namespace aslio::io::packets
