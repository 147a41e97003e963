#pragma once
/// Decodes the messages of one LiDAR topic, by message checksum. Opening judges the first messages; after that, single
/// malformed messages are skipped and counted.

#include <memory>
#include <string>

#include "aslio/core/measurement.hpp"
#include "aslio/io/rosbag/reader.hpp"
#include "decode/decode.hpp"

namespace aslio::io {

class LidarDecoder {
 public:
  virtual ~LidarDecoder() = default;
  /// Judges times by messages with returns, the first ones in their order. True once decided. Throws DataError when a
  /// message, or the topic for its times, cannot be used.
  virtual bool judge(decode::Bytes message, SourceNotes& notes) = 0;
  /// At the end of the messages, undecided: judges by what there was, or says that there was nothing to judge by.
  virtual void assume(SourceNotes& notes) = 0;
  /// Empty, or what is wrong with the message.
  virtual std::string decode(decode::Bytes message, LidarPacket& packet) = 0;
};

bool is_lidar(const rosbag::Connection& connection);
bool is_imu(const rosbag::Connection& connection);

/// For a connection of a LiDAR type. `where` names file and topic in messages.
std::unique_ptr<LidarDecoder> make_lidar_decoder(const rosbag::Connection& connection, const SensorConfig& sensor,
                                                 std::string where);

}  // namespace aslio::io
