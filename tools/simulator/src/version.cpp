#include "aslio/simulator/version.hpp"

#include "simulator_sources.hpp"

namespace aslio::simulator {

std::string_view sources_digest() { return ASLIO_SIMULATOR_SOURCES; }

}  // namespace aslio::simulator
