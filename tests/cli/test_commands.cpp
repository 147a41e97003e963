#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "fixture.hpp"

using namespace aslio::test;
using Catch::Matchers::Contains;

TEST_CASE("every command has help with an example") {
  for (const char* command : {"run", "simulate", "list", "describe", "check", "diff", "inspect", "evaluate", "datasets",
                              "calibrate", "overlap", "version"}) {
    const Ended ended = run_aslio({command, "--help"});
    INFO(command);
    CHECK(ended.code == 0);
    CHECK_THAT(ended.out, Contains("Example:") && Contains(std::string("aslio ") + command));
  }
}

TEST_CASE("the version is a command and an option") {
  const Ended command = run_aslio({"version"});
  CHECK(command.code == 0);
  CHECK_THAT(command.out, Catch::Matchers::StartsWith("aslio ") && Contains(" ("));
  for (const char* option : {"--version", "-V"}) {
    const Ended ended = run_aslio({option});
    CHECK(ended.code == 0);
    CHECK(ended.out == command.out);
    CHECK(ended.err.empty());
  }
}

TEST_CASE("list names families and their members") {
  const Ended all = run_aslio({"list"});
  CHECK(all.code == 0);
  CHECK_THAT(all.out,
             Contains("windows\n") && Contains("sod_adaptive") && Contains("estimators\n") && Contains("ieskf"));
  const Ended one = run_aslio({"list", "windows"});
  CHECK_THAT(one.out, Contains("fixed") && !Contains("ieskf"));
  const Ended none = run_aslio({"list", "windws"});
  CHECK(none.code == 2);
  CHECK_THAT(none.err, Contains("unknown family 'windws'") && Contains("windows"));
}

TEST_CASE("check tells everything that is wrong with every file") {
  const TemporaryFolder folder;
  write_text(folder / "good.yaml", pipeline_text());
  write_text(folder / "sensor.yaml", sensor_text());
  const Ended good = run_aslio({"check", folder / "good.yaml", folder / "sensor.yaml"});
  INFO(good.err);
  CHECK(good.code == 0);
  CHECK_THAT(good.out, Contains("good.yaml: ok (pipeline)") && Contains("sensor.yaml: ok (sensor)"));
  write_text(folder / "bad.yaml", pipeline_text("max_sped: 1\n"));
  write_text(folder / "worse.yaml", sensor_text("acc_unit: furlong\nmin_range: -1\n"));
  const Ended bad = run_aslio({"check", folder / "bad.yaml", folder / "good.yaml", folder / "worse.yaml"});
  CHECK(bad.code == 2);
  CHECK_THAT(bad.out, Contains("good.yaml: ok"));
  CHECK_THAT(bad.err, Contains("max_sped") && Contains("furlong") && Contains("min_range"));
  write_text(folder / "what.yaml", "window: fixed\n");
  CHECK(run_aslio({"check", folder / "what.yaml"}).code == 2);
  CHECK(run_aslio({"check", folder / "missing.yaml"}).code == 2);
}

TEST_CASE("check reports what a study names wrongly behind a key that is wrong") {
  const TemporaryFolder folder;
  write_text(folder / "study.yaml",
             "schema: aslio/study/1\nquestion: q\nprediction: p\nrule: r\ndatasets: [{scene: gone_scene.yaml}]\n"
             "methods: [{name: m, pipeline: gone_pipeline.yaml}]\njobss: 3\n");
  const Ended ended = run_aslio({"check", folder / "study.yaml"});
  CHECK(ended.code == 2);
  CHECK_THAT(ended.err, Contains("study.yaml:7:1: unknown key 'jobss'") && Contains("gone_scene.yaml") &&
                            Contains("gone_pipeline.yaml"));
}

TEST_CASE("check tells what a scene names and is not there, and goes on to the next file") {
  const TemporaryFolder folder;
  const std::string head = "schema: aslio/scene/1\n";
  write_text(folder / "follows.yaml", head + "follow: {file: gone.tum}\n");
  write_text(folder / "mesh.yaml", head + "world: {type: mesh, file: gone.ply}\nroute: [{x: 0, y: 0}, {x: 9, y: 0}]\n");
  write_text(folder / "study.yaml",
             "schema: aslio/study/1\nquestion: q\nprediction: p\nrule: r\ndatasets: [{scene: follows.yaml}, "
             "{scene: mesh.yaml}]\nmethods: [{name: m, pipeline: gone.yaml}]\n");
  const Ended ended =
      run_aslio({"check", folder / "follows.yaml", folder / "mesh.yaml", folder / "study.yaml", "none.yaml"});
  INFO(ended.err);
  CHECK(ended.code == 2);
  CHECK_THAT(ended.err, Contains("follows.yaml:2:") && Contains("gone.tum") && Contains("mesh.yaml:2:") &&
                            Contains("gone.ply") && Contains("study.yaml:5:") && Contains("gone.yaml") &&
                            Contains("none.yaml"));
}

TEST_CASE("check builds the stages of a pipeline, and names file, line, key and remedy of what does not fit") {
  const TemporaryFolder folder;
  const std::string surfaces = "map: {type: voxel_plane}\n", planes = "estimator.residual.planes to 'map'";
  struct Case {
    std::string text;
    std::vector<std::string> expected;
  };
  const std::string head =
      "schema: aslio/pipeline/1\nwindow: {type: fixed}\noverlap: {type: soft_voxel}\n"
      "history: none\nsamplers: [{type: range}]\ninsertion: on_new\n";
  const std::string points = "map: {type: ikd_tree}\nestimator: ieskf\n";
  const auto with = [&](std::string text, const std::string& part, const std::string& other) {
    return text.replace(text.find(part), part.size(), other);
  };
  const std::string replay = "{type: replay, file: " + (folder / "gone.csv").string() + "}";
  const std::string schedule = "{type: replay, file: " + (folder / "torn.csv").string() + "}";
  const std::vector<Case> cases = {
      {head + surfaces + "estimator: ieskf\n", {":7:6: map: 'voxel_plane' holds surfaces", planes}},
      {head + "map: voxel_hash\nestimator: {type: ieskf, residual: {type: point_to_plane, planes: map}}\n",
       {":7:6: map: 'voxel_hash' holds points", "estimator.residual.planes to 'neighbours'"}},
      {with(head, "on_new", "min_distance") + surfaces +
           "estimator: {type: ieskf, residual: {type: point_to_plane, planes: map}}\n",
       {":6:12: insertion: 'min_distance'", "'voxel_plane' holds surfaces", "choose another insertion"}},
      {with(head, "history: none", "history: balanced") + "map: voxel_hash\nestimator: pointwise_eskf\n",
       {":4:10: history: 'balanced' gives points of earlier updates", "'pointwise_eskf' takes none", "{type: none}"}},
      {with(head, "history: none", "history: full") + "map: voxel_hash\nestimator: smoother\n",
       {":4:10: history: 'full' gives points", "'smoother' takes none"}},
      {with(head, "{type: fixed}", "{type: imu_rate, emit: cuts}") + points,
       {":2:9: window: 'imu_rate' names parts", "'ieskf' does not use them", "emit: updates"}},
      {with(head, "{type: fixed}", "{type: motion_rate}") + "map: voxel_hash\nestimator: icp\n",
       {":2:9: window: 'motion_rate' decides by IMU data", "'icp' uses none", "choose another window"}},
      {head + "map: {type: feature_maps}\nestimator: scan_matcher\n",
       {":5:11: samplers: none of them finds edges and planes", "'scan_matcher'", "curvature_features"}},
      {with(head, "{type: range}", "{type: range}, {type: voxel, of: plane}, {type: curvature_features}") + points,
       {":5:27: samplers.1: 'voxel' picks points by their class", "{type: curvature_features} before it"}},
      {with(head, "{type: fixed}", replay) + points,
       {":2:9: window: ", "gone.csv: cannot open the schedule", "name the updates.csv of a run"}},
      {with(head, "{type: fixed}", schedule) + points, {":2:9: window: ", "torn.csv:3: t_ns 'x' is not a time"}}};
  write_text(folder / "torn.csv", "t_ns\n5\nx\n");
  write_text(folder / "good.yaml", head + points);
  CHECK(run_aslio({"check", folder / "good.yaml"}).code == 0);
  for (const Case& wrong : cases) {
    write_text(folder / "wrong.yaml", wrong.text);
    const Ended ended = run_aslio({"check", folder / "wrong.yaml"});
    INFO(wrong.text);
    CHECK(ended.code == 2);
    CHECK(ended.out.empty());
    CHECK_THAT(ended.err, Contains("wrong.yaml"));
    for (const std::string& part : wrong.expected) CHECK_THAT(ended.err, Contains(part));
  }
}

TEST_CASE("diff tells what differs in meaning, not in spelling") {
  const TemporaryFolder folder;
  write_text(folder / "a.yaml", pipeline_text());
  write_text(folder / "b.yaml", "# the same, with a default spelled out\n" + pipeline_text("max_speed: 60.0\n"));
  const Ended same = run_aslio({"diff", folder / "a.yaml", folder / "b.yaml"});
  INFO(same.err);
  CHECK(same.code == 0);
  CHECK_THAT(same.out, Contains("no difference"));
  write_text(folder / "c.yaml", pipeline_text("max_speed: 20\n"));
  const Ended other = run_aslio({"diff", folder / "a.yaml", folder / "c.yaml"});
  CHECK(other.code == 0);
  CHECK_THAT(other.out, Contains("max_speed") && Contains("60") && Contains("20") && !Contains("period"));
}

TEST_CASE("inspect tells topics, units and point times, and exits with 3 when unusable") {
  const TemporaryFolder folder;
  write_bag(folder / "good.bag", Recording{.duration = 1.5});
  const Ended good = run_aslio({"inspect", folder / "good.bag"});
  INFO(good.err);
  CHECK(good.code == 0);
  CHECK_THAT(good.out, Contains("/livox/lidar") && Contains("/livox/imu") && Contains("CustomMsg") && Contains("200"));
  write_bag(folder / "no_imu.bag", Recording{.duration = 0.5, .imu = false});
  const Ended bad = run_aslio({"inspect", folder / "no_imu.bag"});
  CHECK(bad.code == 3);
  CHECK_THAT(bad.err, Contains("unusable") && Contains("IMU"));
}

TEST_CASE("evaluate measures a trajectory against a reference") {
  const TemporaryFolder folder;
  write_truth(folder / "truth.tum");
  const Ended text = run_aslio({"evaluate", folder / "truth.tum", "--reference", folder / "truth.tum"});
  INFO(text.err);
  CHECK(text.code == 0);
  CHECK_THAT(text.out, Contains("absolute error") && Contains("relative error"));
  const Ended json = run_aslio({"evaluate", folder / "truth.tum", "--reference", folder / "truth.tum", "--json"});
  CHECK(json.code == 0);
  CHECK(json.out.front() == '{');
  CHECK_THAT(text.out, Contains("alignment se3\n"));
  write_text(folder / "broken.tum", "1.0 2 3\n");
  const Ended broken = run_aslio({"evaluate", folder / "broken.tum", "--reference", folder / "truth.tum"});
  CHECK(broken.code == 3);
  CHECK_THAT(broken.err, Contains("broken.tum:1"));
}

TEST_CASE("evaluate takes the alignment that is asked for, and names it") {
  const TemporaryFolder folder;
  std::string line, shifted;  // straight ahead, and the same a metre aside
  for (int i = 0; i <= 100; ++i) {
    const std::string t = std::to_string(100 + 0.1 * i), x = std::to_string(0.1 * i);
    line += t + " " + x + " 0 0 0 0 0 1\n";
    shifted += t + " " + x + " 1 0 0 0 0 1\n";
  }
  write_text(folder / "line.tum", line);
  write_text(folder / "shifted.tum", shifted);
  const auto evaluate = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"evaluate", folder / "shifted.tum", "--reference", folder / "line.tum"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_aslio(arguments);
  };
  const Ended open = evaluate({});
  CHECK(open.code == 3);
  CHECK_THAT(
      open.err,
      Contains("leaves the rotation open; use a longer trajectory, or `aslio evaluate --alignment yaw` or none"));
  for (const auto& [alignment, ate_m] : {std::pair("yaw", 0.0), std::pair("none", 1.0)}) {
    const Ended ended = evaluate({"--alignment", alignment, "--json"});
    INFO(ended.err);
    REQUIRE(ended.code == 0);
    const auto json = nlohmann::json::parse(ended.out);
    CHECK(json.at("alignment") == alignment);
    CHECK(json.at("ate_m").get<double>() == Approx(ate_m).margin(1e-9));
    CHECK_THAT(evaluate({"--alignment", alignment}).out, Contains(std::string("alignment ") + alignment + "\n"));
  }
  const Ended wrong = evaluate({"--alignment", "yaww"});
  CHECK(wrong.code == 2);
  CHECK_THAT(wrong.err, Contains("unknown alignment 'yaww' (did you mean 'yaw'?); there are: se3, yaw, none"));
}
