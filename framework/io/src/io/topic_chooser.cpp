#include "topic_chooser.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "aslio/core/errors.hpp"
#include "lidar_decoder.hpp"

namespace aslio::io {
namespace {

std::string list_topics(const std::vector<Connection>& connections) {
  std::string text;
  std::vector<std::string> lines;
  for (const Connection& c : connections) lines.push_back(fmt::format("\n  {} [{}]", c.topic, c.type));
  std::sort(lines.begin(), lines.end());
  lines.erase(std::unique(lines.begin(), lines.end()), lines.end());
  constexpr std::size_t kMax = 50;
  for (std::size_t i = 0; i < std::min(kMax, lines.size()); ++i) text += lines[i];
  if (lines.size() > kMax) text += fmt::format("\n  and {} more", lines.size() - kMax);
  return text.empty() ? "\n  (none)" : text;
}

}  // namespace

std::vector<Connection> TopicChooser::choose(const TopicRoleWords& words, const std::string& wanted) const {
  const std::string topic = wanted.empty() ? only_topic(words) : wanted;
  std::vector<Connection> chosen;
  for (const Connection& c : connections_) {
    if (c.topic == topic) chosen.push_back(c);
  }
  if (chosen.empty()) {
    throw DataError(fmt::format("{}: there is no {} topic '{}'; {}set `{}` to one of:{}", name_, words.role, topic,
                                remedy_, words.key, list_topics(connections_)));
  }
  for (const Connection& c : chosen) {
    if (!words.fits(c)) throw DataError(wrong_type(words, c));
    if (message_kind(c) != message_kind(chosen.front())) {
      throw DataError(fmt::format("{}: topic '{}' carries both {} and {}", name_, topic, chosen.front().type, c.type));
    }
  }
  return chosen;
}

std::string TopicChooser::wrong_type(const TopicRoleWords& words, const Connection& c) const {
  std::string remark;
  if (is_lidar(c) || is_imu(c)) {
    remark = ": `lidar_topic` and `imu_topic` look swapped";
  } else if (is_known_name(c) && c.encoding == Encoding::other) {
    remark = " in an encoding that is neither ros1 nor cdr";
  } else if (is_known_name(c)) {
    remark = fmt::format(" with checksum {}, another version of that message than the known one", c.md5);
  }
  return fmt::format("{}: {} topic '{}' is of type {}{}; {} can be read; set `{}` to one of:{}", name_, words.role,
                     c.topic, c.type, remark, words.types, words.key, list_topics(connections_));
}

std::string TopicChooser::only_topic(const TopicRoleWords& words) const {
  std::vector<std::string> topics;
  const auto add = [&](bool packets) {
    for (const Connection& c : connections_) {
      const bool fits = words.fits(c) && (message_kind(c) == MessageKind::packets) == packets;
      if (fits && std::find(topics.begin(), topics.end(), c.topic) == topics.end()) topics.push_back(c.topic);
    }
  };
  add(false);
  if (topics.empty()) add(true);  // packets are recorded beside the clouds that are made of them
  if (topics.size() == 1) return topics.front();
  throw DataError(fmt::format("{}: {} {} topic ({}); {}set `{}` to one of:{}", name_,
                              topics.empty() ? "there is no" : "there is more than one", words.role, words.types,
                              topics.empty() ? remedy_ : "", words.key, list_topics(connections_)));
}

}  // namespace aslio::io
