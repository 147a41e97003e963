/// Family files: what they stand for, the files they find, and what is reported of those that are wrong.

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "aslio/core/errors.hpp"
#include "family_files.hpp"
#include "recording_identity.hpp"

using namespace aslio;
using namespace aslio::experiment;
using namespace aslio::test;
using Catch::Matchers::Contains;

namespace fs = std::filesystem;

namespace {

/// What reading the family complains of; empty: nothing.
std::string complaint(const FamilyFiles& files, const std::string& text) {
  try {
    files.load(text);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return {};
}

std::string complaint(const Family& family, const std::string& sequence, const fs::path& data) {
  try {
    dataset_of(family, find_sequence(family, sequence), data);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return {};
}

const std::string kInput = "input: ['{sequence}.bag']\n";

}  // namespace

TEST_CASE("a family file becomes sequences with their files, sensor and extrinsics") {
  const FamilyFiles files;
  const Family family = files.usual("{name: a, sweeps: 7, imu_samples: 70, closed_loop: true, start: 1, duration: 2}");
  CHECK(family.name == "walks");
  CHECK(family.config.title == "Walks");
  REQUIRE(family.sequences.size() == 1);
  const FamilySequence& a = family.sequences.front();
  CHECK(a.sensor == files.folder / "sensor.yaml");
  REQUIRE(a.extrinsics.size() == 2);
  CHECK(a.extrinsics[0].source == "maker");
  CHECK(a.extrinsics[0].T_imu_lidar.p == Vec3(0.1, 0, 0));
  CHECK(a.extrinsics[1].T_imu_lidar.R(0, 0) == Approx(-1));
  CHECK(a.input == std::vector<std::string>{"a/a_*.bag | a.bag"});
  REQUIRE(a.reference);
  CHECK(a.reference->file == "a/gt.txt");
  CHECK(a.sweeps == 7);
  CHECK(a.imu_samples == 70);
  CHECK(a.closed_loop);
  CHECK(a.section.start == 1);
  CHECK(a.section.duration == 2);
  CHECK_THAT(family.resolved, Contains("schema: aslio/family/1") && Contains("sweeps: 7"));
}

TEST_CASE("what a variant and a sequence give replaces what the family gives") {
  const FamilyFiles files;
  write_text(files.folder / "other.yaml", "schema: aslio/sensor/1\n");
  const Family family =
      files.load(family_head() + family_sensor() + kInput +
                 "reference: {file: '{sequence}.txt'}\n"
                 "variants:\n"
                 "  - name: other\n"
                 "    sensor: other.yaml\n"
                 "    extrinsics: [{source: them, translation: [0, 0, 0]}]\n"
                 "    reference: {file: '{variant}/{sequence}.csv', format: csv}\n"
                 "sequences:\n"
                 "  - {name: a}\n"
                 "  - {name: b, variant: other, input: ['b_1.bag', 'b_2.bag'], reference_file: b.tum}\n"
                 "  - {name: c, variant: other}\n");
  const FamilySequence &a = family.sequences[0], &b = family.sequences[1], &c = family.sequences[2];
  CHECK(a.sensor.filename() == "sensor.yaml");
  CHECK(a.reference->file == "a.txt");
  CHECK(b.sensor.filename() == "other.yaml");
  CHECK(b.extrinsics.front().source == "them");
  CHECK(b.input == std::vector<std::string>{"b_1.bag", "b_2.bag"});
  CHECK(b.reference->file == "b.tum");
  CHECK(b.reference->format == io::ReferenceFormat::csv);
  CHECK(c.input == std::vector<std::string>{"c.bag"});
  CHECK(c.reference->file == "other/c.csv");
}

TEST_CASE("a family file that is wrong is reported with its places") {
  const FamilyFiles files;
  const std::string sequences = "sequences: [{name: a}]\n";
  const struct {
    std::string text, expected;
  } cases[] = {
      {"schema: aslio/family/1\nurl: u\nverified: v\n" + family_sensor() + kInput + sequences, "'title'"},
      {family_head() + family_sensor() + kInput, "list the recordings"},
      {family_head() + kInput + sequences, "neither the family nor a variant says 'sensor'"},
      {family_head() + "sensor: sensor.yaml\n" + kInput + sequences, "belong to a sensor file"},
      {family_head() + "sensor: gone.yaml\nextrinsics: [{source: s}]\n" + kInput + sequences, "walks.yaml:5:9: "},
      {family_head() + family_sensor() + sequences, "says 'input'"},
      {family_head() + family_sensor() + "input: ['/data/a.bag']\n" + sequences, "must lie in the data folder"},
      {family_head() + family_sensor() + "input: ['a.bag | ../a.bag']\n" + sequences, "must lie in the data folder"},
      {family_head() + family_sensor() + "input: ['{seqence}.bag']\n" + sequences, "no other braces"},
      {family_head() + family_sensor() + kInput + "sequences: [{name: a}, {name: a}]\n", "name 'a' twice"},
      {family_head() + family_sensor() + kInput + "sequences: [{name: a/b}]\n", "name"},
      {family_head() + family_sensor() + kInput +
           "variants: [{name: handheld}]\nsequences: [{name: a, variant: handhald}]\n",
       "did you mean 'handheld'"},
      {family_head() + "sensor: sensor.yaml\nextrinsics: [{translation: [0, 0, 0]}]\n" + kInput + sequences,
       "'extrinsics.0.source'"},
      {family_head() + "sensor: sensor.yaml\nextrinsics: [{source: s, rotation: [1, 0, 0, 0, 1, 0, 0, 0, -1]}]\n" +
           kInput + sequences,
       "determinant 1"},
      {family_head() + family_sensor() + kInput + "sequences: [{name: a, sweps: 3}]\n", "did you mean 'sweeps'"},
  };
  for (const auto& [text, expected] : cases) {
    INFO(text);
    CHECK_THAT(complaint(files, text), Contains(expected));
  }
}

TEST_CASE("a sequence that is not there is answered by the nearest and by all") {
  const FamilyFiles files;
  const Family family = files.usual("{name: quad_easy}, {name: quad_hard}, {name: stairs}");
  CHECK(find_sequence(family, "stairs").name == "stairs");
  CHECK_THROWS_WITH(find_sequence(family, "quad_hrad"),
                    Contains("did you mean 'quad_hard'") && Contains("quad_easy, quad_hard, stairs"));
  const auto names = [&](const std::vector<std::string>& patterns) {
    std::string text;
    for (const FamilySequence* sequence : select_sequences(family, patterns)) text += sequence->name + " ";
    return text;
  };
  CHECK(names({"*"}) == "quad_easy quad_hard stairs ");
  CHECK(names({"stairs", "quad_*"}) == "quad_easy quad_hard stairs ");  // each once, in the order of the family
  CHECK(names({"quad_h*"}) == "quad_hard ");
  CHECK_THROWS_WITH(names({"quad_*", "cloister"}), Contains("no sequence 'cloister'"));
}

TEST_CASE("a sequence finds its files in the folder of the user") {
  const FamilyFiles files;
  const Family family = files.usual("{name: a, sweeps: 7}, {name: b}");
  files.add("a/a_0.bag");
  files.add("a/gt.txt");
  files.add("b.bag");
  files.add("b/gt.txt");
  const Dataset a = dataset_of(family, find_sequence(family, "a"), files.data());
  CHECK(a.name == "a");
  CHECK(a.file == files.folder / "walks.yaml");
  CHECK(a.inputs == std::vector<fs::path>{files.data() / "a/a_0.bag"});
  CHECK(a.sensor == files.folder / "sensor.yaml");
  REQUIRE(a.reference);
  CHECK(a.reference->file == (files.data() / "a/gt.txt").string());
  CHECK(a.reference->lever_arm == std::vector<double>{0, 0, 1});
  REQUIRE(a.published);
  CHECK(a.published->family == "walks");
  CHECK(a.published->sequence == "a");
  CHECK(a.published->extrinsic_source == "maker");
  CHECK(a.published->sweeps == 7);
  // The first alternative that is there counts; parts stay a pattern, so that their reader sorts them.
  CHECK(dataset_of(family, find_sequence(family, "b"), files.data()).inputs.front() == files.data() / "b.bag");
  files.add("a/a_1.bag");
  CHECK(dataset_of(family, find_sequence(family, "a"), files.data()).inputs ==
        std::vector<fs::path>{files.data() / "a/a_*.bag"});
}

TEST_CASE("a folder whose name looks like a pattern is none") {
  const FamilyFiles files;
  const Family family = files.usual("{name: a}");
  const fs::path odd = files.folder / "data [old]";
  fs::create_directories(odd / "a");
  for (const char* name : {"a/a_0.bag", "a/a_1.bag", "a/gt.txt"}) write_text(odd / name, "");
  CHECK(dataset_of(family, find_sequence(family, "a"), odd).inputs ==
        std::vector<fs::path>{odd / "a/a_0.bag", odd / "a/a_1.bag"});
}

TEST_CASE("missing files are listed with the names that are expected, and where to get them") {
  const FamilyFiles files;
  const Family family = files.usual("{name: a}");
  CHECK_THAT(complaint(family, "a", files.data()), Contains("is no folder"));
  files.add("other.bag");
  CHECK_THAT(complaint(family, "a", files.data()), Contains("walks/a") && Contains("a/a_*.bag | a.bag (recording)") &&
                                                       Contains("a/gt.txt (reference)") &&
                                                       Contains("https://example.org/walks"));
  files.add("a.bag");
  const std::string rest = complaint(family, "a", files.data());
  CHECK_THAT(rest, Contains("a/gt.txt (reference)") && !Contains("(recording)"));
  files.add("a/gt.txt");
  CHECK(complaint(family, "a", files.data()).empty());
}

TEST_CASE("a reference that means several files is refused") {
  const FamilyFiles files;
  const Family family =
      files.load(family_head() + family_sensor() + kInput + "reference: {file: '*.txt'}\nsequences: [{name: a}]\n");
  for (const char* name : {"a.bag", "one.txt", "two.txt"}) files.add(name);
  CHECK_THAT(complaint(family, "a", files.data()), Contains("2 files of the reference") && Contains("--reference"));
}

TEST_CASE("a recording that holds its own reference is expected once") {
  const FamilyFiles files;
  const Family family = files.load(family_head() + family_sensor() + kInput +
                                   "reference: {file: '{sequence}.bag', format: recording}\nsequences: [{name: a}]\n");
  const auto expected = expected_files(family.sequences.front());
  REQUIRE(expected.size() == 1);
  CHECK(expected.front().purpose == "recording");
}

TEST_CASE("the identity of a sequence is that of its data, not of what its family file says besides") {
  const FamilyFiles files;
  for (const char* name : {"a/a_0.bag", "a/a_1.bag", "a/gt.txt"}) files.add(name);
  const auto identity = [&](const std::string& head) {
    const Family family = files.load(head + family_sensor() +
                                     "input: ['{sequence}/*.bag']\nreference: {file: '{sequence}/gt.txt'}\n"
                                     "sequences: [{name: a}]\n");
    return recording_identity(dataset_of(family, find_sequence(family, "a"), files.data()));
  };
  const std::string before = identity(family_head());
  CHECK(identity(family_head() + "citation: somebody\n") == before);
  write_text(files.data() / "a/a_1.bag", "more");
  CHECK(identity(family_head()) != before);
}

TEST_CASE("counts that differ from the published ones are reported in words") {
  PublishedSequence published;
  published.family = "walks";
  published.sequence = "a";
  published.sweeps = 10;
  CHECK(count_warnings(published, 10, 5).empty());
  const auto fewer = count_warnings(published, 9, 5);
  REQUIRE(fewer.size() == 1);
  CHECK_THAT(fewer.front(), Contains("walks/a has 10 sweeps") && Contains("9 were read") && Contains("missing"));
  published.imu_samples = 4;
  CHECK_THAT(count_warnings(published, 10, 5).front(), Contains("4 IMU samples") && Contains("another version"));
}

TEST_CASE("a family is named by its name or by its file") {
  const FamilyFiles files;
  files.usual("{name: a}");
  CHECK(find_family("walks", files.folder / ".") == files.folder / "./walks.yaml");
  CHECK(find_family((files.folder / "walks.yaml").string(), {}) == files.folder / "walks.yaml");
  CHECK_THROWS_WITH(find_family("wlaks", files.folder / "."), Contains("did you mean 'walks'"));
  CHECK_THROWS_WITH(find_family("none", {}), Contains("no family 'none'"));
  const auto name = parse_family_name("some/walks.yaml/a");
  REQUIRE(name);
  CHECK(name->family == "some/walks.yaml");
  CHECK(name->sequence == "a");
  for (const char* wrong : {"", "a", "/a", "a/", "/"}) CHECK_FALSE(parse_family_name(wrong));
}

TEST_CASE("a dataset file takes a list of inputs and patterns") {
  const FamilyFiles files;
  for (const char* name : {"lidar_0.bag", "lidar_1.bag", "imu.bag"}) files.add(name);
  const auto load = [&](const std::string& input) {
    write_text(files.data() / "dataset.yaml",
               "schema: aslio/dataset/1\nsensor: ../sensor.yaml\ninput: " + input + "\n");
    return load_dataset(files.data());
  };
  CHECK(load("[imu.bag, 'lidar_*.bag']").inputs ==
        std::vector<fs::path>{files.data() / "imu.bag", files.data() / "lidar_*.bag"});
  CHECK(load("imu.bag").inputs == std::vector<fs::path>{files.data() / "imu.bag"});
  CHECK_THAT(load("imu.bag").resolved, Contains("input: imu.bag\n"));  // as before there were lists
  CHECK_THROWS_WITH(load("[imu.bag, gone.bag]"), Contains("dataset.yaml:3:8: ") && Contains("gone.bag"));
  CHECK_THROWS_WITH(load("'gone_*.bag'"), Contains("matches nothing"));
  CHECK_THROWS_WITH(load("[]"), Contains("is required"));
}
