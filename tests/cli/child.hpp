#pragma once
/// The `aslio` program as a child process, and small recordings to feed it.

#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "temporary_folder.hpp"

namespace aslio::test {

/// What a finished child left. `code` is the exit code, or 256 + the signal that ended it.
struct Ended {
  int code = -1;
  std::string out, err;
};

/// Runs `aslio ARGUMENTS...` to its end.
Ended run_aslio(const std::vector<std::string>& arguments);

/// The same with control over it while it runs: `during` gets the process id and the text of stderr so far, again and
/// again until it returns true.
Ended run_aslio(const std::vector<std::string>& arguments,
                const std::function<bool(pid_t, const std::string& err)>& during);

/// The same with stdout going to a file that is there already.
Ended run_aslio_to(const std::string& out, const std::vector<std::string>& arguments);

/// The same with these descriptors closed.
Ended run_aslio_without(const std::vector<int>& streams, const std::vector<std::string>& arguments);

/// The same where no file may grow beyond `bytes`: what a full disk does to a writer.
Ended run_aslio_with_file_limit(const std::vector<std::string>& arguments, std::size_t bytes);

std::string content(const std::filesystem::path& file);
void write_text(const std::filesystem::path& file, const std::string& text);
/// Column of a CSV file by its name; empty when there is no such column.
std::vector<std::string> column(const std::filesystem::path& csv, const std::string& name);
std::size_t line_count(const std::filesystem::path& file);

}  // namespace aslio::test
