#pragma once
/// All that the command line prints goes through here, and nothing else prints.

#include <spdlog/logger.h>

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

namespace aslio::cli {

/// Text from files and bags may hold anything: control characters other than line feed and tab become '?'.
std::string printable(std::string_view text);

/// Results, to stdout. Throws DataError when they cannot be written; a reader that has left (a closed pipe) is no
/// error.
void print(std::string_view text);
/// What concerns the user besides the results, to stderr, one line. Clears a progress bar that stands there.
void tell(std::string_view line);
/// "error: ..." to stderr; the lines of a message with several problems stay lines.
void complain(std::string_view message);

/// A bar on a terminal; overwritten by the next. Pre: stderr_is_terminal().
void show_bar(std::string_view text);
void clear_bar();
/// Several lines, which stay until clear_block() with their number. Pre: stderr_is_terminal().
void show_block(std::string_view lines);
void clear_block(std::size_t lines);
bool stderr_is_terminal();
/// Columns; 80 where it does not say.
std::size_t terminal_width();

/// Logger that prints; `quiet` leaves warnings and errors only.
std::shared_ptr<spdlog::logger> make_logger(bool quiet);

}  // namespace aslio::cli
