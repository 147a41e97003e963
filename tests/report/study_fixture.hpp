#pragma once
/// A study folder made by hand: two sequences with two seeds, a baseline, a method, and one with a hostile name.

#include <filesystem>
#include <string>

namespace aslio::test {

/// What a name must not do to the page.
inline constexpr const char* kHostile = "<img src=x onerror=fail()>&\"'";
/// In texts, which may hold more.
inline constexpr const char* kHostileText = "</script><script>fail()</script><!-- <script> ]]> \xe2\x80\xa8 \xff end";

/// Writes results.csv, study.json, verdict.md, data/ and runs/. A round of 60 s at 20 updates a second;
/// `loop_1/as_lio_plus` has a map; the hostile method diverged on one recording and has left nothing on another.
void write_study(const std::filesystem::path& folder);

/// Twenty runs of 500 m, each with a map: two recordings of 500 s, ten methods.
void write_long_study(const std::filesystem::path& folder);

void write_text(const std::filesystem::path& path, const std::string& text);

}  // namespace aslio::test
