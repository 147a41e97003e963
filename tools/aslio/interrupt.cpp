#include "interrupt.hpp"

#include <csignal>

namespace aslio::cli {

namespace {
// The only mutable static: a signal handler can reach nothing else.
volatile std::sig_atomic_t stop = 0;
void request_stop(int) { stop = 1; }
}  // namespace

void catch_interrupts() {
  struct sigaction action {};
  action.sa_handler = request_stop;
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  // nohup leaves SIGHUP ignored, and means it.
  struct sigaction before {};
  if (sigaction(SIGHUP, nullptr, &before) == 0 && before.sa_handler != SIG_IGN) sigaction(SIGHUP, &action, nullptr);
}

bool interrupted() { return stop != 0; }

}  // namespace aslio::cli
