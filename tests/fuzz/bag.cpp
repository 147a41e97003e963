#include "aslio/io/rosbag/reader.hpp"
#include "fuzz/target.hpp"

ASLIO_FUZZ_TARGET(bag) {
  const auto path = written("input.bag", bytes);
  accepts([&] {
    io::rosbag::BagReader reader(path);
    io::rosbag::BagMessage message;
    std::uint64_t sum = 0, most = 0;
    for (std::size_t i = 0; reader.next(message); ++i) {
      for (const std::uint8_t byte : message.bytes) sum += byte;
      most += message.bytes.size();
      // Nothing in a file can make it yield more than its chunks hold once decompressed.
      must(i <= 200 * bytes.size() && most <= 200 * bytes.size(), "a bag has no more messages than its bytes allow");
    }
    must(sum <= 255 * most, "every byte of a message can be read");
    for (const io::rosbag::Connection& connection : reader.connections()) {
      const std::uint32_t id = connection.id;
      reader.select({&id, 1});
      while (reader.next(message)) must(message.connection == id, "only selected connections are read");
      break;
    }
  });
}
