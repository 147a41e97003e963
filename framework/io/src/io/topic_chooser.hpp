#pragma once
/// Finds the connections of a role in a recording, by the topic that is asked for or by what can be read.

#include <string>
#include <vector>

#include "aslio/io/message_reader.hpp"

namespace aslio::io {

/// A role of a topic, in words and by its types.
struct TopicRoleWords {
  const char *role, *key, *types;
  bool (*fits)(const Connection&);
};

class TopicChooser {
 public:
  /// `name`: of the recording; `remedy`: what to do first where it lacks something, or empty.
  TopicChooser(std::string name, const std::vector<Connection>& connections, std::string remedy)
      : name_(std::move(name)), remedy_(std::move(remedy)), connections_(connections) {}

  /// The connections of one topic: the wanted one, or the only one that fits. Throws DataError that lists the topics.
  std::vector<Connection> choose(const TopicRoleWords& words, const std::string& wanted) const;

 private:
  std::string wrong_type(const TopicRoleWords& words, const Connection& c) const;
  std::string only_topic(const TopicRoleWords& words) const;

  std::string name_, remedy_;
  const std::vector<Connection>& connections_;
};

}  // namespace aslio::io
