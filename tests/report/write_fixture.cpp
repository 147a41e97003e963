/// Writes the study of study_fixture.hpp into the folder named, for the test in a browser.
#include <exception>

#include "study_fixture.hpp"

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  try {
    aslio::test::write_study(argv[1]);
  } catch (const std::exception&) {
    return 3;
  }
  return 0;
}
