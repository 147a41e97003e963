#pragma once
/// What a run of a study is started with.

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "aslio/experiment/study.hpp"

namespace aslio::experiment {

/// Whether a large output stays (`outputs` of the study).
bool asks_for(const Study& study, std::string_view output);

struct RunPlaces {
  std::filesystem::path dataset;      ///< for --dataset
  std::filesystem::path folder;       ///< of the run, while it is at work
  std::filesystem::path runs_folder;  ///< as in overrides_of()
};

/// Of `aslio run`, or of `aslio external` for a method that is not of this program, whose file is put into the folder.
/// `more`: further options of `aslio run`.
std::vector<std::string> run_arguments(const Study& study, const std::vector<StudyRun>& runs, std::size_t i,
                                       const RunPlaces& places, const std::vector<std::string>& more);

/// A text in which the folder of a run at work becomes its final one.
void name_finally(std::string& text, const std::filesystem::path& folder, const std::filesystem::path& final);

}  // namespace aslio::experiment
