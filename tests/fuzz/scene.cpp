#include "aslio/simulator/scene.hpp"

#include "fuzz/yaml.hpp"

ASLIO_FUZZ_TARGET(scene) {
  const auto path = written("input.yaml", bytes);
  accepts([&] {
    const simulator::SceneFile scene = simulator::load_scene(path);
    const auto again =
        written("again.yaml", {reinterpret_cast<const std::uint8_t*>(scene.resolved.data()), scene.resolved.size()});
    must(simulator::load_scene(again).resolved == scene.resolved, "a resolved configuration reads back to itself");
  });
}
