#pragma once
/// What was thrown, in words: stages of others may throw anything.

#include <cxxabi.h>

#include <cstdlib>
#include <exception>
#include <memory>
#include <string>
#include <typeinfo>

namespace aslio {

/// Of the exception that is being handled: what it says or, where it is no std::exception, its type. Pre: inside a
/// catch block.
inline std::string what_was_thrown() {
  try {
    throw;
  } catch (const std::exception& error) {
    return error.what();
  } catch (...) {
    const std::type_info* type = abi::__cxa_current_exception_type();
    int status = -1;
    const std::unique_ptr<char, decltype(&std::free)> name(
        type == nullptr ? nullptr : abi::__cxa_demangle(type->name(), nullptr, nullptr, &status), &std::free);
    return std::string("it threw what is no std::exception, of type '") + (name ? name.get() : "unknown") + "'";
  }
}

}  // namespace aslio
