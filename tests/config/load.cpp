#include "aslio/config/load.hpp"

#include <catch2/catch.hpp>
#include <random>

#include "config/stages.hpp"

using namespace aslio;
using namespace aslio::test;
using Catch::Matchers::Contains;
using config::follow_alias;
using config::parse_document;

namespace {

/// `line` inside the block of a pendulum: its error, less the place.
std::string pendulum_error(const std::string& line) {
  return error_of(std::string("window:\n  type: pendulum\n  ").append(line).append("\n"));
}

}  // namespace

TEST_CASE("Values reach the parameters, and what is not given keeps its default") {
  const auto loaded = read(
      "window: {type: pendulum, period: 2.5e-1, teeth: +7, loud: true, spring: leaf}\n"
      "samplers: [quartz, {type: pendulum}]\nframe: {centre: [1, -2, .5], label: 010}\n"
      "boxes: [{label: a}, {centre: [1, 1, 1]}]\n");
  CHECK(loaded.value.window.type() == "pendulum");
  REQUIRE(loaded.value.samplers.size() == 2);
  CHECK(loaded.value.samplers[0].type() == "quartz");
  CHECK(loaded.value.frame.centre == std::vector<double>{1.0, -2.0, 0.5});
  CHECK(loaded.value.frame.label == "010");
  REQUIRE(loaded.value.boxes.size() == 2);
  CHECK(loaded.value.boxes[0].label == "a");
  CHECK(loaded.value.boxes[1].centre[2] == 1.0);
  CHECK(loaded.value.max_speed == 30.0);
  CHECK(loaded.plugin_types ==
        std::vector<std::string>{"clocks/pendulum", "clocks/quartz", "springs/coil", "springs/leaf"});

  exec::Executor exec(1);
  const SensorModel sensor;
  const BuildContext context{.exec = exec, .sensor = sensor, .log = nullptr};
  CHECK(loaded.value.window.make(context)->tick() == 0.25 * 7.0);
  CHECK(loaded.value.samplers[1].make(context)->tick() == 2.0);
}

TEST_CASE("A recipe outlives the text, the catalog and the values it was read with") {
  config::Nested<Clock> kept;
  {
    const auto loaded = read("window: {type: pendulum, period: 0.5}\n");
    kept = loaded.value.window;
  }
  exec::Executor exec(1);
  const SensorModel sensor;
  CHECK(kept.make({.exec = exec, .sensor = sensor, .log = nullptr})->tick() == 1.0);
  config::Nested<Clock> unread("pendulum");
  CHECK_THROWS_WITH(unread.make({.exec = exec, .sensor = sensor, .log = nullptr}),
                    "stage 'pendulum' is built before its configuration has been read");
}

TEST_CASE("Everything wrong is reported at once, in the order of the file, overrides last") {
  CHECK(error_of("window:\n  type: pendulum\n  step_mn: 3\n  window_size: 2\n  period: 20\n  teeth: 4.0\n"
                 "boxes: [{centre: [1, 2]}]\nsamplers: [{type: qartz}]\nmax_sped: 3\n",
                 {{"window.loud=1"}, {"note=[a]"}}) ==
        "a.yaml:4:3: unknown key 'window.step_mn' (did you mean 'step_min'?)\n"
        "a.yaml:5:3: 'window.window_size' was removed: use frame_length\n"
        "a.yaml:6:11: 'window.period' is out of range: 20 s, admissible is [0.001, 10] s\n"
        "a.yaml:7:10: 'window.teeth' must be a whole decimal number, is '4.0'\n"
        "a.yaml:8:18: 'boxes.0.centre' must be a list of 3 numbers [m], is a list of 2\n"
        "a.yaml:9:19: 'samplers.0' names unknown type 'qartz' of clocks (did you mean 'quartz'?); there are pendulum, "
        "quartz\n"
        "a.yaml:10:1: unknown key 'max_sped' (did you mean 'max_speed'?)\n"
        "--set window.loud=1: 'window.loud' must be true or false, is '1'\n"
        "--set note=[a]: 'note' must be text, is a list");
}

TEST_CASE("A key given twice hides no other error") {
  CHECK(error_of("window:\n  type: pendulum\n  teeth: 1\n  teeth: 5\n  lod: true\nnote: &x a\nnote: b\nmax_speed: 0\n",
                 {{"frame=3"}}) ==
        "a.yaml:4:10: 'window.teeth' is out of range: 1, admissible is [2, 100]\n"
        "a.yaml:5:3: duplicate key 'teeth': remove one of them\n"
        "a.yaml:6:3: unknown key 'window.lod' (did you mean 'loud'?)\n"
        "a.yaml:7:7: anchors are not supported (&x): write the values out\n"
        "a.yaml:8:1: duplicate key 'note': remove one of them\n"
        "a.yaml:9:12: 'max_speed' is out of range: 0 m/s, admissible is > 0 m/s\n"
        "--set frame=3: 'frame' must be a block of keys, is '3'");
  CHECK(error_of("window: quartz\nwindow: quartz\n", {{"samplers.1=quartz"}}) ==
        "a.yaml:3:1: duplicate key 'window': remove one of them\n"
        "--set samplers.1=quartz: 'samplers' has 0 elements: the index must be at most 0 (which appends one)");
  const plugin::Catalog catalog = make_catalog();
  CHECK_THROWS_WITH(config::parse<Workshop>("note: a\nnote: b\n", "a.yaml", config::FileKind::pipeline, catalog),
                    "a.yaml:1:1: the file must begin with 'schema: aslio/pipeline/1', but begins with 'note'\n"
                    "a.yaml:2:1: duplicate key 'note': remove one of them");
  // A hole in the tree is no missing key.
  CHECK(error_of("note: &w quartz\nwindow: *w\n") ==
        "a.yaml:2:7: anchors are not supported (&w): write the values out\n"
        "a.yaml:3:9: aliases (*name) are not supported: write the values out");
}

TEST_CASE("A cross-check that an override breaks names the override") {
  const std::string text = "window: {type: pendulum, step_min: 0.2, step_max: 0.4}\n";
  CHECK(error_of(text, {{"window.step_max=0.1"}}) ==
        "a.yaml:2:36: 'window.step_min' = 0.2 must not exceed step_max (window.step_max was set by --set "
        "window.step_max=0.1)");
  CHECK(error_of(text, {{"window.step_min=0.5"}}) ==
        "--set window.step_min=0.5: 'window.step_min' = 0.5 must not exceed step_max");
  CHECK(error_of(text, {{"window={type: pendulum, step_min: 0.6}"}}) ==
        "--set window={type: pendulum, step_min: 0.6}: 'window.step_min' = 0.6 must not exceed step_max");
}

TEST_CASE("Unknown keys without a near name list the known ones") {
  CHECK(error_of("window: {type: quartz, zzzzzz: 1}\n") ==
        "a.yaml:2:24: unknown key 'window.zzzzzz' (known: type, frequency)");
  CHECK(error_of("window: {type: pendulum, spring: {type: leaf, stiffness: 1}}\n") ==
        "a.yaml:2:47: unknown key 'window.spring.stiffness' (known: type)");
  CHECK(error_of("window: quartz\nboxes: [{centre: [1, 2, 3], lable: x}]\n") ==
        "a.yaml:3:29: unknown key 'boxes.0.lable' (did you mean 'label'?)");
}

TEST_CASE("Numbers are decimal, finite and unquoted, nothing is guessed") {
  const std::string real = "a.yaml:4:11: 'window.period' must be a finite decimal number [s], is ";
  for (const std::string bad : {"010", ".nan", ".inf", "0x10", "1_000", "1e999", "one", "1.5s", "00.5", "1e", "."}) {
    CHECK(pendulum_error(std::string("period: ").append(bad)) == real + '\'' + bad + '\'');
  }
  CHECK(pendulum_error("period: '0.1'") == real + "the quoted text '0.1'");
  CHECK(pendulum_error("period: [1]") == real + "a list");
  CHECK(pendulum_error("period: {a: 1}") == real + "a block of keys");
  CHECK(pendulum_error("period:") == "a.yaml:4:3: 'window.period' must be a finite decimal number [s], is empty");
  for (const std::string good : {"1", "+1", "1.", ".5", "1e0", "1E-2", "0.001", "10"}) {
    CHECK(pendulum_error(std::string("period: ").append(good)) == "accepted");
  }
  for (const std::string bad : {"4.0", "1e1", "010", "'4'", "9223372036854775808"}) {
    CHECK_THAT(pendulum_error(std::string("teeth: ").append(bad)),
               Contains("'window.teeth' must be a whole decimal number, is "));
  }
  for (const std::string bad : {"yes", "True", "on", "1", "'true'"}) {
    CHECK_THAT(pendulum_error(std::string("loud: ").append(bad)), Contains("'window.loud' must be true or false, is "));
  }
}

TEST_CASE("Ranges state value, unit and what is admissible") {
  CHECK(pendulum_error("period: 0") ==
        "a.yaml:4:11: 'window.period' is out of range: 0 s, admissible is [0.001, 10] s");
  CHECK(pendulum_error("length: 0") == "a.yaml:4:11: 'window.length' is out of range: 0 m, admissible is (0, 5] m");
  CHECK(pendulum_error("step_min: 1") == "a.yaml:4:13: 'window.step_min' is out of range: 1 s, admissible is [0, 1) s");
  CHECK(pendulum_error("teeth: 1") == "a.yaml:4:10: 'window.teeth' is out of range: 1, admissible is [2, 100]");
  CHECK(error_of("window: quartz\nmax_speed: -1\n") ==
        "a.yaml:3:12: 'max_speed' is out of range: -1 m/s, admissible is > 0 m/s");
}

TEST_CASE("Names are checked against their list") {
  CHECK(pendulum_error("swing: wde") ==
        "a.yaml:4:10: 'window.swing' must be one of small, wide, is 'wde' (did you mean 'wide'?)");
  CHECK(pendulum_error("uses: [map, mtch]") ==
        "a.yaml:4:15: 'window.uses.1' must be one of overlap, map, match, is 'mtch' (did you mean 'match'?)");
  CHECK(pendulum_error("uses: map") ==
        "a.yaml:4:9: 'window.uses' must be a list of names from overlap, map, match, is 'map'");
  CHECK(pendulum_error("window_size: 3") == "a.yaml:4:3: 'window.window_size' was removed: use frame_length");
}

TEST_CASE("Stages: missing, unknown and malformed ones name the types there are") {
  CHECK(error_of("note: x\n") == "a.yaml:1:1: 'window' is missing: name a type of clocks; there are pendulum, quartz");
  CHECK(error_of("window: {period: 1}\n") ==
        "a.yaml:2:9: 'window.type' is missing: name a type of clocks; there are pendulum, quartz");
  CHECK(error_of("window: pendlum\n") ==
        "a.yaml:2:9: 'window' names unknown type 'pendlum' of clocks (did you mean 'pendulum'?); there are pendulum, "
        "quartz");
  CHECK(error_of("window: {type: hourglass}\n") ==
        "a.yaml:2:16: 'window' names unknown type 'hourglass' of clocks; there are pendulum, quartz. One of a plugin "
        "needs "
        "--plugin FILE.so, or its folder in ASLIO_PLUGIN_PATH");
  CHECK(error_of("window:\n") ==
        "a.yaml:2:1: 'window' must be a type of clocks or a block with one, is empty; there are pendulum, quartz");
  CHECK(error_of("window: {type: [x]}\n") == "a.yaml:2:16: 'window.type' must be a name; there are pendulum, quartz");
  CHECK(error_of("window: quartz\nsamplers: quartz\n") ==
        "a.yaml:3:11: 'samplers' must be a list of clocks, as in [{type: ..}], is 'quartz'");
  CHECK(error_of("window: quartz\nframe: 3\n") == "a.yaml:3:8: 'frame' must be a block of keys, is '3'");
  CHECK(error_of("window: quartz\nboxes: [3]\n") == "a.yaml:3:9: 'boxes.0' must be a block of keys, is '3'");
  CHECK(error_of("window: quartz\nboxes: {}\n") == "a.yaml:3:8: 'boxes' must be a list of blocks, is a block of keys");
}

TEST_CASE("A nested stage may leave its type to the default") {
  const auto loaded = read("window: {type: pendulum, spring: {stiffness: 3}}\n");
  exec::Executor exec(1);
  const SensorModel sensor;
  CHECK(loaded.value.window.make({.exec = exec, .sensor = sensor, .log = nullptr})->tick() == 3.0);
}

TEST_CASE("Cross-checks wait until the block is without error") {
  CHECK(pendulum_error("step_min: 0.6") == "a.yaml:4:13: 'window.step_min' = 0.6 must not exceed step_max");
  CHECK(pendulum_error("step_max: 0.01") == "a.yaml:3:3: 'window.step_min' = 0.1 (default) must not exceed step_max");
  CHECK(error_of("window: {type: pendulum, step_max: 0.01, lod: true}\n") ==
        "a.yaml:2:42: unknown key 'window.lod' (did you mean 'loud'?)");
  CHECK(error_of("window: quartz\nframe: {label: forbidden}\nboxes: [{label: forbidden}]\n") ==
        "a.yaml:3:16: 'frame.label' = forbidden must be allowed\n"
        "a.yaml:4:17: 'boxes.0.label' = forbidden must be allowed");
}

TEST_CASE("Control characters of a file never reach the terminal") {
  const std::string text = error_of("window: quartz\n\"a\\e[31m\": 1\nmax_speed: \"\\e[31m\"\n");
  CHECK(text.find('\x1b') == std::string::npos);
  CHECK_THAT(text, Contains("unknown key 'a\\x1b[31m'") && Contains("is the quoted text '\\x1b[31m'"));
}

TEST_CASE("The resolved text states every key and reads back to itself") {
  const std::string text =
      "window: {type: pendulum, period: 0.30000000000000004, teeth: 7, spring: {stiffness: 1e-9}}\n"
      "samplers: [{type: quartz, frequency: 1e6}]\nnote: '010'\nboxes: [{label: \"x: #\"}]\n";
  const auto once = read(text);
  CHECK(once.resolved ==
        "schema: aslio/pipeline/1\nwindow:\n  type: pendulum\n  period: 0.30000000000000004\n  length: null\n"
        "  teeth: 7\n  step_min: 0.1\n  step_max: 0.5\n  loud: false\n  swing: small\n  uses: [map]\n  spring:\n"
        "    type: coil\n    stiffness: 1e-09\nsamplers:\n  - type: quartz\n    frequency: 1e+06\nframe:\n"
        "  centre: [0, 0, 0]\n  label: \"\"\nboxes:\n  - centre: [0, 0, 0]\n    label: \"x: #\"\nmax_speed: 30\n"
        "note: \"010\"\n");
  const plugin::Catalog catalog = make_catalog();
  const auto twice = config::parse<Workshop>(once.resolved, "resolved.yaml", config::FileKind::pipeline, catalog);
  CHECK(twice.resolved == once.resolved);
  CHECK(twice.plugin_types == once.plugin_types);
  exec::Executor exec(1);
  const SensorModel sensor;
  const BuildContext context{.exec = exec, .sensor = sensor, .log = nullptr};
  CHECK(twice.value.window.make(context)->tick() == once.value.window.make(context)->tick());
}

TEST_CASE("A tab that indents is called a tab, at its place") {
  for (const auto& [text, place] : std::vector<std::pair<std::string, std::string>>{
           {"schema: aslio/pipeline/1\nwindow:\n\ttype: quartz\n", "a.yaml:3:1"},
           {"schema: aslio/pipeline/1\nwindow:\n  \ttype: quartz\n", "a.yaml:3:3"}}) {
    CHECK_THROWS_WITH(parse_document(text, "a.yaml"), place + ": a tab indents this line: YAML takes spaces only");
  }
  CHECK_NOTHROW(parse_document("a: \"b\tc\"\n", "a.yaml"));
}

TEST_CASE("A file of an old name stands for the one that it names") {
  const std::filesystem::path folder = std::filesystem::path(ASLIO_BINARY_DIR) / "config_alias";
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "new.yaml") << "schema: aslio/pipeline/1\nwindow: quartz\n";
  std::ofstream(folder / "old.yaml") << "schema: aslio/pipeline/1\nalias: new.yaml\n";
  std::ofstream(folder / "older.yaml") << "schema: aslio/pipeline/1\nalias: old.yaml\n";
  std::ofstream(folder / "lost.yaml") << "schema: aslio/pipeline/1\nalias: gone.yaml\n";
  CHECK(follow_alias(folder / "new.yaml") == folder / "new.yaml");
  CHECK(follow_alias(folder / "old.yaml") == folder / "new.yaml");
  CHECK_THROWS_WITH(follow_alias(folder / "older.yaml"), Catch::Matchers::Contains("is an alias itself"));
  CHECK_THROWS_WITH(follow_alias(folder / "lost.yaml"), Catch::Matchers::Contains("gone.yaml"));
  std::filesystem::remove_all(folder);
}

TEST_CASE("Mutated files are read or refused, never worse") {
  const std::string valid =
      "schema: aslio/pipeline/1\nwindow:\n  type: pendulum\n  period: 0.1\n  uses: [map, match]\n  spring: {type: "
      "coil}\n"
      "samplers:\n  - {type: quartz, frequency: 1e3}\n  - pendulum\nboxes: [{centre: [1, 2, 3]}]\nnote: \"x\\ny\"\n";
  const std::string alphabet = std::string("{}[]:,-#&*!|>'\"%@`\n \t?<.0189eaz\\/\x80\xff") + '\0';
  const plugin::Catalog catalog = make_catalog();
  std::mt19937_64 random(20240607);
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random() % n); };
  int accepted = 0;
  int refused = 0;
  for (int round = 0; round < 20'000; ++round) {
    std::string text = valid;
    for (std::size_t n = 1 + below(4); n > 0; --n) {
      const std::size_t at = below(text.size());
      switch (below(4)) {
        case 0:
          text[at] = alphabet[below(alphabet.size())];
          break;
        case 1:
          text.insert(at, 1, alphabet[below(alphabet.size())]);
          break;
        case 2:
          text.erase(at, 1 + below(5));
          break;
        default:
          text.insert(at, valid.substr(below(valid.size()), 1 + below(20)));
          break;
      }
      if (text.empty()) text.push_back('a');
    }
    try {
      const auto loaded = config::parse<Workshop>(text, "a.yaml", config::FileKind::pipeline, catalog);
      ++accepted;
      const auto again = config::parse<Workshop>(loaded.resolved, "b.yaml", config::FileKind::pipeline, catalog);
      if (again.resolved != loaded.resolved)
        FAIL("resolved text of\n" << text << "\nis not stable:\n" << loaded.resolved);
    } catch (const ConfigError& error) {
      ++refused;
      if (std::string(error.what()).empty()) FAIL("no message for\n" << text);
    }
  }
  CHECK(accepted > 100);
  CHECK(refused > 1000);
}
