/// Writes a study of study_fixture.hpp into the folder named, for the test in a browser: the small one, or with `long`
/// the large one.
#include <exception>
#include <string_view>

#include "study_fixture.hpp"

int main(int argc, char** argv) {
  const bool large = argc == 3 && std::string_view(argv[2]) == "long";
  if (argc != 2 && !large) return 2;
  try {
    large ? aslio::test::write_long_study(argv[1]) : aslio::test::write_study(argv[1]);
  } catch (const std::exception&) {
    return 3;
  }
  return 0;
}
