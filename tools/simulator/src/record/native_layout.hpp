#pragma once

#include "aslio/simulator/record.hpp"

namespace aslio::simulator {

/// The messages that the drivers of the sensors send, in the format of the options.
RecordLayout native_layout(const Simulation& simulation, const RecordOptions& options);

/// The recording by its name in the folder of the options.
std::string native_input(const RecordOptions& options);

/// A folder of parts would take those of an earlier recording for its own. Throws DataError.
void remove_earlier_parts(const RecordOptions& options);

}  // namespace aslio::simulator
