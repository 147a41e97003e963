#pragma once

#include <filesystem>
#include <string>

#include "aslio/io/writers.hpp"
#include "aslio/simulator/simulation.hpp"
#include "record/cell_set.hpp"

namespace aslio::simulator {

/// truth.csv.
void write_truth_table(const Simulation& simulation, const std::filesystem::path& path);

/// overlap.csv: true overlap block by block.
class OverlapTable {
 public:
  explicit OverlapTable(const std::filesystem::path& path);
  void add(const CellBlock& block, TimeNs end);
  void close() { file_.close(); }

 private:
  io::AtomicFile file_;
  CellSet seen_;
};

/// Sensor file that fits the bag; its extrinsic is what a stress study makes of it.
std::string sensor_file(const Simulation& simulation);
/// The scene as it was simulated.
std::string scene_file(const Simulation& simulation, const SceneFile& scene);
/// Dataset file over the files beside it.
std::string dataset_file(const Simulation& simulation, const std::string& name, const std::string& input);

}  // namespace aslio::simulator
