#include <catch2/catch.hpp>

#include "aslio/core/errors.hpp"
#include "aslio/core/sha256.hpp"
#include "aslio/plugin/abi.hpp"

using namespace aslio;

TEST_CASE("The version in the build stamp is that of the project") {
  CHECK(plugin::kFrameworkVersion == ASLIO_PROJECT_VERSION);
  CHECK(std::string(plugin::kBuildStamp).starts_with("framework " ASLIO_PROJECT_VERSION "; c++ 202002; "));
  CHECK(std::string(plugin::kBuildStamp).find("; eigen max align 32; ") != std::string::npos);
  CHECK(std::string(plugin::kBuildStamp).find("; TimedPoint 40/8; ") != std::string::npos);
}

TEST_CASE("SHA-256 of known texts") {
  // FIPS 180-2, appendix B.1 and B.2, and the empty text.
  CHECK(sha256_of("abc") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  CHECK(sha256_of("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq") ==
        "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  CHECK(sha256_of("") == "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  CHECK_THROWS_AS(sha256_of_file("/no/such/file"), DataError);
}

TEST_CASE("A type that is taken is refused with both origins") {
  plugin::Catalog catalog;
  plugin::Entry entry;
  entry.family = "windows";
  entry.type = "fixed";
  entry.origin = "built-in";
  catalog.add(entry);
  entry.origin = "/opt/other.so";
  CHECK_THROWS_WITH(catalog.add(entry),
                    "stage windows/fixed of /opt/other.so is registered already, by built-in: rename one of them");
}
