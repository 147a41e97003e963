#include "open_packets.hpp"

#include <fmt/format.h>

#include "aslio/core/errors.hpp"
#include "capture_file.hpp"
#include "ouster_messages.hpp"
#include "pcap_reader.hpp"

namespace aslio::io::packets {

std::unique_ptr<MessageReader> open_with_packets(std::span<const std::filesystem::path> inputs,
                                                 const SensorConfig& sensor) {
  std::error_code ignored;
  for (const std::filesystem::path& path : inputs) {
    if (!std::filesystem::is_regular_file(path, ignored) || !is_capture(path)) continue;
    if (inputs.size() == 1) return open_capture(path, sensor);
    throw DataError(
        fmt::format("{}: a network capture cannot be one of several inputs: merge the captures with "
                    "`mergecap -w all.pcap A.pcap B.pcap`",
                    path.string()));
  }
  return unpack_ouster(open_messages(inputs), inputs.front(), sensor);
}

}  // namespace aslio::io::packets
