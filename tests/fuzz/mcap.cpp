#include "aslio/io/message_reader.hpp"
#include "fuzz/target.hpp"

ASLIO_FUZZ_TARGET(mcap) {
  const auto path = written("input.mcap", bytes);
  accepts([&] {
    const auto reader = io::open_messages(path);
    io::RawMessage message;
    std::uint64_t sum = 0, most = 0;
    // Nothing in a file can make it yield more than its chunks hold once decompressed.
    const std::uint64_t room = (std::uint64_t{1} << 16U) * (bytes.size() + 1);
    while (reader->next(message)) {
      for (const std::uint8_t byte : message.bytes) sum += byte;
      most += message.bytes.size() + 1;
      must(most <= room, "an MCAP file has no more messages than its bytes allow");
    }
    must(sum <= 255 * most, "every byte of a message can be read");
    for (const io::Connection& connection : reader->connections()) {
      const std::uint32_t id = connection.id;
      reader->select({&id, 1});
      while (reader->next(message)) must(message.connection == id, "only selected channels are read");
      break;
    }
  });
}
