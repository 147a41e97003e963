#include "aslio/experiment/version.hpp"

#include "git_revision.hpp"  // generated at every build

namespace aslio::experiment {

std::string_view version() { return ASLIO_VERSION; }
std::string_view source_revision() { return ASLIO_GIT_REVISION; }

}  // namespace aslio::experiment
