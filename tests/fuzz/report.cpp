#include "aslio/report/page.hpp"
#include "aslio/report/table.hpp"
#include "fuzz/target.hpp"

namespace aslio::fuzz {
namespace {

std::size_t count(std::string_view text, std::string_view part) {
  std::size_t n = 0;
  for (std::size_t at = text.find(part); at != std::string_view::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

}  // namespace
}  // namespace aslio::fuzz

// A study's output folder, of one run. Whatever it holds, the page is the same but for its data.
ASLIO_FUZZ_TARGET(report) {
  const auto& at = unpacked(
      bytes, {"results.csv", "study.json", "statistics.csv", "verdict.md", "runs/a/b/summary.json",
              "runs/a/b/manifest.json", "runs/a/b/updates.csv", "runs/a/b/timings.csv", "runs/a/b/trajectory.tum",
              "runs/a/b/map.ply", "runs/a/b/resolved.yaml", "summary.json", "data/a/truth.tum", "data/a/overlap.csv"});
  accepts([&] {
    const report::StudyFolder study = report::read_study_folder(at);
    (void)report::to_markdown(study);
    (void)report::to_latex(study);
    (void)report::to_csv(study);
    const std::string page =
        report::make_page(study, {.script = "", .style = ""}, {.bytes = 1'000'000, .map_points = 1000});
    // Comments and elements begin with '<': the page's own ones are known.
    must(count(page, "<") == 23 && count(page, "</script") == 2, "no text of a study is markup of its page");
  });
}
