#pragma once
/// A short recording of a bare room, made anew for each test.

#include <catch2/catch.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "aslio/io/rosbag/messages.hpp"
#include "aslio/io/rosbag/reader.hpp"
#include "aslio/simulator/record.hpp"
#include "simulator/box_room.hpp"

namespace aslio::simulator::test {

/// 4 m x 4 m at 3 m/s: some 7 s.
inline std::string quick_scene(const std::string& more = "") {
  return "schema: aslio/scene/1\n"
         "description: A test of <recordings> & \"more\".\n"
         "world: {type: mesh, file: room.obj}\n"
         "route: [{x: 0, y: 0}, {x: 4, y: 0}, {x: 4, y: 4}, {x: 0, y: 4}]\n"
         "walk: {standstill: 0.5, speed: 3, corner_speed: 2}\n" +
         more;
}

struct Recorded {
  aslio::test::TemporaryFolder folder;
  SceneFile scene;
  Simulation simulation;
  RecordResult result;

  explicit Recorded(const std::string& more = "", int threads = 1, const SimulationOptions& options = {})
      : scene(written(folder, more)), simulation(scene, options) {
    if (!record(simulation, scene, {folder / "out", threads, true, "quick"}, nullptr, result))
      throw std::logic_error("nobody has stopped it");
  }
  std::filesystem::path operator/(const std::string& name) const { return folder / ("out/" + name); }

 private:
  static SceneFile written(const aslio::test::TemporaryFolder& folder, const std::string& more) {
    folder.write("room.obj", kRoomObj);
    return load_scene(folder.write("quick.yaml", quick_scene(more)));
  }
};

struct Stamps {
  std::vector<TimeNs> arrival, stamp;
};

/// Arrival and header times of the messages of one topic.
inline Stamps stamps(const Recorded& recorded, const std::string& topic) {
  io::rosbag::BagReader bag(recorded / "quick.bag");
  Stamps all;
  io::rosbag::BagMessage message;
  TimeNs last = 0;
  while (bag.next(message)) {
    CHECK(message.time >= last);
    last = message.time;
    if (bag.connections().at(message.connection).topic != topic) continue;
    // std_msgs/Header: seq, seconds, nanoseconds.
    const auto word = [&](std::size_t at) {
      std::uint32_t value = 0;
      for (std::size_t k = 4; k-- > 0;) value = value << 8U | message.bytes[at + k];
      return static_cast<TimeNs>(value);
    };
    all.arrival.push_back(message.time);
    all.stamp.push_back(word(4) * kSecond + word(8));
  }
  return all;
}

}  // namespace aslio::simulator::test
