#include "aslio/config/load.hpp"

#include <array>
#include <utility>

#include "aslio/config/document.hpp"
#include "aslio/config/node.hpp"
#include "aslio/config/problems.hpp"
#include "aslio/core/errors.hpp"
#include "names.hpp"
#include "parse_binder.hpp"
#include "scalars.hpp"

namespace aslio::config {
namespace {

constexpr std::array kKinds{FileKind::pipeline, FileKind::sensor, FileKind::scene, FileKind::dataset, FileKind::study};

std::string schema_of(FileKind kind) { return "aslio/" + std::string(name(kind)) + "/1"; }

[[noreturn]] void fail(const Location& at, const std::string& message) {
  throw ConfigError(printable(at.text() + ": " + message));
}

/// The value of the first key, which must be `schema`.
const Node& schema_value(const Node& root, const std::string& expected) {
  if (!root.is_map() || root.members().empty()) {
    const std::string is = root.is_null() || root.is_map() ? "is empty" : "is not a block of keys";
    fail(root.at(), "the file must begin with 'schema: " + expected + "', but " + is);
  }
  const Member& first = root.members().front();
  if (first.key != "schema") {
    fail(first.at, "the file must begin with 'schema: " + expected + "', but begins with " + quote(first.key));
  }
  if (!first.value.is_scalar()) fail(first.value.at(), "schema must be " + expected);
  return first.value;
}

void check_schema(const Node& root, FileKind kind) {
  const std::string expected = schema_of(kind);
  const Node& value = schema_value(root, expected);
  if (value.text() == expected) return;
  std::string reason;
  for (const FileKind other : kKinds) {
    if (value.text() == schema_of(other)) reason = " (this is a " + std::string(name(other)) + " file)";
  }
  if (value.text().starts_with("aslio/" + std::string(name(kind)) + '/')) reason = " (this build reads version 1)";
  fail(value.at(), "expected schema " + expected + ", found " + quote(value.text()) + reason);
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
  }
  return {};
}

FileKind peek_kind(const std::filesystem::path& path) {
  const Node root = parse_document(read_text(path), path.string());
  const Node& value = schema_value(root, "aslio/<kind>/1");
  std::vector<std::string> schemas;
  for (const FileKind kind : kKinds) {
    if (value.text() == schema_of(kind)) return kind;
    schemas.push_back(schema_of(kind));
  }
  fail(value.at(), "unknown schema " + quote(value.text()) + suggestion(value.text(), schemas));
}

Bound bind_text(std::string_view text, const std::string& source, FileKind kind, const StageLookup& stages,
                std::span<const Override> overrides, const std::function<void(Binder&)>& describe) {
  const Node written = parse_document(text, source);
  check_schema(written, kind);
  const Node root = apply_overrides(written, overrides);
  Problems problems;
  ParseBinder binder(stages, problems);
  const std::vector<Member> first{{"schema", {}, Node::scalar(schema_of(kind), false, {})}};
  const Node resolved = binder.bind(Node::map(root.members(), start_of(root)), "", first, describe);
  problems.raise();
  return {to_yaml(resolved), {binder.plugin_types().begin(), binder.plugin_types().end()}};
}

}  // namespace aslio::config
