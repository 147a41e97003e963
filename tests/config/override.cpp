#include "aslio/config/override.hpp"

#include <catch2/catch.hpp>

#include "aslio/config/document.hpp"
#include "config/stages.hpp"

using namespace aslio;
using namespace aslio::test;
using config::Override;

namespace {

/// The file after the overrides, on one line.
std::string after(const std::string& text, const Sets& overrides) {
  try {
    return to_line(config::apply_overrides(config::parse_document(text, "a.yaml"), overrides));
  } catch (const ConfigError& error) {
    return error.what();
  }
}

}  // namespace

TEST_CASE("Overrides replace, add and append") {
  CHECK(after("a: {b: 1, c: 2}", {{"a.b=5"}}) == "{a: {b: 5, c: 2}}");
  CHECK(after("a: {b: 1}", {{"a.d=[1, 2]"}, {"e.f.g=x=y"}}) == "{a: {b: 1, d: [1, 2]}, e: {f: {g: \"x=y\"}}}");
  CHECK(after("a: [1, {b: 2}]", {{"a.1.b=3"}, {"a.2={c: 4}"}, {"a.0=null"}}) == "{a: [null, {b: 3}, {c: 4}]}");
  CHECK(after("a: 1", {{"b.0=3"}, {"b.1=4"}}) == "{a: 1, b: [3, 4]}");
  CHECK(after("a: 1", {{"a=2"}, {"a=3"}}) == "{a: 3}");
}

TEST_CASE("A new type drops the keys of the old one, a block replaces a block") {
  CHECK(after("w: {type: x, period: 1, n: {m: 2}}", {{"w.type=y"}, {"w.k=3"}}) == "{w: {type: y, k: 3}}");
  CHECK(after("w: x", {{"w.type=y"}}) == "{w: {type: y}}");
  CHECK(after("w: x", {{"w.period=2"}}) == "{w: {type: x, period: 2}}");
  CHECK(after("w: {type: x, period: 1}", {{"w={type: fixed, period: 0.05}"}}) == "{w: {type: fixed, period: 0.05}}");
}

TEST_CASE("An override that a later one would undo is an error") {
  CHECK(after("w: {type: x}", {{"w.period=1"}, {"w.type=y"}}) ==
        "--set w.period=1: would be undone by the later --set w.type=y: put it behind that");
  CHECK(after("w: {type: x}", {{"w.n.m=1"}, {"w={type: y}"}}) ==
        "--set w.n.m=1: would be undone by the later --set w={type: y}: put it behind that");
}

TEST_CASE("Malformed overrides say how to write one") {
  CHECK(after("a: 1", {{"a"}}) == "--set a: must be KEY=VALUE, as in window.period=0.05");
  const std::string empty_part = ": the key has an empty part: write KEY=VALUE, as in window.period=0.05";
  CHECK(after("a: 1", {{"=1"}}) == "--set =1" + empty_part);
  CHECK(after("a: 1", {{"a..b=1"}}) == "--set a..b=1" + empty_part);
  CHECK(after("a: 1", {{"a.=1"}}) == "--set a.=1" + empty_part);
  CHECK(after("a: 1", {{"a= "}}) == "--set a= : has no value: write null to unset a key");
  CHECK(after("a: 1", {{"a=[1"}}) == "--set a=[1: not valid YAML: end of sequence flow not found");
  CHECK(after("a: 1", {{"a={b: 1, b: 2}"}}) == "--set a={b: 1, b: 2}: duplicate key 'b': remove one of them");
  CHECK(after("a: 1", {{"schema=x"}}) == "--set schema=x: the schema says what the file is and cannot be set");
  CHECK(after("a: [1, 2]", {{"a.3=1"}}) ==
        "--set a.3=1: 'a' has 2 elements: the index must be at most 2 (which appends one)");
  CHECK(after("a: [1, 2]", {{"a.b=1"}}) == "--set a.b=1: 'a' is a list: give an index, as in a.0");
}

TEST_CASE("What an override names must exist among the keys") {
  CHECK(error_of("window: pendulum\n", {{"window.step_mn=3"}}) ==
        "--set window.step_mn=3: unknown key 'window.step_mn' (did you mean 'step_min'?)");
  CHECK(error_of("window: pendulum\n", {{"windw.period=3"}}) ==
        "--set windw.period=3: unknown key 'windw' (did you mean 'window'?)");
  CHECK(error_of("window: pendulum\n", {{"window.period=x"}}) ==
        "--set window.period=x: 'window.period' must be a finite decimal number [s], is 'x'");
  CHECK(error_of("window: quartz\n", {{"max_speed.x=3"}}) ==
        "--set max_speed.x=3: 'max_speed' must be a finite decimal number [m/s], is a block of keys");
}

TEST_CASE("Overrides act as if the file said so") {
  const auto loaded = read("window: pendulum\nsamplers: [quartz]\n",
                           {{"window.period=0.5"}, {"samplers.0.frequency=2"}, {"samplers.1={type: quartz}"}});
  const auto written =
      read("window: {type: pendulum, period: 0.5}\nsamplers: [{type: quartz, frequency: 2}, {type: quartz}]\n");
  CHECK(loaded.resolved == written.resolved);
}
