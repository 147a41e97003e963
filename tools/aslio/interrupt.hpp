#pragma once

namespace aslio::cli {

/// From here on SIGINT and SIGTERM ask the run to stop; a second one ends the process at once.
void catch_interrupts();
bool interrupted();

}  // namespace aslio::cli
