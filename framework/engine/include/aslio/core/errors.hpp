#pragma once
/// Two kinds of user-facing failure. Numerical outcomes are values (UpdateStatus), bugs are assertions.

#include <stdexcept>
#include <string>

namespace aslio {

/// Something is wrong with what the user wrote (configuration, arguments); found before any data is read. Exit code 2.
class ConfigError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Something is wrong with what was read or could not be written. Exit code 3.
class DataError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace aslio
