#include <catch2/catch.hpp>

#include "aslio/core/parse.hpp"

using namespace aslio;

TEST_CASE("a time in text is exact to the nanosecond, whatever a double holds") {
  CHECK(parse_time("1700000000.123456789", 9) == 1'700'000'000'123'456'789);
  CHECK(parse_time("1700000000123456789", 0) == 1'700'000'000'123'456'789);
  CHECK(parse_time("-1.5", 9) == -1'500'000'000);
  CHECK(parse_time("1.23e3", 6) == 1'230'000'000);
  CHECK(parse_time("0.0000000005", 9) == 1);  // to nearest
  CHECK(parse_time("0.0000000004", 9) == 0);
  for (const char* text : {"", ".", "1.x", "1 ", "nan", "1e99", "99999999999", "--1"}) {
    CAPTURE(text);
    CHECK_FALSE(parse_time(text, 9));
  }
}

TEST_CASE("a number in text is finite and whole") {
  CHECK(parse_number("-2.5e-3") == -2.5e-3);
  for (const char* text : {"", "nan", "inf", "1,5", "2 "}) {
    CAPTURE(text);
    CHECK_FALSE(parse_number(text));
  }
}
