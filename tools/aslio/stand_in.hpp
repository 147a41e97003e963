#pragma once
/// Simulated stand-ins of published sequences: `aslio simulate --as`.

#include <filesystem>
#include <string>
#include <vector>

#include "aslio/simulator/record.hpp"
#include "simulate.hpp"

namespace aslio::cli {

/// All that a simulation takes from the family.
struct StandInPlan {
  std::string family, sequence, title, url;
  std::vector<std::string> overrides;  ///< of the scene, in front of those of the user
  simulator::SimulationOptions simulation;
  simulator::RecordLayout layout;
  int published_lines = 0;
  std::int64_t published_columns = 0;
  std::filesystem::path beside;  ///< folder of the truth and the other files of the simulator
};

/// Throws ConfigError for a family or sequence that is not there or has no layout, and for an output folder that holds
/// data of another origin, or this sequence already.
StandInPlan plan_stand_in(const SimulateArguments& arguments);

/// Says in the output folder that its data are simulated. To be called before there are data.
void write_stand_in_note(const StandInPlan& plan, const simulator::Simulation& simulation,
                         const std::filesystem::path& output);

/// What was written, how it differs from the published data, and how to run it.
std::string stand_in_report(const StandInPlan& plan, const simulator::Simulation& simulation,
                            const simulator::RecordResult& result, const std::filesystem::path& output);

}  // namespace aslio::cli
