#include "console.hpp"

#include <fmt/format.h>
#include <spdlog/sinks/base_sink.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <mutex>
#include <string_view>
#include <system_error>

#include "aslio/core/errors.hpp"

namespace aslio::cli {

namespace {

void put(std::FILE* file, std::string_view text) { std::fwrite(text.data(), 1, text.size(), file); }

class TellingSink final : public spdlog::sinks::base_sink<std::mutex> {
  void sink_it_(const spdlog::details::log_msg& message) override {
    const std::string_view level(spdlog::level::to_string_view(message.level).data());
    tell(fmt::format("{}: {}", level, std::string_view(message.payload.data(), message.payload.size())));
  }
  void flush_() override {}
};

}  // namespace

std::string printable(std::string_view text) {
  std::string out(text);
  for (char& c : out) {
    const auto byte = static_cast<unsigned char>(c);
    if ((byte < 0x20 && c != '\n' && c != '\t') || byte == 0x7f) c = '?';
  }
  return out;
}

void print(std::string_view text) {
  errno = 0;
  const std::string clean = printable(text);
  const bool whole = std::fwrite(clean.data(), 1, clean.size(), stdout) == clean.size();
  if ((!whole || std::fflush(stdout) != 0) && errno != EPIPE) {
    throw DataError(fmt::format("stdout cannot be written: {}", std::generic_category().message(errno)));
  }
}

void tell(std::string_view line) {
  clear_bar();
  put(stderr, printable(line) + "\n");
}

void complain(std::string_view message) { tell(fmt::format("error: {}", message)); }

/// A line that is wider than the terminal would begin a new one each time.
void show_bar(std::string_view text) { put(stderr, "\r\033[K" + printable(text.substr(0, terminal_width() - 1))); }

void clear_bar() {
  if (stderr_is_terminal()) put(stderr, "\r\033[K");
}

void show_block(std::string_view lines) { put(stderr, printable(lines)); }

void clear_block(std::size_t lines) {
  std::string text = "\r\033[K";
  for (std::size_t i = 1; i < lines; ++i) text += "\033[A\033[K";  // one line up
  put(stderr, text);
}

std::size_t terminal_width() {
  winsize size{};
  const bool known = ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 1;
  return known ? size.ws_col : 80;
}

bool stderr_is_terminal() {
  const char* term = std::getenv("TERM");
  const bool dumb = term == nullptr || *term == '\0' || std::string_view(term) == "dumb";
  return ::isatty(STDERR_FILENO) == 1 && !dumb;
}

std::shared_ptr<spdlog::logger> make_logger(bool quiet) {
  auto logger = std::make_shared<spdlog::logger>("aslio", std::make_shared<TellingSink>());
  logger->set_level(quiet ? spdlog::level::warn : spdlog::level::info);
  return logger;
}

}  // namespace aslio::cli
