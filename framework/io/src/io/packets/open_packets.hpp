#pragma once
/// Recordings with the packets of sensors in them, whatever the container.

#include <filesystem>
#include <memory>
#include <span>

#include "aslio/io/message_reader.hpp"
#include "aslio/io/source.hpp"

namespace aslio::io::packets {

/// Opens a network capture, or any recording of open_messages, with packets in the form that decoders take. Several
/// inputs are one recording, captures cannot be among them. Pre: at least one.
std::unique_ptr<MessageReader> open_with_packets(std::span<const std::filesystem::path> inputs,
                                                 const SensorConfig& sensor);

}  // namespace aslio::io::packets
