// References in text: each format by its content, each slip of a writer by its words.
#include <catch2/catch.hpp>
#include <fstream>

#include "aslio/core/errors.hpp"
#include "aslio/io/reference.hpp"
#include "aslio/io/writers.hpp"
#include "io/bag_fixture.hpp"

namespace aslio::io::test {
namespace {

/// Of the poses of `made_of`.
constexpr TimeNs kFirst = 1'600'000'000'250'000'000;

struct Written {
  TemporaryFolder folder;

  Reference read(const std::string& text, ReferenceSpec spec = {}) const {
    std::ofstream(folder / "truth.txt", std::ios::binary) << text;
    spec.file = (folder / "truth.txt").string();
    return read_reference(spec);
  }
  std::string refusal(const std::string& text, const ReferenceSpec& spec = {}) const {
    return data_error([&] { read(text, spec); });
  }
  std::string wrong_key(const std::string& text, const ReferenceSpec& spec) const {
    try {
      read(text, spec);
    } catch (const ConfigError& error) {
      return error.what();
    }
    return {};
  }
};

/// Two poses: at (1, 2, 3), turned by 90 degrees about z, and 0.1 s later at (4, 5, 6).
void check_two(const Reference& reference, bool turned = true) {
  REQUIRE(reference.poses.size() == 2);
  CHECK(reference.poses[0].t == kFirst);
  CHECK(reference.poses[1].t == kFirst + kSecond / 10);
  CHECK(reference.poses[0].T.p == Vec3(1, 2, 3));
  CHECK(reference.poses[1].T.p == Vec3(4, 5, 6));
  CHECK(reference.positions_only != turned);
  const Vec3 x = reference.poses[0].T.R.col(0);
  CHECK((x - (turned ? Vec3(0, 1, 0) : Vec3(1, 0, 0))).norm() < 1e-6);
}

ReferenceSpec with(const std::vector<std::string>& columns) {
  ReferenceSpec spec;
  spec.columns = columns;
  return spec;
}

/// Rows of TUM along x, 0.1 s apart.
std::string line_of_tum(int count, const std::string& quaternion, double x0 = 0) {
  std::string text;
  for (int i = 0; i < count; ++i) {
    text += std::to_string(1'600'000'000 + i / 10) + "." + std::to_string(i % 10) + " " + std::to_string(x0 + i) +
            " 0 0 " + quaternion + "\n";
  }
  return text;
}

}  // namespace

TEST_CASE("the formats of references are found from their content") {
  const Written w;
  check_two(w.read("1600000000.25 1 2 3 0 0 0.70710678 0.70710678\n1600000000.35 4 5 6 0 0 0 1\n"));
  check_two(
      w.read("#timestamp [ns], p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z "
             "[], v_RS_R_x [m s^-1]\n1600000000250000000,1,2,3,0.70710678,0,0,0.70710678,9\n"
             "1600000000350000000,4,5,6,1,0,0,0,9\n"));
  check_two(
      w.read("#sec,nsec,x,y,z,qx,qy,qz,qw\n1600000000,250000000,1,2,3,0,0,0.70710678,0.70710678\n"
             "1600000000,350000000,4,5,6,0,0,0,1\n"));
  check_two(w.read("1600000000 250000000 1 2 3 0 0 0.70710678 0.70710678\n1600000000 350000000 4 5 6 0 0 0 1\n"));
  check_two(
      w.read("num, t, x, y, z, qx, qy, qz, qw\n0,1600000000.25,1,2,3,0,0,0.70710678,0.70710678\n"
             "1,1600000000.35,4,5,6,0,0,0,1\n"));
  check_two(w.read("1600000000250000000,0,-1,0,1,1,0,0,2,0,0,1,3\n1600000000350000000,1,0,0,4,0,1,0,5,0,0,1,6\n"));
  check_two(
      w.read("%time,field.header.seq,field.header.stamp,field.pose.position.x,field.pose.position.y,"
             "field.pose.position.z,field.pose.orientation.x,field.pose.orientation.y,field.pose.orientation.z,"
             "field.pose.orientation.w\n7,0,1600000000250000000,1,2,3,0,0,0.70710678,0.70710678\n"
             "8,1,1600000000350000000,4,5,6,0,0,0,1\n"));
  check_two(w.read("1600000000.25 1 2 3\n1600000000.35 4 5 6\n"), false);
  check_two(w.read("1600000000250000000,1,2,3\n1600000000350000000,4,5,6\n"), false);
  check_two(w.read("t;x;y;z\n1600000000.25;1;2;3\n1600000000.35;4;5;6\n"), false);
}

TEST_CASE("a key overrules what the content tells of the format") {
  const Written w;
  const std::string euroc = "1600000000250000000,1,2,3,0.70710678,0,0,0.70710678\n1600000000350000000,4,5,6,1,0,0,0\n";
  CHECK_THAT(w.refusal(euroc), Catch::Contains("truth.txt:1: 8 columns by commas, stamps in ns: the order of the "
                                               "quaternion cannot be told; set `format: euroc`"));
  ReferenceSpec spec;
  spec.format = ReferenceFormat::euroc;
  check_two(w.read(euroc, spec));
  spec.format = ReferenceFormat::tum;
  CHECK_FALSE(w.read(euroc, spec).positions_only);
  CHECK_THAT(w.refusal("1 2 3 4\n2 3 4 5\n", spec), Catch::Contains("truth.txt:1: 4 columns where TUM has 8"));
}

TEST_CASE("columns are listed by their place or by their name") {
  const Written w;
  check_two(w.read("9 3 2 1 1600000000.25\n9 6 5 4 1600000000.35\n", with({"-", "z", "y", "x", "t"})), false);
  check_two(w.read("when,east,north,up\n1600000000.25,1,2,3\n1600000000.35,4,5,6\n",
                   with({"t=when", "x=east", "y=north", "z=up"})),
            false);
  check_two(w.read("1600000000.25 1 2 3 0.70710678 0 0 0.70710678\n1600000000.35 4 5 6 1 0 0 0\n",
                   with({"t", "x", "y", "z", "qw", "qx", "qy", "qz"})));
  const std::string rows = "when,east,north,up\n1,1,2,3\n";
  CHECK_THAT(w.wrong_key(rows, with({"t=when", "x=west", "y=north", "z=up"})),
             Catch::Contains("columns: there is no column 'west'; the header has when, east, north, up"));
  CHECK_THAT(w.wrong_key(rows, with({"t", "x", "y", "w"})), Catch::Contains("columns: 'w' is none of t, sec, nsec"));
  CHECK_THAT(w.wrong_key(rows, with({"t", "x", "y", "-"})), Catch::Contains("columns: z is missing"));
  CHECK_THAT(w.wrong_key(rows, with({"x", "x", "y", "z"})), Catch::Contains("columns: 'x' is listed twice"));
  CHECK_THAT(w.wrong_key(rows, with({"x", "y", "z", "sec"})), Catch::Contains("columns: nsec is missing"));
  CHECK_THAT(w.wrong_key(rows, with({"t", "x", "y", "z", "qx"})), Catch::Contains("columns: qy, qz, qw is missing"));
  CHECK_THAT(w.refusal("1 2 3 4 5 6\n"),
             Catch::Contains("truth.txt:1: 6 columns tell no pose; list them in `columns`"));
}

TEST_CASE("any unit of time is read, exact to the nanosecond") {
  const Written w;
  check_two(w.read("1600000000250 1 2 3\n1600000000350 4 5 6\n"), false);
  check_two(w.read("1600000000250000 1 2 3\n1600000000350000 4 5 6\n"), false);
  check_two(w.read("1.60000000025e+09 1 2 3\n1.60000000035e9 4 5 6\n"), false);
  const Reference exact = w.read("1600000000.123456789 1 2 3\n1600000000.123456790 1 2 4\n");
  CHECK(exact.poses[0].t == 1'600'000'000'123'456'789);
  CHECK(exact.poses[1].t == 1'600'000'000'123'456'790);
  CHECK(contains(w.read("1600000000250 1 2 3\n").notes, "stamps are in ms (by their size)"));
  CHECK(w.read("time_us,x,y,z\n100000,1,2,3\n200000,4,5,6\n").poses[1].t == kSecond / 5);
  CHECK(w.read("0 1 2 3\n100000000 4 5 6\n").poses[1].t == kSecond / 10);
  CHECK(w.read("1000000000 1 2 3\n1100000000 4 5 6\n").poses[1].t == 11 * kSecond / 10);
  CHECK_THAT(w.refusal("0 1 2 3\n100 4 5 6\n"),
             Catch::Contains("the stamps (0, 100, ..) tell no unit; set `time_unit` to s, ms, us or ns"));
  ReferenceSpec spec;
  spec.time_unit = TimeUnit::ms;
  CHECK(w.read("0 1 2 3\n100 4 5 6\n", spec).poses[1].t == kSecond / 10);
  CHECK_THAT(w.refusal("1600000000,1000000000,1,2,3\n", with({"sec", "nsec", "x", "y", "z"})),
             Catch::Contains("truth.txt:1: not nanoseconds of a second (0 to 999999999): '1000000000'"));
  spec.time_unit = TimeUnit::s;
  CHECK_THAT(w.refusal("1600000000250000000 1 2 3\n", spec),
             Catch::Contains("truth.txt:1: not a time in s; set `time_unit`, or mend the row: '1600000000250000000'"));
}

TEST_CASE("byte order mark, CR LF, comments of any kind and empty lines are passed over") {
  const Written w;
  check_two(
      w.read("\xef\xbb\xbf# timestamp tx ty tz qx qy qz qw\r\n// by hand\r\n% and so on\r\n\r\n"
             "1600000000.25 1 2 3 0 0 0.70710678 0.70710678\r\n#\r\n1600000000.35 4 5 6 0 0 0 1\r\n"));
  check_two(w.read("\xef\xbb\xbf"
                   "1600000000.25, 1, 2, 3\r\n# half\r\n1600000000.35, 4, 5, 6,\r\n"),
            false);
  check_two(w.read("1600000000.25\t1\t2\t3\n1600000000.35   4 5 6  "), false);
  CHECK_THAT(w.refusal("1600000000.25 1 2 3\n\n# c\n1600000000.35 4 x 6\n"),
             Catch::Contains("truth.txt:4: not a finite number; leave the row out: 'x'"));
  CHECK_THAT(w.refusal("1600000000.25 1 2 3\n1600000000.35 4 5\n"),
             Catch::Contains("truth.txt:2: 3 columns, where there are 4"));
  CHECK_THAT(w.refusal("# nothing\n"), Catch::Contains("holds no pose: is it the right file?"));
}

TEST_CASE("poses that are not in order are sorted, copies are left out, and both are told") {
  const Written w;
  const Reference sorted = w.read("1600000000.35 4 5 6\n1600000000.25 1 2 3\n");
  check_two(sorted, false);
  CHECK(contains(sorted.warnings, "1 of 2 poses are earlier than the one before them, the first in line 2: sorted"));
  const Reference once = w.read("1600000000.25 1 2 3\n1600000000.25 1 2 3\n1600000000.35 4 5 6\n");
  check_two(once, false);
  CHECK(contains(once.notes, "1 poses repeat the one before"));
  CHECK(once.warnings.empty());
  std::string text = line_of_tum(200, "0 0 0.1 0.995");
  text += "1600000019.9 7 7 7 0 0 0 1\n";
  CHECK(contains(w.read(text).warnings,
                 "1 poses have the stamp of the one before them and are others, the first in "
                 "line 201: left out"));
}

TEST_CASE("stamps of too few digits are named") {
  const Written w;
  std::string text;
  for (int i = 0; i < 300; ++i) text += "1.62439e+09 " + std::to_string(i) + " 0 0 0 0 0 1\n";
  CHECK_THAT(w.refusal(text), Catch::Contains("truth.txt: the first 300 stamps are equal (1.62439e+09 s): they were "
                                              "written with too few digits; write them anew with 6 decimals"));
  std::ofstream(w.folder / "estimate.tum") << text;
  CHECK_THAT(data_error([&] { read_tum(w.folder / "estimate.tum"); }),
             Catch::Contains("estimate.tum:2: the first 300 stamps are equal: they were written with too few digits"));
  text.clear();
  for (int i = 0; i < 300; ++i) {
    text += std::to_string(1'624'390'001 + i / 10) + " " + std::to_string(i) + " 0 0 0 0 0 1\n";
  }
  CHECK_THAT(w.refusal(text), Catch::Contains("the first 10 stamps are equal"));
  std::string zeros;
  for (int i = 0; i < 5; ++i) zeros += "0 " + std::to_string(i) + " 0 0\n";
  CHECK_THAT(w.refusal(zeros), Catch::Contains("all 5 stamps are 0"));
}

TEST_CASE("a reference without orientation tells positions only") {
  const Written w;
  CHECK(contains(w.read("1600000000.25 1 2 3\n").notes, "positions only (there is no orientation): no rotation error"));
  const Reference zeros = w.read(line_of_tum(9, "0 0 0 0", 744073.3226));
  CHECK(zeros.positions_only);
  CHECK(contains(zeros.notes, "all quaternions are 0 0 0 0"));
  const Reference constant = w.read(line_of_tum(9, "0 0 0 1"));
  CHECK(constant.positions_only);
  CHECK(contains(constant.notes, "the orientation is the same over 8.0 m of path"));
  ReferenceSpec spec;
  spec.positions_only = PositionsOnly::no;
  CHECK_FALSE(w.read(line_of_tum(9, "0 0 0 1"), spec).positions_only);
  CHECK_THAT(w.wrong_key("1600000000.25 1 2 3\n", spec),
             Catch::Contains("has no orientation, which `positions_only: no` asks for"));
  CHECK_THAT(w.refusal("1600000000.25 1 2 3 0 0 0 1\n1600000000.35 4 5 6 0 0 0 0\n"),
             Catch::Contains("truth.txt:2: a quaternion 0 0 0 0, as have 1 of 2 rows"));
  spec.positions_only = PositionsOnly::yes;
  check_two(w.read("1600000000.25 1 2 3 0 0 0.7 0.7\n1600000000.35 4 5 6 9 9 9 9\n", spec), false);
  CHECK_THAT(w.refusal("1600000000.25 1 2 3 0 0 0.5 0.5\n"), Catch::Contains("a quaternion of norm 0.7071"));
}

TEST_CASE("poses of KITTI have their stamps in a file of their own") {
  const Written w;
  const std::string poses = "0 -1 0 1 1 0 0 2 0 0 1 3\n1 0 0 4 0 1 0 5 0 0 1 6\n";
  std::ofstream(w.folder / "times.txt") << "1.60000000025e+09\n1.60000000035e+09\n";
  ReferenceSpec spec;
  CHECK_THAT(w.wrong_key(poses, spec), Catch::Contains("poses without stamps; name the file of the stamps in `times`"));
  spec.times = (w.folder / "times.txt").string();
  check_two(w.read(poses, spec));
  CHECK_THAT(w.refusal(poses + "1 0 0 4 0 1 0 5 0 0 1 6\n", spec),
             Catch::Contains("has 3 poses") && Catch::Contains("has 2 stamps"));
  CHECK_THAT(w.refusal("0 1 0 1 1 0 0 2 0 0 1 3\n", spec),
             Catch::Contains("truth.txt:1: the 9 numbers are no rotation"));
}

TEST_CASE("offset and spacing change the stamps and are told") {
  const Written w;
  ReferenceSpec spec;
  spec.time_offset = -0.25;
  spec.min_spacing = 0.15;
  const Reference reference = w.read("1600000000.25 1 2 3\n1600000000.35 4 5 6\n1600000000.45 7 8 9\n", spec);
  REQUIRE(reference.poses.size() == 2);
  CHECK(reference.poses[0].t == 1'600'000'000 * kSecond);
  CHECK(reference.poses[1].T.p == Vec3(7, 8, 9));
  CHECK(contains(reference.notes, "-0.250000 s added to all stamps"));
  CHECK(contains(reference.notes, "1 poses come less than 0.15 s after the last"));
}

}  // namespace aslio::io::test
