#pragma once
/// Points as the data packets of a VLP-16: the counterpart of velodyne.hpp.

#include <vector>

#include "aslio/core/measurement.hpp"
#include "aslio/io/rosbag/messages.hpp"

namespace aslio::io::packets {

class Vlp16Encoder {
 public:
  /// Of a whole turn, whose points lie on the beams of a VLP-16 and on its cycle of 55.296 us; all lasers of a cycle
  /// share its time. Ranges are rounded to 2 mm, azimuths to 0.01 deg, times of the packets to 1 us. Beams without a
  /// point have no return, as has what is farther than 131 m. Throws DataError for points of another sensor.
  void encode(const LidarPacket& sweep, std::vector<rosbag::VelodynePacketFields>& packets);

 private:
  struct Hit {
    std::size_t cycle = 0, laser = 0;
    double azimuth = 0;          ///< [deg], clockwise from x
    std::uint16_t distance = 0;  ///< [2 mm]
    std::uint8_t intensity = 0;
  };
  /// Returns the time of the first cycle.
  TimeNs find_hits(const LidarPacket& sweep);
  /// Azimuth of the head at the first cycle [deg], by all hits.
  double first_azimuth() const;

  std::vector<Hit> hits_;
};

}  // namespace aslio::io::packets
