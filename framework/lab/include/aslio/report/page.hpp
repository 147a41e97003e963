#pragma once
/// The report as one HTML file that needs nothing else.

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "aslio/report/study_folder.hpp"

namespace aslio::report {

/// Script and style of the page, built from tools/report.
struct Bundle {
  std::string script, style;
};

/// Reads report.js and report.css. Throws DataError when they are not there, with how to get them.
Bundle read_bundle(const std::filesystem::path& folder);

struct PageLimits {
  std::size_t bytes = 25'000'000;    ///< of the page: runs beyond it are in the tables, but without their course
  std::size_t map_points = 120'000;  ///< of one recording
};

/// The whole page. The same folder gives the same bytes. What of the runs' files cannot be read stands on the page, and
/// is added to `unreadable`, a sentence each.
std::string make_page(const StudyFolder& study, const Bundle& bundle, const PageLimits& limits = {},
                      std::vector<std::string>* unreadable = nullptr);

}  // namespace aslio::report
