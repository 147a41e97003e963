#include "aslio/io/cdr.hpp"

#include <fmt/format.h>

#include <cstring>
#include <map>
#include <type_traits>

#include "aslio/core/errors.hpp"
#include "aslio/io/rosbag/messages.hpp"
#include "decode/wire.hpp"
#include "lidar_decoder.hpp"
#include "packets/velodyne.hpp"

namespace aslio::io {
namespace {

using decode::Wire;

/// Appends values aligned to their size from the begin of the values, which is behind the encapsulation.
class CdrOutput {
 public:
  explicit CdrOutput(std::vector<std::uint8_t>& out) : out_(out) {
    out_.assign({0, 1, 0, 0});  // plain CDR, little-endian, no options
  }

  template <class T>
  requires std::is_arithmetic_v<T>
  void put(T value) {
    while ((out_.size() - 4) % sizeof(T) != 0) out_.push_back(0);
    const std::size_t at = out_.size();
    out_.resize(at + sizeof(T));
    std::memcpy(out_.data() + at, &value, sizeof(T));
  }
  void put_bytes(std::span<const std::uint8_t> bytes) { out_.insert(out_.end(), bytes.begin(), bytes.end()); }
  void put_text(std::string_view text) {
    put(static_cast<std::uint32_t>(text.size() + 1));
    out_.insert(out_.end(), text.begin(), text.end());
    out_.push_back(0);
  }

 private:
  std::vector<std::uint8_t>& out_;
};

void copy_header(Wire& in, CdrOutput& out) {
  const TimeNs stamp = in.header();
  out.put(static_cast<std::int32_t>(stamp / kSecond));
  out.put(static_cast<std::uint32_t>(stamp % kSecond));
  out.put_text(in.frame());
}

template <class T>
void copy(Wire& in, CdrOutput& out, std::uint64_t count = 1) {
  for (std::uint64_t i = 0; i < count && in.ok(); ++i) out.put(in.get<T>());
}

/// A sequence of bytes.
void copy_bytes(Wire& in, CdrOutput& out) {
  const auto bytes = in.take(in.get<std::uint32_t>());
  out.put(static_cast<std::uint32_t>(bytes.size()));
  out.put_bytes(bytes);
}

void copy_imu(Wire& in, CdrOutput& out) { copy<double>(in, out, 4 + 9 + 3 + 9 + 3 + 9); }

void copy_cloud(Wire& in, CdrOutput& out) {
  copy<std::uint32_t>(in, out, 2);  // height, width
  const auto fields = in.get<std::uint32_t>();
  out.put(fields);
  for (std::uint32_t i = 0; i < fields && in.ok(); ++i) {
    out.put_text(in.text());
    copy<std::uint32_t>(in, out);
    copy<std::uint8_t>(in, out);
    copy<std::uint32_t>(in, out);
  }
  copy<std::uint8_t>(in, out);      // is_bigendian
  copy<std::uint32_t>(in, out, 2);  // point_step, row_step
  copy_bytes(in, out);
  copy<std::uint8_t>(in, out);  // is_dense
}

void copy_livox(Wire& in, CdrOutput& out) {
  copy<std::uint64_t>(in, out);    // timebase
  copy<std::uint32_t>(in, out);    // point_num
  copy<std::uint8_t>(in, out, 4);  // lidar_id, rsvd
  const auto points = in.get<std::uint32_t>();
  out.put(points);
  for (std::uint32_t i = 0; i < points && in.ok(); ++i) {
    copy<std::uint32_t>(in, out);
    copy<float>(in, out, 3);
    copy<std::uint8_t>(in, out, 3);
  }
}

/// Raw packets of a Velodyne.
void copy_packets(Wire& in, CdrOutput& out) {
  const auto packets = in.get<std::uint32_t>();
  out.put(packets);
  for (std::uint32_t i = 0; i < packets && in.ok(); ++i) {
    const TimeNs received = in.time();
    out.put(static_cast<std::int32_t>(received / kSecond));
    out.put(static_cast<std::uint32_t>(received % kSecond));
    out.put_bytes(in.take(packets::kVelodyneDataBytes));
  }
}

/// Messages of doubles behind the header, which references come in.
std::uint64_t doubles_of(const Connection& connection) {
  if (connection.encoding != Encoding::ros1) return 0;
  if (connection.type == rosbag::kPoseStamped.name) return 7;
  return connection.type == rosbag::kPointStamped.name ? 3 : 0;
}

bool converts(const Connection& connection) {
  const MessageKind kind = message_kind(connection);
  if (kind == MessageKind::packets) return connection.type == rosbag::kVelodyneScan.name;
  return kind != MessageKind::other || doubles_of(connection) > 0;
}

void replace_all(std::string& text, std::string_view from, std::string_view to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size())) {
    text.replace(at, from.size(), to);
  }
}

}  // namespace

std::string ros2_definition(std::string_view ros1) {
  std::string text(ros1);
  replace_all(text, "MSG: std_msgs/Header\nuint32 seq\n", "MSG: std_msgs/Header\n");
  replace_all(text, "\ntime ", "\nbuiltin_interfaces/Time ");
  if (text.find("builtin_interfaces/Time ") == std::string::npos) return text;
  return text + std::string(80, '=') + "\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n";
}

std::string ros2_type(const std::string& type) {
  const auto slash = type.find('/');
  if (slash == std::string::npos || type.find('/', slash + 1) != std::string::npos) return type;
  return type.substr(0, slash) + "/msg" + type.substr(slash);
}

std::string to_cdr(const Connection& ros1, std::span<const std::uint8_t> bytes, std::vector<std::uint8_t>& out) {
  if (!converts(ros1)) return "no conversion of " + ros1.type + " to CDR";
  Wire in({bytes, Encoding::ros1});
  CdrOutput to(out);
  copy_header(in, to);
  switch (message_kind(ros1)) {
    case MessageKind::imu:
      copy_imu(in, to);
      break;
    case MessageKind::cloud:
      copy_cloud(in, to);
      break;
    case MessageKind::livox:
      copy_livox(in, to);
      break;
    case MessageKind::packets:
      copy_packets(in, to);
      break;
    case MessageKind::other:
      copy<double>(in, to, doubles_of(ros1));
      break;
  }
  return in.ok() ? std::string{} : in.problem(ros1.type);
}

std::vector<std::string> copy_messages(MessageReader& from, MessageWriter& to, Encoding encoding) {
  struct Target {
    const Connection* from = nullptr;
    std::uint32_t id = 0;
    bool convert = false;
  };
  std::map<std::uint32_t, Target> targets;
  std::vector<std::uint32_t> ids;
  std::vector<std::string> left_out;
  for (const Connection& c : from.connections()) {
    const bool convert = c.encoding != encoding;
    if (convert && (encoding != Encoding::cdr || !converts(c))) {
      left_out.push_back(c.topic);
      continue;
    }
    Connection target = c;
    target.encoding = encoding;
    if (convert) {
      target.type = ros2_type(c.type);
      target.md5 = target.definition = {};
    }
    targets[c.id] = {&c, to.add(target), convert};
    ids.push_back(c.id);
  }
  from.select(ids);
  std::vector<std::uint8_t> bytes;
  for (RawMessage message; from.next(message);) {
    const Target& target = targets.at(message.connection);
    if (target.convert) {
      if (const std::string why = to_cdr(*target.from, message.bytes, bytes); !why.empty()) {
        throw DataError(fmt::format("{}: a message of {} ns: {}", target.from->topic, message.time, why));
      }
      message.bytes = bytes;
    }
    to.write(target.id, message.time, message.bytes);
  }
  return left_out;
}

}  // namespace aslio::io
