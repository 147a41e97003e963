#pragma once

#include <filesystem>
#include <string>

namespace aslio::plugin {

/// Why a shared object of this program's kind (ELF) must not be loaded: it is cut short, and the loader would map what
/// is not there, which ends the process by a signal. Empty for a whole one, and for a file of another kind, which the
/// loader refuses by itself.
std::string why_cut_short(const std::filesystem::path& file);

}  // namespace aslio::plugin
