#include "aslio/config/description.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "aslio/config/names.hpp"
#include "aslio/core/errors.hpp"
#include "describe_binder.hpp"
#include "scalars.hpp"

namespace aslio::config {
namespace {

const StageEntry& entry_of(const StageLookup& stages, std::string_view family, std::string_view type) {
  if (const StageEntry* entry = stages.find(family, type)) return *entry;
  const std::vector<std::string> families = stages.families();
  if (std::find(families.begin(), families.end(), family) == families.end()) {
    const std::string near = nearest(family, families);
    throw ConfigError(fmt::format("unknown stage family {}{}; there are {}", quote(family),
                                  near.empty() ? "" : fmt::format(" (did you mean '{}'?)", near), join(families)));
  }
  const std::vector<std::string> types = stages.types(family);
  const std::string near = nearest(type, types);
  throw ConfigError(fmt::format("unknown type {} of {}{}; there are {}", quote(type), family,
                                near.empty() ? "" : fmt::format(" (did you mean '{}'?)", near), join(types)));
}

Description describe_entry(const StageEntry& entry) {
  const std::shared_ptr<void> params = entry.defaults();
  return describe([&](Binder& binder) { entry.describe(binder, params.get()); });
}

/// "number, [0.001, 10] s, default 0.1", the units that a range does not state included.
std::string facts(const Field& field) {
  std::string text = field.type;
  if (!field.range.empty()) {
    text += fmt::format(", {}", field.range);
  } else if (!field.unit.empty()) {
    text += fmt::format(" [{}]", field.unit);
  }
  if (field.default_value == "required") return text + ", required";
  return field.default_value.empty() ? text : fmt::format("{}, default {}", text, field.default_value);
}

/// A cell of a Markdown table: a bar would end it, an angle bracket would be markup.
std::string cell(std::string_view text) {
  std::string result;
  for (const char c : printable(text)) {
    if (c == '|') result += '\\';
    if (c == '<') {
      result += "&lt;";
    } else {
      result += c;
    }
  }
  return result;
}

}  // namespace

std::string to_text(const Description& description, const StageLookup& stages) {
  std::string out;
  for (const Field& field : description.fields) {
    out += fmt::format("\n  {}: {}\n      {}\n", field.path, facts(field), field.doc);
    if (!field.family.empty()) out += fmt::format("      {}: {}\n", field.family, join(stages.types(field.family)));
  }
  for (const RemovedKey& key : description.removed) out += fmt::format("\n  {}: removed, {}\n", key.path, key.advice);
  return out;
}

std::string to_markdown(const Description& description) {
  if (description.fields.empty()) return "No parameters.\n\n";
  std::string out = "| key | type | unit | range | default | meaning |\n|---|---|---|---|---|---|\n";
  for (const Field& f : description.fields) {
    out += fmt::format("| `{}` | {} | {} | {} | {} | {} |\n", cell(f.path), cell(f.type), cell(f.unit), cell(f.range),
                       cell(f.default_value), cell(f.doc));
  }
  return out + '\n';
}

Description describe(const std::function<void(Binder&)>& describe_block) {
  DescribeBinder binder;
  describe_block(binder);
  return binder.take();
}

Description describe(const StageLookup& stages, std::string_view family, std::string_view type) {
  return describe_entry(entry_of(stages, family, type));
}

std::string describe_stage(const StageLookup& stages, std::string_view family, std::string_view type) {
  const StageEntry& entry = entry_of(stages, family, type);
  std::string out = fmt::format("{}/{}: {}\nfrom: {}\n", entry.family, entry.type, entry.doc, entry.origin);
  const Description description = describe_entry(entry);
  if (description.fields.empty()) out += "no parameters\n";
  return out + to_text(description, stages);
}

std::string plugin_reference(const StageLookup& stages) {
  std::string out =
      "# Plugin reference\n\nGenerated from the declarations that read the files. Every key may be left "
      "out unless its default is `required`.\n";
  for (const std::string& family : stages.families()) {
    out += fmt::format("\n## {}\n\n", family);
    const std::vector<std::string> types = stages.types(family);
    if (types.empty()) out += "No member yet.\n";
    for (const std::string& type : types) {
      const StageEntry& entry = entry_of(stages, family, type);
      out += fmt::format("### {}/{}\n\n{}.\n\n", family, type, cell(entry.doc));
      out += to_markdown(describe_entry(entry));
    }
  }
  while (out.ends_with("\n\n")) out.pop_back();
  return out;
}

}  // namespace aslio::config
