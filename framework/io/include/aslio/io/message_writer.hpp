#pragma once
/// Writers of recordings, whatever the container: the counterpart of MessageReader.

#include <cstdint>
#include <memory>
#include <span>

#include "aslio/io/message_reader.hpp"

namespace aslio::io {

class MessageWriter {
 public:
  virtual ~MessageWriter() = default;
  /// Returns the id that write() takes; that of `connection` does not count. Throws DataError for an encoding that the
  /// container does not carry.
  virtual std::uint32_t add(const Connection& connection) = 0;
  /// `time` is the record time [ns], 0 or later; `bytes` the message, serialised as its connection says.
  virtual void write(std::uint32_t connection, TimeNs time, std::span<const std::uint8_t> bytes) = 0;
  /// The file appears under its name. Without it, the destructor removes what there is.
  virtual void close() = 0;
};

}  // namespace aslio::io
