// Every row of the table is a test case of its own, and the page in docs/ is made of the same table.
#include <catch2/catch.hpp>
#include <cstdlib>

#include "faults/table.hpp"

using namespace aslio::test;
using namespace aslio::test::faults;

namespace {

class RowCase final : public Catch::ITestInvoker {
 public:
  explicit RowCase(Row row) : row_(std::move(row)) {}
  void invoke() const override { hold(row_); }

 private:
  Row row_;
};

/// One that is pending prints what it sees, and fails once it is met: then its mark has to go.
bool register_rows() {
  for (Row& row : all_rows()) {
    const std::string name = title(row), tags = row.pending.empty() ? "[fault]" : "[fault][!shouldfail]";
    const Catch::AutoReg registered(new RowCase(std::move(row)), CATCH_INTERNAL_LINEINFO, Catch::StringRef(),
                                    Catch::NameAndTags(name, tags));
  }
  return true;
}

const bool registered = register_rows();

}  // namespace

TEST_CASE("the table of faults has each of 1 to 72 once, and docs/faults.md is made of it") {
  REQUIRE(registered);
  const auto rows = all_rows();
  REQUIRE(rows.size() == 72);
  for (std::size_t i = 0; i < rows.size(); ++i) CHECK(rows[i].number == static_cast<int>(i) + 1);
  if (std::getenv("ASLIO_WRITE_FAULTS") != nullptr) write_text(ASLIO_SOURCE_DIR "/docs/faults.md", to_markdown(rows));
  CHECK(content(ASLIO_SOURCE_DIR "/docs/faults.md") == to_markdown(rows));
}
