#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <memory>

#include "aslio/core/errors.hpp"
#include "aslio/io/writers.hpp"
#include "aslio/report/page.hpp"
#include "aslio/report/table.hpp"
#include "command.hpp"
#include "console.hpp"
#include "options.hpp"

namespace aslio::cli {

namespace {

namespace fs = std::filesystem;

constexpr double kMegabyte = 1e6;

struct ReportArguments {
  std::string folder, output;
  std::vector<std::string> formats{"html"};
  std::string latex_rows = "auto";
  double limit_mb = 25;
  bool open = false, quiet = false;
};

/// Where the page's script and style lie, beside this program: in a build folder and where it is installed.
fs::path bundle_folder() { return fs::canonical("/proc/self/exe").parent_path() / "../share/aslio/report"; }

report::LatexRows latex_rows(const std::string& name) {
  if (name == "auto") return report::LatexRows::automatic;
  return name == "methods" ? report::LatexRows::methods : report::LatexRows::sequences;
}

/// `unreadable`: what of the runs' files could not be read is added.
std::string text_of(const report::StudyFolder& study, const std::string& format, const ReportArguments& a,
                    std::vector<std::string>& unreadable) {
  if (format == "md") return report::to_markdown(study);
  if (format == "tex") return report::to_latex(study, latex_rows(a.latex_rows));
  if (format == "csv") return report::to_csv(study);
  report::PageLimits limits;
  limits.bytes = static_cast<std::size_t>(kMegabyte * a.limit_mb);
  return report::make_page(study, report::read_bundle(bundle_folder().lexically_normal()), limits, &unreadable);
}

/// The first few, which show what they are of.
void warn_of(const std::vector<std::string>& unreadable) {
  constexpr std::size_t kShown = 5;
  for (std::size_t i = 0; i < std::min(kShown, unreadable.size()); ++i) tell("warning: " + unreadable[i]);
  if (unreadable.size() > kShown) {
    tell(fmt::format("warning: and {} more like this; the page shows them beside their runs, as far as they fit",
                     unreadable.size() - kShown));
  }
}

/// The desktop's program for such a file; its output is of no interest.
void open_file(const fs::path& file) {
  const std::string path = fs::absolute(file).string();
  std::string program = "xdg-open", argument = path;
  char* const words[] = {program.data(), argument.data(), nullptr};
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  pid_t child = 0;
  const int error = ::posix_spawnp(&child, "xdg-open", &actions, nullptr, words, environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) {
    throw DataError(fmt::format("{}: written, but --open found no program xdg-open: open it in a browser", path));
  }
}

/// Throws ConfigError when `output` is a file that no report wrote: results, or an input.
void refuse_to_replace(const fs::path& output, const std::string& format) {
  constexpr std::array<std::string_view, 9> kNotOurs = {"table.md",    "verdict.md",  "results.csv",
                                                        "plan.csv",    "updates.csv", "statistics.csv",
                                                        "overlap.csv", "timings.csv", "truth.csv"};
  std::error_code ignored;
  if (!fs::exists(output, ignored)) return;
  const std::string name = output.filename().string(), extension = output.extension().string();
  const bool ours = extension == "." + format || extension == ".txt" || (format == "html" && extension == ".htm");
  if (ours && std::find(kNotOurs.begin(), kNotOurs.end(), name) == kNotOurs.end()) return;
  if (!fs::is_regular_file(output, ignored)) return;  // a device or a pipe keeps nothing; a folder is told when written
  throw ConfigError(
      fmt::format("--output {}: exists, and its name is not that of a report of this format; it is not overwritten. "
                  "Name another file, as report.{}",
                  output.string(), format));
}

int make_report(const ReportArguments& a) {
  std::vector<std::string> formats = a.formats;
  std::sort(formats.begin(), formats.end());
  formats.erase(std::unique(formats.begin(), formats.end()), formats.end());
  if (!a.output.empty() && formats.size() > 1) {
    throw ConfigError(
        fmt::format("--output {} names one file, and --format {} of them: give one format, or no --output", a.output,
                    formats.size()));
  }
  if (a.open && std::find(formats.begin(), formats.end(), "html") == formats.end()) {
    throw ConfigError("--open shows the page: add html to --format");
  }
  const report::StudyFolder study = report::read_study_folder(a.folder);
  if (!a.output.empty()) refuse_to_replace(a.output, formats.front());
  for (const std::string& format : formats) {
    const fs::path path = a.output.empty() ? fs::path(a.folder) / ("report." + format) : fs::path(a.output);
    std::vector<std::string> unreadable;
    const std::string text = text_of(study, format, a, unreadable);
    io::AtomicFile file(path, true);
    file.write(text);
    file.close();
    warn_of(unreadable);
    if (!a.quiet) print(fmt::format("{} ({:.1f} MB)\n", path.string(), static_cast<double>(text.size()) / kMegabyte));
    if (format == "html" && a.open) open_file(path);
  }
  return kSuccess;
}

}  // namespace

Command add_report(CLI::App& root) {
  CLI::App* app = root.add_subcommand("report", "Shows the results of a study, or a run: a page, or tables.");
  auto a = std::make_shared<ReportArguments>();
  app->add_option("DIR", a->folder, "output folder of `aslio experiment`, or of `aslio run`")
      ->required()
      ->check(CLI::ExistingDirectory);
  app->add_option("--format", a->formats, "html (one file that works offline), md, tex or csv; several with commas")
      ->delimiter(',')
      ->check(one_of("format", {"html", "md", "tex", "csv"}))
      ->capture_default_str();
  app->add_option("--output", a->output, "file to write; default: DIR/report.FORMAT")->type_name("FILE");
  app->add_option(
         "--latex-rows", a->latex_rows,
         "rows of the tables in LaTeX: sequences, methods (with the axes of a study), or auto: the fewer columns")
      ->check(one_of("rows", {"auto", "sequences", "methods"}))
      ->capture_default_str();
  app->add_option("--limit", a->limit_mb,
                  "size of the page [MB]; runs beyond it are in its tables, but not in its time series")
      ->check(number(3, 500))
      ->capture_default_str();
  app->add_flag("--open", a->open, "opens the page in the browser");
  app->add_flag("--quiet", a->quiet, "no report of what was written; errors remain");
  app->footer("Example:\n  aslio report out/table_1 --format html,tex");
  return {app, [=] { return make_report(*a); }};
}

}  // namespace aslio::cli
