#pragma once
/// Decodes the messages of one LiDAR topic, by the kind of message. Opening judges the first messages; after that,
/// single malformed messages are skipped and counted.

#include <memory>
#include <optional>
#include <string>

#include "aslio/core/measurement.hpp"
#include "aslio/io/message_reader.hpp"
#include "decode/decode.hpp"

namespace aslio::io {

class LidarDecoder {
 public:
  virtual ~LidarDecoder() = default;
  /// Judges times by messages with returns, the first ones in their order. True once decided. Throws DataError when a
  /// message, or the topic for its times, cannot be used.
  virtual bool judge(const decode::Message& message, SourceNotes& notes) = 0;
  /// At the end of the messages, undecided: judges by what there was, or says that there was nothing to judge by.
  virtual void assume(SourceNotes& notes) = 0;
  /// Empty, or what is wrong with the message.
  virtual std::string decode(const decode::Message& message, LidarPacket& packet) = 0;
  /// The message decoded last is of a sensor that is not wanted.
  virtual bool skipped() const { return false; }
  /// The header stamps are of another clock than the points: the stamp of a decoded packet counts alone.
  virtual bool own_clock() const { return false; }
  /// What only all messages decoded so far tell; empty: nothing.
  virtual std::string remark() const { return {}; }
};

/// What a message is, whatever the package or distribution that it comes from.
enum class MessageKind : std::uint8_t { other, livox, cloud, packets, imu };

/// ROS1: by the checksum, and by the name where there is none (or `*`). ROS2: by the name.
MessageKind message_kind(const Connection& connection);
bool is_lidar(const Connection& connection);
bool is_imu(const Connection& connection);
/// A type of a name that can be read, yet not of its checksum or encoding.
bool is_known_name(const Connection& connection);

/// For a connection of a LiDAR type. `where` names file and topic in messages; `imu_time`: of the IMU where the
/// recording begins, if it is known.
std::unique_ptr<LidarDecoder> make_lidar_decoder(const Connection& connection, const SensorConfig& sensor,
                                                 std::string where, std::optional<TimeNs> imu_time = {});

}  // namespace aslio::io
