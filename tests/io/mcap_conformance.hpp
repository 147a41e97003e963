#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

#include "io/mcap_fixture.hpp"

namespace aslio::io::test {

/// Fields of a record of a conformance file, by name.
std::map<std::string, nlohmann::json> fields_of(const nlohmann::json& record);

/// Bytes that are told as an array of numbers in quotes.
ByteVector bytes_of(const nlohmann::json& texts);

/// The bytes of a conformance file by its list of records. Those of the public set come out as their writer made them.
ByteVector conformance_file(const nlohmann::json& file);

}  // namespace aslio::io::test
