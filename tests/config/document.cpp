#include "aslio/config/document.hpp"

#include <sys/stat.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "config/stages.hpp"

using namespace aslio;
using namespace aslio::config;
using aslio::test::error_of;

namespace {

std::string document_error(const std::string& text) {
  try {
    parse_document(text, "a.yaml");
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "accepted";
}

std::string file_error(const std::filesystem::path& path) {
  try {
    read_text(path);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "accepted";
}

std::string repeat(const std::string& text, std::size_t n) {
  std::string result;
  for (std::size_t i = 0; i < n; ++i) result += text;
  return result;
}

}  // namespace

TEST_CASE("A tree keeps the order of keys and the place of each part, counted from 1") {
  const Node root = parse_document("b: 1\na:\n  - x\n  - {k: 'v'}\n", "dir/a.yaml");
  REQUIRE(root.members().size() == 2);
  CHECK(root.members()[0].key == "b");
  CHECK(root.members()[0].at.text() == "dir/a.yaml:1:1");
  CHECK(root.members()[0].value.at().text() == "dir/a.yaml:1:4");
  const Node& list = root.members()[1].value;
  REQUIRE(list.items().size() == 2);
  CHECK(list.items()[1].at().text() == "dir/a.yaml:4:5");
  const Member* v = list.items()[1].find("k");
  REQUIRE(v != nullptr);
  CHECK(v->value.quoted());
  CHECK(v->value.text() == "v");
}

TEST_CASE("An empty value stands where its key stands") {
  const Node root = parse_document("a:\n\n\nb: 1\n", "a.yaml");
  CHECK(root.members()[0].value.is_null());
  CHECK(root.members()[0].value.at().text() == "a.yaml:1:1");
}

TEST_CASE("What yaml-cpp would let pass is refused, all of it at once and in order") {
  CHECK(document_error("a: &base 1\nb: *base\n<<: {x: 1}\nc: !!str 5\nd: !mine 5\na: 2\n? [1]\n: 3\n") ==
        "a.yaml:1:4: anchors are not supported (&base): write the values out\n"
        "a.yaml:2:4: aliases (*name) are not supported: write the values out\n"
        "a.yaml:3:1: merge keys (<<) are not supported: write the keys out\n"
        "a.yaml:4:4: tags are not supported (tag:yaml.org,2002:str): write the plain value\n"
        "a.yaml:5:4: tags are not supported (!mine): write the plain value\n"
        "a.yaml:6:1: duplicate key 'a': remove one of them\n"
        "a.yaml:7:3: a key must be a name");
  CHECK(document_error("a: {b: 1, c: 2, b: 3}\n") == "a.yaml:1:17: duplicate key 'b': remove one of them");
}

TEST_CASE("Documents that are no single YAML text name the place") {
  CHECK(document_error("a: [1, 2\nb: 3\n") == "a.yaml:2:2: not valid YAML: end of sequence flow not found");
  CHECK(document_error("a: 1\n---\nb: 2\n") == "a.yaml: more than one document: remove what follows '---'");
  CHECK(document_error("---\na: 1\n") == "accepted");
  CHECK(document_error("a: \"x\n y\"\nb: \x01\n") ==
        "a.yaml:3:4: control character (byte 1): the file must be UTF-8 text");
}

TEST_CASE("Size, depth and number of values are bounded") {
  CHECK(document_error(repeat("[", 32) + repeat("]", 32)) == "accepted");
  CHECK(document_error(repeat("[", 33) + repeat("]", 33)) == "a.yaml:1:33: nested deeper than 32 levels");
  CHECK_THAT(document_error(repeat("[", 100'000)), Catch::Matchers::EndsWith(": nested deeper than 32 levels"));
  CHECK(document_error(repeat("- 1\n", 99'999)) == "accepted");
  CHECK(document_error(repeat("- 1\n", 100'001)) == "a.yaml:100001:3: more than 100000 values");
  CHECK(document_error(std::string(1'000'001, ' ')) == "a.yaml: 1000001 bytes, at most 1000000 are read");
}

TEST_CASE("Files that cannot be read are named with the reason") {
  const std::filesystem::path dir = std::filesystem::path(ASLIO_BINARY_DIR) / "config_files";
  std::filesystem::create_directories(dir);
  CHECK(file_error(dir / "absent.yaml") ==
        (dir / "absent.yaml").string() + ": cannot be opened: No such file or directory");
  CHECK(file_error(dir) == dir.string() + ": is a directory, not a file");
  CHECK(file_error("/dev/zero") == "/dev/zero: is a pipe or device, not a regular file");
  const std::filesystem::path pipe = dir / "pipe.yaml";
  REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
  CHECK(file_error(pipe) == pipe.string() + ": is a pipe or device, not a regular file");
  const std::filesystem::path large = dir / "large.yaml";
  std::ofstream(large) << std::string(1'000'001, ' ');
  CHECK(file_error(large) == large.string() + ": larger than 1000000 bytes: no configuration is that long");
  std::filesystem::remove_all(dir);
}

TEST_CASE("A tree survives being written and read again") {
  const std::string text =
      "plain: abc\nnumber: 0.1\nquoted: \"0.1\"\nempty: \"\"\nnone: null\nlist: [1, [2, 3], x]\nblocks:\n  - a: 1\n"
      "    b:\n      - c: \"x: y # z\"\n      - []\n  - plain\n\"odd key:\": {}\nescape: \"\\x1b[31m \\\"\\\\\"\n"
      "mark: \"---\"\nword: \"null\"\nyes: \"true\"\n";
  const Node once = parse_document(text, "a.yaml");
  const Node twice = parse_document(to_yaml(once), "b.yaml");
  CHECK(same(once, twice));
  CHECK(to_yaml(once) == to_yaml(twice));
  CHECK(twice.find("quoted")->value.quoted());
  CHECK(twice.find("escape")->value.text() == "\x1b[31m \"\\");
}

TEST_CASE("The schema comes first and says what the file is") {
  const plugin::Catalog catalog = test::make_catalog();
  const auto error = [&](const std::string& text) -> std::string {
    try {
      parse<test::Workshop>(text, "a.yaml", FileKind::pipeline, catalog);
    } catch (const ConfigError& e) {
      return e.what();
    }
    return "accepted";
  };
  const std::string must = "the file must begin with 'schema: aslio/pipeline/1', but ";
  CHECK(error("") == "a.yaml: " + must + "is empty");
  CHECK(error("- 1\n") == "a.yaml:1:1: " + must + "is not a block of keys");
  CHECK(error("window: quartz\nschema: aslio/pipeline/1\n") == "a.yaml:1:1: " + must + "begins with 'window'");
  CHECK(error("schema: aslio/sensor/1\n") ==
        "a.yaml:1:9: expected schema aslio/pipeline/1, found 'aslio/sensor/1' (this is a sensor file)");
  CHECK(error("schema: aslio/pipeline/2\n") ==
        "a.yaml:1:9: expected schema aslio/pipeline/1, found 'aslio/pipeline/2' (this build reads version 1)");
  CHECK(error("schema: [x]\n") == "a.yaml:1:9: schema must be aslio/pipeline/1");
  CHECK(error("schema: aslio/pipeline/1\nwindow: quartz\n") == "accepted");
}

TEST_CASE("What kind of file it is can be asked before it is read") {
  const std::filesystem::path path = std::filesystem::path(ASLIO_BINARY_DIR) / "config_kind.yaml";
  std::ofstream(path) << "schema: aslio/study/1\nanything: 1\n";
  CHECK(peek_kind(path) == FileKind::study);
  std::ofstream(path) << "schema: aslio/studdy/1\n";
  CHECK_THROWS_WITH(peek_kind(path), path.string() +
                                         ":1:9: unknown schema 'aslio/studdy/1' (did you mean "
                                         "'aslio/study/1'?)");
  std::filesystem::remove(path);
}

TEST_CASE(
    "the place of a path is where it is written, as far down as it is, and the begin of the file for what is not") {
  const Node root = parse_document("a: 1\nb:\n  - {c: 2}\n  - {c: 3, d: {e: 4}}\n", "a.yaml");
  CHECK(place_of(root, "a").text() == "a.yaml:1:4");
  CHECK(place_of(root, "b.1.c").text() == "a.yaml:4:9");
  CHECK(place_of(root, "b.1.d.e").text() == "a.yaml:4:19");
  CHECK(place_of(root, "b.0.d").text() == "a.yaml:3:5");
  CHECK(place_of(root, "b.2").text() == place_of(root, "b").text());
  CHECK(place_of(root, "z.a").text() == "a.yaml:1:1");
}
