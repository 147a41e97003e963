#include "aslio/config/load.hpp"

#include <array>
#include <utility>

#include "aslio/config/document.hpp"
#include "aslio/config/names.hpp"
#include "aslio/config/node.hpp"
#include "aslio/config/problems.hpp"
#include "aslio/core/errors.hpp"
#include "parse_binder.hpp"
#include "scalars.hpp"

namespace aslio::config {
namespace {

constexpr std::array kKinds{FileKind::pipeline, FileKind::sensor,    FileKind::scene,  FileKind::dataset,
                            FileKind::study,    FileKind::reference, FileKind::family, FileKind::external};

std::string schema_of(FileKind kind) { return "aslio/" + std::string(name(kind)) + "/1"; }

/// Reading ends here: the problem is reported with those found before.
[[noreturn]] void reject(const Location& at, const std::string& message, Problems problems = {}) {
  problems.add(at, message);
  throw ConfigError(problems.text());
}

/// The value of the first key, which must be `schema`.
const Node& schema_value(const Node& root, const std::string& expected, const Problems& problems = {}) {
  if (!root.is_map() || root.members().empty()) {
    const std::string is = root.is_null() || root.is_map() ? "is empty" : "is not a block of keys";
    reject(root.at(), "the file must begin with 'schema: " + expected + "', but " + is, problems);
  }
  const Member& first = root.members().front();
  if (first.key != "schema") {
    reject(first.at, "the file must begin with 'schema: " + expected + "', but begins with " + quote(first.key),
           problems);
  }
  if (!first.value.is_scalar()) reject(first.value.at(), "schema must be " + expected, problems);
  return first.value;
}

void check_schema(const Node& root, FileKind kind, const Problems& problems) {
  const std::string expected = schema_of(kind);
  const Node& value = schema_value(root, expected, problems);
  if (value.text() == expected) return;
  std::string reason;
  for (const FileKind other : kKinds) {
    if (value.text() == schema_of(other)) reason = " (this is a " + std::string(name(other)) + " file)";
  }
  if (value.text().starts_with("aslio/" + std::string(name(kind)) + '/')) reason = " (this build reads version 1)";
  reject(value.at(), "expected schema " + expected + ", found " + quote(value.text()) + reason, problems);
}

/// The overrides come last in a message: an error of theirs goes behind those of the file.
Node overridden(const Node& written, std::span<const Override> overrides, const Problems& problems) {
  try {
    return apply_overrides(written, overrides);
  } catch (const ConfigError& error) {
    if (problems.size() == 0) throw;
    throw ConfigError(problems.text() + '\n' + error.what());
  }
}

/// What the file is an alias of; empty: nothing.
std::string alias_in(const std::filesystem::path& path) {
  const std::string text = read_text(path);
  if (text.find("\nalias:") == std::string::npos) return {};  // spares every other file a second parsing
  const Node root = parse_document(text, path.string());
  const Member* alias = root.is_map() && root.members().size() == 2 ? root.find("alias") : nullptr;
  if (alias == nullptr) return {};
  const Node& name = alias->value;
  if (!name.is_scalar() || name.text().empty()) reject(name.at(), "alias must name a file beside this one");
  return name.text();
}

/// The file as a whole is where a missing key is missing.
Location start_of(const Node& root) {
  Location at = root.at();
  at.line = 1;
  at.column = 1;
  return at;
}

}  // namespace

std::string_view name(FileKind kind) {
  switch (kind) {
    case FileKind::pipeline:
      return "pipeline";
    case FileKind::sensor:
      return "sensor";
    case FileKind::scene:
      return "scene";
    case FileKind::dataset:
      return "dataset";
    case FileKind::study:
      return "study";
    case FileKind::reference:
      return "reference";
    case FileKind::family:
      return "family";
    case FileKind::external:
      return "external";
  }
  return {};
}

std::filesystem::path follow_alias(const std::filesystem::path& path) {
  const std::string alias = alias_in(path);
  if (alias.empty()) return path;
  const std::filesystem::path target = path.parent_path() / alias;
  if (!alias_in(target).empty()) {
    throw ConfigError(path.string() + ": alias " + quote(alias) +
                      " is an alias itself: name the file that it stands for");
  }
  return target;
}

FileKind peek_kind(const std::filesystem::path& path) {
  const Node root = parse_document(read_text(path), path.string());
  const Node& value = schema_value(root, "aslio/<kind>/1");
  std::vector<std::string> schemas;
  for (const FileKind kind : kKinds) {
    if (value.text() == schema_of(kind)) return kind;
    schemas.push_back(schema_of(kind));
  }
  reject(value.at(), "unknown schema " + quote(value.text()) + suggestion(value.text(), schemas));
}

Bound bind_text(std::string_view text, const std::string& source, FileKind kind, const StageLookup& stages,
                std::span<const Override> overrides, const std::function<void(Binder&)>& describe) {
  Problems problems;
  const Node written = parse_document(text, source, problems);
  check_schema(written, kind, problems);
  const Node root = overridden(written, overrides, problems);
  ParseBinder binder(stages, problems);
  const std::vector<Member> first{{"schema", {}, Node::scalar(schema_of(kind), false, {})}};
  const Node resolved = binder.bind(Node::map(root.members(), start_of(root)), "", first, describe);
  problems.raise();
  return {to_yaml(resolved), {binder.plugin_types().begin(), binder.plugin_types().end()}, root};
}

}  // namespace aslio::config
