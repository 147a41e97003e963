#include "aslio/io/json.hpp"

#include <nlohmann/json.hpp>

namespace aslio::io {

std::optional<nlohmann::ordered_json> parse_json(std::string_view text) {
  using Json = nlohmann::ordered_json;
  constexpr int kDeepest = 64;
  bool too_deep = false;
  const auto keep = [&too_deep](int depth, Json::parse_event_t, Json&) {
    too_deep = too_deep || depth > kDeepest;
    return !too_deep;
  };
  Json json = Json::parse(text, keep, false);
  if (json.is_discarded() || too_deep) return std::nullopt;
  return json;
}

}  // namespace aslio::io
