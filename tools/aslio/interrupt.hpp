#pragma once

namespace aslio::cli {

/// From here on SIGINT, SIGTERM and (unless ignored, as under nohup) SIGHUP ask the run to stop; a second one ends the
/// process at once.
void catch_interrupts();
bool interrupted();

}  // namespace aslio::cli
