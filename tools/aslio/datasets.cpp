#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <filesystem>
#include <limits>
#include <memory>
#include <numeric>
#include <string>
#include <vector>

#include "aslio/core/errors.hpp"
#include "aslio/experiment/family.hpp"
#include "command.hpp"
#include "console.hpp"
#include "dataset_options.hpp"

namespace aslio::cli {

namespace {

using experiment::Family;
using experiment::FamilySequence;
using Row = std::vector<std::string>;

/// Columns to fill; a file or pipe takes lines of any length.
std::size_t line_width() { return stderr_is_terminal() ? terminal_width() : std::numeric_limits<std::size_t>::max(); }

/// As wide as their longest cell; the widest give way until a line fits.
std::vector<std::size_t> column_widths(const std::vector<Row>& rows, std::size_t line) {
  constexpr std::size_t kGap = 2, kLeast = 8;
  std::vector<std::size_t> widths(rows.front().size(), 0);
  for (const Row& row : rows) {
    for (std::size_t k = 0; k < row.size(); ++k) widths[k] = std::max(widths[k], row[k].size());
  }
  const auto total = [&] {
    return std::accumulate(widths.begin(), widths.end(), std::size_t{0}) + kGap * (widths.size() - 1);
  };
  while (total() > line) {
    const auto widest = std::max_element(widths.begin(), widths.end());
    if (*widest <= kLeast) break;
    --*widest;
  }
  return widths;
}

std::string table(const std::vector<Row>& rows, std::size_t line_width) {
  const std::vector<std::size_t> widths = column_widths(rows, line_width);
  std::string text;
  for (const Row& row : rows) {
    std::string line;
    for (std::size_t k = 0; k < row.size(); ++k) {
      const bool cut = row[k].size() > widths[k];
      line += fmt::format("{:<{}}  ", cut ? row[k].substr(0, widths[k] - 2) + ".." : row[k], widths[k]);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + "\n";
  }
  return text;
}

/// A heading and its text, broken at words.
std::string entry(const std::string& heading, const std::string& text) {
  if (text.empty()) return {};
  constexpr std::size_t kIndent = 12, kMost = 100;
  const std::size_t most = std::min(line_width(), kMost);
  std::string out = fmt::format("{:<{}}", heading, kIndent);
  std::size_t column = kIndent;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find_first_of(" \n", begin), text.size());
    const std::string word = text.substr(begin, end - begin);
    begin = end + 1;
    if (word.empty()) continue;
    if (column > kIndent && column + word.size() + 1 > most) {
      out += fmt::format("\n{:<{}}", "", kIndent);
      column = kIndent;
    }
    if (column > kIndent) out += ' ';
    column += word.size() + (column > kIndent ? 1 : 0);
    out += word;
  }
  return out + "\n";
}

std::string list_text(const std::vector<Family>& families) {
  std::vector<Row> rows{{"name", "sequences", "sensors", "title", "licence"}};
  for (const Family& family : families) {
    rows.push_back({family.name, fmt::to_string(family.sequences.size()), family.config.sensors, family.config.title,
                    family.config.licence});
  }
  return table(rows, line_width()) + "`aslio datasets NAME` shows the sequences, files and extrinsics of one\n";
}

std::string extrinsics_text(const FamilySequence& sequence) {
  std::string text;
  for (const auto& [source, T] : sequence.extrinsics) {
    Eigen::Quaterniond q(T.R);
    if (q.w() < 0) q.coeffs() *= -1;
    text += entry(text.empty() ? "  in use" : "  also",
                  fmt::format("t({:.6f} {:.6f} {:.6f}) m, q({:.7f} {:.7f} {:.7f} {:.7f}) x y z w: {}", T.p.x(), T.p.y(),
                              T.p.z(), q.x(), q.y(), q.z(), q.w(), source));
  }
  return text;
}

/// Where the point or frame of a reference is.
std::string place_text(const io::ReferenceSpec& written) {
  const io::ReferenceSpec spec = io::with_protocol(written);
  if (!spec.frame.empty()) return "frame " + spec.frame;
  if (!spec.lever_arm.empty()) {
    return fmt::format("point ({:g}) m in the IMU frame", fmt::join(spec.lever_arm, " "));
  }
  if (spec.T_imu_reference.is_identity()) return "frame of the IMU";
  return fmt::format("frame at ({:g}) m in the IMU frame", fmt::join(spec.T_imu_reference.translation, " "));
}

std::string reference_text(const FamilySequence& sequence) {
  if (!sequence.reference) return "none";
  const io::ReferenceSpec& spec = *sequence.reference;
  const bool positions = io::with_protocol(spec).positions_only == io::PositionsOnly::yes;
  return fmt::format("{}{}; {}{}", spec.file, spec.topic.empty() ? "" : ", topic " + spec.topic,
                     positions ? "positions only, " : "", place_text(spec));
}

/// Sensor file, extrinsics and reference of a sequence, and of all others of its variant.
std::string parts_text(const FamilySequence& sequence) {
  return entry("sensor", sequence.sensor.string()) + "T_imu_lidar\n" + extrinsics_text(sequence) +
         entry("reference", reference_text(sequence));
}

/// The parts of all variants; what several have in common stands once.
std::string variants_text(const Family& family) {
  std::vector<std::pair<std::string, std::string>> shown;  // names, parts
  std::vector<std::string> names;
  for (const FamilySequence& sequence : family.sequences) {
    if (std::find(names.begin(), names.end(), sequence.variant) != names.end()) continue;
    names.push_back(sequence.variant);
    const std::string parts = parts_text(sequence), name = sequence.variant.empty() ? "-" : sequence.variant;
    const auto same = std::find_if(shown.begin(), shown.end(), [&](const auto& s) { return s.second == parts; });
    if (same == shown.end()) {
      shown.emplace_back(name, parts);
    } else {
      same->first += ", " + name;
    }
  }
  std::string text;
  for (const auto& [name, parts] : shown) {
    if (shown.size() > 1) text += fmt::format("variant {}\n", name);
    text += parts;
  }
  return text;
}

std::string files_text(const FamilySequence& sequence) {
  std::string text;
  for (const experiment::ExpectedFile& file : experiment::expected_files(sequence)) {
    text += (text.empty() ? "" : ", ") + file.pattern;
  }
  return text;
}

std::string sequences_text(const std::vector<const FamilySequence*>& sequences) {
  std::vector<Row> rows{{"sequence", "sweeps", "variant", "files in DIR"}};
  for (const FamilySequence* sequence : sequences) {
    rows.push_back({sequence->name, sequence->sweeps > 0 ? fmt::to_string(sequence->sweeps) : "-",
                    sequence->variant.empty() ? "-" : sequence->variant, files_text(*sequence)});
  }
  // Names of files are of use in full only.
  return table(rows, std::numeric_limits<std::size_t>::max());
}

std::string family_text(const Family& family) {
  const experiment::FamilyConfig& config = family.config;
  std::string text = fmt::format("{}: {}\n", family.name, config.title);
  text += entry("", config.description) + entry("sensors", config.sensors) + entry("licence", config.licence);
  text += entry("citation", config.citation) + entry("url", config.url) + entry("verified", config.verified);
  std::vector<const FamilySequence*> all;
  for (const FamilySequence& sequence : family.sequences) all.push_back(&sequence);
  text += variants_text(family);
  text += sequences_text(all);
  return text + fmt::format("aslio run PIPELINE --dataset {}/{} --data DIR --output OUT\n", family.name,
                            family.sequences.front().name);
}

std::string sequence_text(const Family& family, const FamilySequence& sequence) {
  std::string text = fmt::format("{}/{}: {}\n", family.name, sequence.name, family.config.title);
  text += parts_text(sequence);
  return text + entry("url", family.config.url) + sequences_text({&sequence});
}

int datasets(const std::string& what) {
  if (what.empty()) {
    std::vector<Family> families;
    for (const auto& file : experiment::family_files(shipped_families())) {
      families.push_back(experiment::load_family(file));
    }
    if (families.empty()) throw DataError(fmt::format("{}: holds no family", shipped_families().string()));
    print(list_text(families));
    return kSuccess;
  }
  std::error_code ignored;
  const auto name = experiment::parse_family_name(what);
  if (!name || std::filesystem::is_regular_file(what, ignored)) {
    print(family_text(experiment::load_family(experiment::find_family(what, shipped_families()))));
    return kSuccess;
  }
  const Family family = experiment::load_family(experiment::find_family(name->family, shipped_families()));
  print(sequence_text(family, experiment::find_sequence(family, name->sequence)));
  return kSuccess;
}

}  // namespace

Command add_datasets(CLI::App& root) {
  CLI::App* app = root.add_subcommand(
      "datasets", "Lists the published data sets that are known, or shows one: sequences, files, extrinsics.");
  auto what = std::make_shared<std::string>();
  app->add_option("FAMILY", *what, "a family, a family file, or FAMILY/SEQUENCE");
  app->footer(
      "The data stay with you: the program downloads nothing.\n\n"
      "Example:\n  aslio datasets newer_college_2021\n"
      "  aslio run configs/pipelines/as_lio_plus.yaml --dataset newer_college_2021/quad_hard --data "
      "~/data/newer_college "
      "--output out/quad_hard");
  return {app, [=] { return datasets(*what); }};
}

}  // namespace aslio::cli
