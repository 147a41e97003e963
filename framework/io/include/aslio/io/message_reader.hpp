#pragma once
/// Recordings of messages, whatever the container: ROS1 bags, MCAP files, rosbag2 databases. A reader yields serialised
/// messages by time of recording, in bounded memory; who decodes them looks at their encoding and type.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "aslio/core/time.hpp"
#include "aslio/io/source.hpp"

namespace aslio::io {

/// How a message is serialised.
enum class Encoding : std::uint8_t {
  ros1,  ///< packed, little-endian
  cdr,   ///< OMG CDR as ROS2 stores it: 4 bytes of encapsulation, values aligned to their size
  other  ///< none that can be decoded
};

/// Messages of one type on one topic. A topic may have several connections.
struct Connection {
  std::uint32_t id = 0;
  std::string topic, type, md5, definition;  ///< md5 and definition: empty where the container does not tell
  Encoding encoding = Encoding::ros1;
};

struct RawMessage {
  std::uint32_t connection = 0;              ///< Connection::id
  TimeNs time = 0;                           ///< when it was recorded
  std::span<const std::uint8_t> bytes = {};  ///< valid until the next call
  Encoding encoding = Encoding::ros1;        ///< of its connection
};

class MessageReader {
 public:
  virtual ~MessageReader() = default;
  /// What it reads, for people: "ROS1 bag", "MCAP file", ..
  virtual std::string kind() const = 0;
  /// By id, ascending.
  virtual const std::vector<Connection>& connections() const = 0;
  /// Record time of the first and last message; nullopt where there is none.
  virtual std::optional<TimeNs> begin_time() const = 0;
  virtual std::optional<TimeNs> end_time() const = 0;
  /// Restricts reading to these connections (all of them before the first call) and starts over.
  virtual void select(std::span<const std::uint32_t> ids) = 0;
  /// Next message by record time; messages of equal time in file order. False at the end. Throws DataError for damage.
  virtual bool next(RawMessage& message) = 0;
  /// `truncated` once it is known that the input ends before its last record does.
  virtual InputStatus status() const = 0;
  virtual const std::vector<std::string>& warnings() const = 0;
  /// What was found out beforehand of the data, to be stated: "imu ..." of the IMU, others of the LiDAR.
  virtual const std::vector<std::string>& verdicts() const {
    static const std::vector<std::string> none;
    return none;
  }
};

/// Opens a recording: a file (by its first bytes, not by its name), a folder of its parts, or a pattern with `*`. A
/// file that has to be decompressed as a whole goes to a hidden file in `scratch` (empty: the folder of temporary
/// files). Throws DataError naming file, what it is, and the remedy.
std::unique_ptr<MessageReader> open_messages(const std::filesystem::path& input,
                                             const std::filesystem::path& scratch = {});
/// Several inputs as one recording: parts of a run, a file per sensor.
std::unique_ptr<MessageReader> open_messages(std::span<const std::filesystem::path> inputs,
                                             const std::filesystem::path& scratch = {});

/// Several recordings as one, in the order of record time; at equal times in the order given. Connections get new
/// numbers. Pre: at least one.
std::unique_ptr<MessageReader> merge_messages(std::vector<std::unique_ptr<MessageReader>> parts,
                                              std::vector<std::string> warnings = {});

}  // namespace aslio::io
