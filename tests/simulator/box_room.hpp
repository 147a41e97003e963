#pragma once
/// A bare room of 16 x 10 x 3 m as a mesh file, and a scene that walks round in it.

#include "aslio/simulator/scene.hpp"
#include "temporary_folder.hpp"

namespace aslio::simulator::test {

inline constexpr double kWestWall = -3, kEastWall = 13, kSouthWall = -3, kNorthWall = 7;

/// Six quadrilaterals in Wavefront format.
inline constexpr const char* kRoomObj =
    "v -3 -3 0\nv 13 -3 0\nv 13 7 0\nv -3 7 0\nv -3 -3 3\nv 13 -3 3\nv 13 7 3\nv -3 7 3\n"
    "f 1 2 3 4\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

inline std::string room_scene(const std::string& more = "") {
  return "schema: aslio/scene/1\n"
         "world: {type: mesh, file: room.obj}\n"
         "route: [{x: 5, y: 0}, {x: 10, y: 0}, {x: 10, y: 4}, {x: 0, y: 4}, {x: 0, y: 0}]\n"
         "walk: {standstill: 0.5}\n" +
         more;
}

inline SceneFile room(const aslio::test::TemporaryFolder& folder, const std::string& more = "") {
  folder.write("room.obj", kRoomObj);
  return load_scene(folder.write("room.yaml", room_scene(more)));
}

}  // namespace aslio::simulator::test
