#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>

#include "aslio/core/errors.hpp"
#include "aslio/io/message_reader.hpp"
#include "aslio/io/rosbag/reader.hpp"
#include "input_file.hpp"
#include "mcap/reader.hpp"
#include "mcap/record.hpp"
#include "recording_files.hpp"
#include "rosbag2/database.hpp"
#include "zstd.hpp"

namespace aslio::io {
namespace {

namespace fs = std::filesystem;

constexpr TimeNs kGap = kSecond;  ///< without any message between parts: something is missing

/// The first bytes of a file.
std::string head_of(const fs::path& path) {
  const InputFile file(path);
  std::array<std::uint8_t, 16> bytes{};
  const auto part =
      std::span(bytes).first(static_cast<std::size_t>(std::min<std::uint64_t>(file.size(), bytes.size())));
  file.read(0, part);
  return {reinterpret_cast<const char*>(part.data()), part.size()};
}

/// `path` is read, `name` is what the user called it: they differ for a file that was decompressed.
std::unique_ptr<MessageReader> open_plain(const fs::path& path, const fs::path& name,
                                          std::unique_ptr<ScratchFile> unpacked) {
  const std::string head = head_of(path);
  if (rosbag2::is_database(head)) {
    return std::make_unique<rosbag2::DatabaseReader>(path, name.string(), std::move(unpacked));
  }
  try {
    // Of any version: the reader of MCAP files names the others. What was decompressed stays open without a name.
    if (head.starts_with(mcap::kMagic.substr(0, 5))) return std::make_unique<mcap::McapReader>(path);
    return std::make_unique<rosbag::BagReader>(path);
  } catch (const DataError& error) {
    if (!unpacked) throw;
    throw DataError(fmt::format("{}, decompressed: {}", name.string(), error.what()));
  }
}

std::unique_ptr<MessageReader> open_file(const fs::path& path, const fs::path& scratch) {
  const std::string head = head_of(path);
  if (!is_zstd({reinterpret_cast<const std::uint8_t*>(head.data()), head.size()}))
    return open_plain(path, path, nullptr);
  auto unpacked = std::make_unique<ScratchFile>(path, scratch);
  const fs::path plain = unpacked->path();
  return open_plain(plain, path, std::move(unpacked));
}

struct Part {
  fs::path file;
  std::unique_ptr<MessageReader> reader;
};

/// Recordings of one folder belong together when they are parts of one run, or of one time.
void require_one_run(const fs::path& folder, const std::vector<Part>& parts) {
  struct Extent {
    TimeNs begin = kTimeMax, end = kTimeMin;
  };
  std::map<std::string, Extent> runs;
  for (const Part& part : parts) {
    Extent& run = runs[recording_stem(part.file)];
    run.begin = std::min(run.begin, part.reader->begin_time().value_or(kTimeMax));
    run.end = std::max(run.end, part.reader->end_time().value_or(kTimeMin));
  }
  for (auto a = runs.begin(); a != runs.end(); ++a) {
    for (auto b = std::next(a); b != runs.end(); ++b) {
      const bool empty = a->second.begin > a->second.end || b->second.begin > b->second.end;
      if (empty || (a->second.begin <= b->second.end && b->second.begin <= a->second.end)) continue;
      throw DataError(
          fmt::format("{}: it holds several recordings, {} and {} are of different times; name one of them, "
                      "or a pattern such as {}/{}*",
                      folder.string(), a->first, b->first, folder.string(), a->first));
    }
  }
}

/// What is missing between parts. Pre: by begin.
std::vector<std::string> gaps_between(const std::vector<Part>& parts) {
  std::vector<std::string> warnings;
  TimeNs end = kTimeMin;
  std::string last;
  for (const Part& part : parts) {
    const auto begin = part.reader->begin_time();
    if (!begin) continue;
    if (end != kTimeMin && *begin - end > kGap) {
      warnings.push_back(fmt::format("there is no message for {:.3f} s between {} and {}: is a part missing?",
                                     to_seconds(*begin - end), last, part.file.filename().string()));
    }
    if (part.reader->end_time().value_or(end) >= end) {
      end = part.reader->end_time().value_or(end);
      last = part.file.filename().string();
    }
  }
  return warnings;
}

}  // namespace

std::unique_ptr<MessageReader> open_messages(std::span<const fs::path> inputs, const fs::path& scratch) {
  std::vector<Part> parts;
  std::vector<std::string> warnings;
  std::vector<fs::path> seen;
  for (const fs::path& input : inputs) {
    RecordingFiles found = find_recording_files(input);
    const std::size_t first = parts.size();
    for (const fs::path& file : found.files) {
      std::error_code error;
      const fs::path real = fs::weakly_canonical(file, error);
      if (std::find(seen.begin(), seen.end(), real) != seen.end()) {
        throw DataError(fmt::format("{}: is named twice as a part of the recording", file.string()));
      }
      seen.push_back(real);
      parts.push_back({file, open_file(file, scratch)});
    }
    if (parts.size() == first) {
      throw DataError(
          fmt::format("{}: this folder holds no recording (.bag, .mcap, .db3, each also with .zstd)", input.string()));
    }
    if (!found.listed && inputs.size() == 1) require_one_run(input, parts);
    warnings.insert(warnings.end(), found.warnings.begin(), found.warnings.end());
  }
  std::stable_sort(parts.begin(), parts.end(), [](const Part& a, const Part& b) {
    return a.reader->begin_time().value_or(kTimeMax) < b.reader->begin_time().value_or(kTimeMax);
  });
  for (std::string& gap : gaps_between(parts)) warnings.push_back(std::move(gap));
  std::vector<std::unique_ptr<MessageReader>> readers;
  for (Part& part : parts) readers.push_back(std::move(part.reader));
  return merge_messages(std::move(readers), std::move(warnings));
}

std::unique_ptr<MessageReader> open_messages(const fs::path& input, const fs::path& scratch) {
  return open_messages(std::span(&input, 1), scratch);
}

}  // namespace aslio::io
