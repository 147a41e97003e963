#pragma once
/// What is wrong with a configuration, gathered so that the user sees everything at once.

#include <string>
#include <vector>

#include "aslio/config/node.hpp"

namespace aslio::config {

class Problems {
 public:
  void add(const Location& at, const std::string& message);
  std::size_t size() const { return found_.size(); }
  /// A line "place: message" per problem, in the order of the places.
  std::string text() const;
  /// Throws text() as one ConfigError; does nothing when there is no problem.
  void raise() const;

 private:
  struct Problem {
    Location at;
    std::string message;
  };
  std::vector<Problem> found_;
};

}  // namespace aslio::config
