// What is recorded of a match whose residual has one row, or several.
#include <catch2/catch.hpp>
#include <limits>

#include "aslio/toolkit/point_matches.hpp"

using namespace aslio;

namespace {

ResidualRow row(double r, double information = 1) {
  ResidualRow out;
  out.r = r;
  out.J = Vec3::UnitX();
  out.information = information;
  return out;
}

}  // namespace

TEST_CASE("a match of one row keeps its sign, one of several has the length of their vector") {
  std::vector<MatchRecord> records;
  double rms = 0;
  CHECK(record_matches(std::vector{row(-3), row(7, 0), row(4)}, 1, records, rms) == 2);
  REQUIRE(records.size() == 3);
  CHECK((records[0].accepted && records[0].residual == -3.0F));
  CHECK_FALSE(records[1].accepted);
  CHECK(records[2].residual == 4.0F);
  CHECK(rms == Approx(std::sqrt(12.5)));

  const std::vector rows = {row(1), row(0), row(0.01), row(9, 0), row(9, 0), row(9, 0), row(-2), row(9, 0), row(2)};
  CHECK(record_matches(rows, 3, records, rms) == 2);
  REQUIRE(records.size() == 3);
  CHECK(records[0].residual == Approx(1.00005));
  CHECK_FALSE(records[1].accepted);
  CHECK(records[2].residual == Approx(std::sqrt(8.0)));  // of the rows that take part
  CHECK(rms == Approx(std::sqrt((1.0001 + 8.0) / 2)));
}

TEST_CASE("a match that a gate left out keeps its residual, and what found no surface has none") {
  std::vector<MatchRecord> records;
  double rms = 0;
  CHECK(record_matches(std::vector{row(-3), row(-7, 0), ResidualRow{}}, 1, records, rms) == 1);
  CHECK(rms == 3.0);
  CHECK((records[1].matched && !records[1].accepted && records[1].residual == -7.0F));
  CHECK((!records[2].matched && !records[2].accepted && records[2].residual == 0.0F));
  CHECK(record_matches(std::vector{row(3, 0), row(0, 0), row(4, 0)}, 3, records, rms) == 0);
  CHECK((records[0].matched && records[0].residual == 5.0F));
}

TEST_CASE("without matches there is no RMS") {
  std::vector<MatchRecord> records(5);
  double rms = 1;
  CHECK(record_matches({}, 1, records, rms) == 0);
  CHECK(records.empty());
  CHECK(rms == 0.0);
}

TEST_CASE("a match passes a gate as a whole, by the rows that have information") {
  CHECK(within(std::vector{row(-0.3)}, 0.09));
  CHECK_FALSE(within(std::vector{row(-0.3)}, 0.08));
  CHECK(within(std::vector{row(0.1), row(-0.3), row(0.2)}, 0.09));
  CHECK_FALSE(within(std::vector{row(0.1), row(0.4), row(0.2)}, 0.09));
  CHECK(within(std::vector{row(0.1), row(9, 0), row(0.2)}, 0.09));
  CHECK(within(std::vector{row(std::numeric_limits<double>::quiet_NaN())}, 0.09));
}
