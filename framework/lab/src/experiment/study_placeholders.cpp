#include "aslio/experiment/study_placeholders.hpp"

#include <fmt/format.h>

#include "aslio/config/document.hpp"
#include "aslio/config/load.hpp"

namespace aslio::experiment {

std::vector<std::string> placeholder_warnings(const Study& study) {
  constexpr std::string_view kRequest = "Write here ";  // so begin the placeholders of tools/templates
  const config::Node root = config::parse_document(config::read_text(study.path), study.path.string());
  std::vector<std::string> warnings;
  for (const char* key : {"question", "prediction", "rule"}) {
    const config::Member* member = root.find(key);
    if (member == nullptr || !member->value.text().starts_with(kRequest)) continue;
    warnings.push_back(
        fmt::format("{}: '{}' still holds the text of the template, '{}': replace it by your own before the first run, "
                    "since the report shows it as yours",
                    member->value.at().text(), key, member->value.text()));
  }
  return warnings;
}

}  // namespace aslio::experiment
