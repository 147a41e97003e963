#include "aslio/config/description.hpp"

#include <catch2/catch.hpp>

#include "aslio/config/diff.hpp"
#include "config/stages.hpp"

using namespace aslio;
using namespace aslio::test;
using Catch::Matchers::Contains;

TEST_CASE("A stage describes every key: type, unit, range, default, meaning") {
  CHECK(config::describe_stage(make_catalog(), "clocks", "pendulum") ==
        "clocks/pendulum: swings\nfrom: built-in\n"
        "\n  period: number, [0.001, 10] s, default 1\n      time of one swing\n"
        "\n  length: number or null, (0, 5] m, default null (from the period)\n      length of the rod\n"
        "\n  teeth: integer, [2, 100], default 30\n      teeth of the wheel\n"
        "\n  step_min: number, [0, 1) s, default 0.1\n      shortest step\n"
        "\n  step_max: number, >= 0 s, default 0.5\n      longest step\n"
        "\n  loud: true|false, default false\n      whether it can be heard\n"
        "\n  swing: one of small|wide, default small\n      how far it swings\n"
        "\n  uses: list of overlap|map|match, default [map]\n      where it acts\n"
        "\n  spring: stage of springs, default coil\n      what drives it\n      springs: coil, leaf\n"
        "\n  window_size: removed, use frame_length\n");
  CHECK(config::describe_stage(make_catalog(), "springs", "leaf") ==
        "springs/leaf: a bent plate\nfrom: built-in\nno parameters\n");
}

TEST_CASE("Blocks and lists of blocks are described inside their file") {
  Workshop workshop;
  const config::Description found = config::describe([&](config::Binder& b) { Workshop::describe(b, workshop); });
  std::vector<std::string> paths;
  for (const config::Field& field : found.fields) paths.push_back(field.path + ": " + field.type);
  CHECK(paths == std::vector<std::string>{"window: stage of clocks", "samplers: list of stages of clocks",
                                          "frame: block", "frame.centre: list of 3 numbers", "frame.label: text",
                                          "boxes: list of blocks", "boxes.N.centre: list of 3 numbers",
                                          "boxes.N.label: text", "max_speed: number", "note: text"});
  CHECK(found.fields[0].default_value == "required");
}

TEST_CASE("Describing what is not there names what is near") {
  const plugin::Catalog catalog = make_catalog();
  CHECK_THROWS_WITH(config::describe_stage(catalog, "clock", "quartz"),
                    "unknown stage family 'clock' (did you mean 'clocks'?); there are clocks, springs");
  CHECK_THROWS_WITH(config::describe_stage(catalog, "clocks", "quarz"),
                    "unknown type 'quarz' of clocks (did you mean 'quartz'?); there are pendulum, quartz");
}

TEST_CASE("The plugin reference lists every family and type") {
  plugin::Catalog catalog = make_catalog();
  catalog.declare("weights");
  const std::string text = config::plugin_reference(catalog);
  CHECK_THAT(text,
             Contains("\n## clocks\n\n### clocks/pendulum\n\nswings.\n\n| key | type | unit | range | default |"));
  CHECK_THAT(text, Contains("\n| `period` | number | s | [0.001, 10] s | 1 | time of one swing |\n"));
  CHECK_THAT(text, Contains("\n| `loud` | true\\|false |  |  | false | whether it can be heard |\n"));
  CHECK_THAT(text, Contains("\n### springs/leaf\n\na bent plate.\n\nNo parameters.\n"));
  CHECK_THAT(text, Contains("\n## weights\n\nNo member yet.\n"));
}

TEST_CASE("Two files that mean the same do not differ") {
  const auto a = read("window: {type: pendulum, period: 1.0, teeth: 30}\nmax_speed: 3e1\n");
  const auto b = read("# comment\nmax_speed: 30\nwindow: pendulum\n");
  CHECK(config::diff(a.resolved, b.resolved).empty());
}

TEST_CASE("Two pipelines that differ in two blocks differ in these alone") {
  const auto a = read(
      "window: {type: pendulum, period: 0.1, spring: {stiffness: 5}}\nsamplers: [pendulum, quartz]\nnote: same\n"
      "frame: {centre: [1, 2, 3]}\n");
  const auto b = read(
      "window: quartz\nsamplers: [{type: pendulum, uses: [map, match], spring: leaf}]\nnote: same\n"
      "frame: {centre: [1, 2, 4]}\nboxes: [{label: x}]\n");
  CHECK(config::to_text(config::diff(a.resolved, b.resolved)) ==
        "window: {type: pendulum, period: 0.1, length: null, teeth: 30, step_min: 0.1, step_max: 0.5, loud: false, "
        "swing: small, uses: [map], spring: {type: coil, stiffness: 5}} -> {type: quartz, frequency: 32768}\n"
        "samplers.0.uses: [map] -> [map, match]\n"
        "samplers.0.spring: {type: coil, stiffness: 2} -> {type: leaf}\n"
        "samplers.1: {type: quartz, frequency: 32768} (only in A)\n"
        "frame.centre: [1, 2, 3] -> [1, 2, 4]\n"
        "boxes.0: {centre: [0, 0, 0], label: x} (only in B)\n");
}
