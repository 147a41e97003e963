#include <nlohmann/json.hpp>

#include "aslio/io/markup.hpp"
#include "aslio/report/encode.hpp"
#include "fuzz/target.hpp"

namespace aslio::fuzz {
namespace {

/// Every '&' of an escaped text begins one of the entities that stand for characters.
bool only_entities(std::string_view text) {
  for (std::size_t at = text.find('&'); at != std::string_view::npos; at = text.find('&', at + 1)) {
    const std::string_view rest = text.substr(at);
    bool known = false;
    for (const std::string_view entity : {"&amp;", "&lt;", "&gt;", "&quot;", "&#39;"})
      known |= rest.starts_with(entity);
    if (!known) return false;
  }
  return true;
}

std::string unescaped(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    bool replaced = false;
    constexpr std::pair<std::string_view, char> kEntities[] = {
        {"&amp;", '&'}, {"&lt;", '<'}, {"&gt;", '>'}, {"&quot;", '"'}, {"&#39;", '\''}};
    for (const auto& [entity, c] : kEntities) {
      if (replaced || !text.starts_with(entity)) continue;
      out += c;
      text.remove_prefix(entity.size());
      replaced = true;
    }
    if (replaced) continue;
    out += text.front();
    text.remove_prefix(1);
  }
  return out;
}

}  // namespace
}  // namespace aslio::fuzz

ASLIO_FUZZ_TARGET(text) {
  const std::string_view text = text_of(bytes);
  const std::string html = io::html_escaped(text);
  must(html.find_first_of("<>\"'") == std::string::npos && only_entities(html), "escaped text holds no markup");
  std::string whole(text);
  std::erase(whole, '\0');
  must(unescaped(html) == whole, "escaped text stands for the text");

  const nlohmann::ordered_json json = {{std::string(text), std::string(text)}};
  const std::string script = report::script_safe(json);
  for (const char c : script)
    must(c >= 0x20 && c < 0x7f && c != '<' && c != '>' && c != '&', "a script holds plain ASCII");
  must(!nlohmann::ordered_json::parse(script, nullptr, false).is_discarded(), "a script's data are JSON");

  const std::string cell = report::markdown_cell(text);
  must(cell.find_first_of("<>\n\r") == std::string::npos, "a cell holds no markup and no line");
  for (std::size_t i = 0; i < cell.size(); ++i) {
    must(cell[i] != '|' || (i > 0 && cell[i - 1] == '\\'), "a bar in a cell does not end it");
  }
  const std::string latex = report::latex_escaped(text);
  for (std::size_t i = 0; i < latex.size(); ++i) {
    const bool special = std::string_view("#$%&_").find(latex[i]) != std::string_view::npos;
    must(!special || (i > 0 && latex[i - 1] == '\\'), "what LaTeX would take for a command is escaped");
  }
}
