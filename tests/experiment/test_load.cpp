/// Study files: what they stand for, and what is told of those that are wrong.

#include <algorithm>
#include <catch2/catch.hpp>

#include "study_files.hpp"

using namespace aslio::test;
using namespace aslio::experiment;
using Catch::Matchers::Contains;

namespace {

const std::string kData = "datasets: [{scene: scene_a.yaml, seeds: 1-2}]\n";

std::vector<std::string> names(const std::vector<StudyMethod>& methods) {
  std::vector<std::string> out;
  for (const StudyMethod& method : methods) out.push_back(method.name);
  return out;
}

}  // namespace

TEST_CASE("seeds are numbers and ranges, each once") {
  using Seeds = std::vector<std::uint64_t>;
  CHECK(parse_seeds("3") == Seeds{3});
  CHECK(parse_seeds("1-3,7") == Seeds{1, 2, 3, 7});
  CHECK(parse_seeds("18446744073709551615") == Seeds{18446744073709551615ULL});
  for (const char* wrong :
       {"", "a", "1-", "-1", "3-1", "1,,2", "1-2-3", "1,1", "1-3,2", "0-18446744073709551615", "1 2", "1-10001"}) {
    INFO(wrong);
    CHECK_FALSE(parse_seeds(wrong).has_value());
  }
}

TEST_CASE("a study file becomes data and methods with every default in place") {
  const StudyFiles files;
  const Study study =
      files.load(head() +
                 "datasets:\n"
                 "  - {scene: scene_a.yaml, seeds: '1-2,5'}\n"
                 "  - {scene: scene_b.yaml, name: other, set: [imu.preset=ideal]}\n"
                 "methods:\n" +
                 method("fixed", "fixed_window") +
                 method("slow", "fixed_window", "set: {window.period: 0.2, map: {type: voxel_plane, voxel: 1.5}}") +
                 "baseline: fixed\n");
  REQUIRE(study.data.size() == 4);
  CHECK(study.name == "study");
  CHECK(study.data[0].name == "scene_a_1");
  CHECK(study.data[2].name == "scene_a_5");
  CHECK(study.data[2].sequence == "scene_a");
  CHECK(study.data[3].name == "other_1");
  CHECK(study.data[3].set == std::vector<std::string>{"imu.preset=ideal"});
  CHECK(names(study.methods) == std::vector<std::string>{"fixed", "slow"});
  CHECK(study.methods[1].set == std::vector<std::string>{"window.period=0.2", "map={type: voxel_plane, voxel: 1.5}"});
  CHECK_THAT(study.methods[1].resolved, Contains("period: 0.2") && Contains("voxel: 1.5"));
  CHECK_FALSE(study.baseline[0].has_value());
  CHECK(study.baseline[1] == std::size_t{0});
  CHECK(study.order_seeds == std::vector<std::uint64_t>{0});
  CHECK(study.config.metrics == std::vector<std::string>{"ate_m", "ate_deg", "end_to_end_m"});
  CHECK(study.config.time_limit == 600);
}

TEST_CASE("seeds and scale of the command line replace those of the file, and make other data") {
  const StudyFiles files;
  const std::string text = head() + kData + "methods:\n" + method("fixed", "fixed_window");
  const Study plain = files.load(text);
  const Study other = files.load(text, {.resolve_scene = {}, .seeds = std::vector<std::uint64_t>{2, 9}, .scale = 0.5});
  REQUIRE(other.data.size() == 2);
  CHECK(other.data[0].name == "scene_a_2");
  CHECK(other.data[1].name == "scene_a_9");
  CHECK(other.data[0].scale == 0.5);
  CHECK(other.data[0].identity != plain.data[1].identity);
}

TEST_CASE("the seed stands for its placeholder in what a scene sets, and each recording is another scene") {
  const StudyFiles files;
  const std::string one = "methods:\n" + method("a", "fixed_window");
  const auto study = [&](const std::string& datasets) { return head() + "datasets: [" + datasets + "]\n" + one; };
  const std::string worlds = "{scene: scene_a.yaml, seeds: 31-32, set: ['world.seed={seed}', b=2], name: w}";
  const Study many = files.load(study(worlds));
  REQUIRE(many.data.size() == 2);
  CHECK(many.data[0].name == "w_31");
  CHECK(many.data[0].set == std::vector<std::string>{"world.seed=31", "b=2"});
  CHECK(many.data[1].set == std::vector<std::string>{"world.seed=32", "b=2"});
  // What is simulated is what counts: the same scene written out is the same recording.
  const Study written = files.load(study("{scene: scene_a.yaml, seeds: 31, set: [world.seed=31, b=2], name: w}"));
  CHECK(written.data[0].identity == many.data[0].identity);
  CHECK(many.data[0].identity != many.data[1].identity);
  StudyReading reading;
  reading.seeds = std::vector<std::uint64_t>{7};
  CHECK(files.load(study(worlds), reading).data[0].set[0] == "world.seed=7");
  // Entries of one name are one scene: both with the placeholder, or both without.
  CHECK(files.complaint(study(worlds + ", {scene: scene_a.yaml, seeds: 33, set: ['world.seed={seed}', b=2], name: w}"))
            .empty());
  CHECK_THAT(files.complaint(study(worlds + ", {scene: scene_a.yaml, seeds: 1, set: [world.seed=1, b=2], name: w}")),
             Contains("study.yaml:5:") && Contains("both are called 'w'"));
}

TEST_CASE("axes make a grid over all methods, the last axis fastest") {
  const StudyFiles files;
  const Study study = files.load(head() + kData + "methods:\n" + method("fixed", "fixed_window") +
                                 method("as_lio_plus", "as_lio_plus") +
                                 "vary:\n  - {path: overlap.voxel, values: [0.1, 0.2]}\n"
                                 "  - {path: estimator.noise, values: [fastlio, physical]}\n"
                                 "baseline: fixed\ndiffers: [window, history]\n");
  CHECK(names(study.methods) ==
        std::vector<std::string>{"fixed_voxel_0.1_noise_fastlio", "fixed_voxel_0.1_noise_physical",
                                 "fixed_voxel_0.2_noise_fastlio", "fixed_voxel_0.2_noise_physical",
                                 "as_lio_plus_voxel_0.1_noise_fastlio", "as_lio_plus_voxel_0.1_noise_physical",
                                 "as_lio_plus_voxel_0.2_noise_fastlio", "as_lio_plus_voxel_0.2_noise_physical"});
  CHECK(study.axes == std::vector<std::string>{"overlap.voxel", "estimator.noise"});
  CHECK(study.methods[6].axes == std::vector<std::string>{"0.2", "fastlio"});
  CHECK_THAT(study.methods[6].resolved, Contains("voxel: 0.2") && Contains("noise: fastlio"));
  // Each variant against the baseline at the same values.
  CHECK(study.baseline[6] == std::size_t{2});
  CHECK_FALSE(study.baseline[2].has_value());
}

TEST_CASE("an axis may belong to some methods only, and the others stand still") {
  const StudyFiles files;
  const std::string text = head() + kData + "methods:\n" + method("fixed", "fixed_window") +
                           method("as_lio_plus", "as_lio_plus") +
                           "baseline: fixed\ndiffers: [window, history]\nvary:\n";
  const Study study = files.load(text + "  - {path: overlap.voxel, values: [0.1, 0.2], methods: [as_lio_plus]}\n");
  CHECK(names(study.methods) == std::vector<std::string>{"fixed", "as_lio_plus_voxel_0.1", "as_lio_plus_voxel_0.2"});
  CHECK(study.methods[0].axes == std::vector<std::string>{"-"});
  CHECK(study.baseline[2] == std::size_t{0});
  CHECK_THAT(files.complaint(text + "  - {path: overlap.voxel, values: [0.1], methods: [as_lio_plsu]}\n"),
             Contains("'as_lio_plsu' is no method of the study"));
}

TEST_CASE("differs takes globs") {
  const StudyFiles files;
  const std::string text = head() + kData + "methods:\n" + method("fixed", "fixed_window") +
                           method("as_lio_plus", "as_lio_plus") + "baseline: fixed\ndiffers: ";
  CHECK_NOTHROW(files.load(text + "['win*', 'hist?ry']\n"));
  CHECK_THAT(files.complaint(text + "['win*']\n"), Contains("differs from the baseline") && Contains("history"));
  CHECK_THAT(files.complaint(text + "['win*', 'hist*', '*.frobnicate']\n"),
             Contains("'differs' names '*.frobnicate', which no pipeline of the study has"));
}

TEST_CASE("what is wrong in a study is told with its place and a remedy") {
  const StudyFiles files;
  const std::string one = "methods:\n" + method("fixed", "fixed_window");
  struct Case {
    std::string text;
    std::vector<std::string> expected;
  };
  const std::vector<Case> cases = {
      {"schema: aslio/study/1\nquestion: Which?\n",
       {"'prediction'", "'rule'", "'datasets'", "'methods'", "is required"}},
      {head() + kData + one + "baselin: fixed\n", {"study.yaml:8:1: unknown key 'baselin' (did you mean 'baseline'?)"}},
      {head() + "datasets: [{scene: scene_a.yaml, seeds: 3-1}]\n" + one,
       {"study.yaml:5:41", "'datasets.0.seeds' = \"3-1\""}},
      {head() + "datasets: [{scene: a.yaml, dataset: b.yaml}]\n" + one, {"study.yaml:5:20", "exclude each other"}},
      {head() + "datasets: [{dataset: b.yaml, set: [a=1]}]\n" + one, {"study.yaml:5:", "changes a scene"}},
      {head() + "datasets: [{scene: gone.yaml}]\n" + one, {"study.yaml:5:20", "gone.yaml: cannot be opened"}},
      {head() + "datasets: [{dataset: gone.yaml}]\n" + one, {"study.yaml:5:22", "gone.yaml: cannot be opened"}},
      {head() + "datasets: [{scene: scene_a.yaml}, {scene: scene_a.yaml}]\n" + one,
       {"study.yaml:5:35", "both make the data 'scene_a_1'", "another name"}},
      {head() + "datasets: [{scene: scene_a.yaml, name: ../x}]\n" + one, {"study.yaml:5:40", "'../x_1' is no name"}},
      {head() + kData + one + method("fixed", "as_lio_plus"),
       {"study.yaml:8:12", "'fixed' is the name of two methods"}},
      {head() + kData + "methods:\n" + method("a b", "as_lio_plus"), {"study.yaml:7:12", "'a b' is no name"}},
      {head() + kData + "methods: [{name: a, pipeline: gone.yaml}]\n",
       {"study.yaml:6:31", "gone.yaml: cannot be opened"}},
      {head() + kData + "methods:\n" + method("a", "as_lio_plus", "set: {window.perod: 1}"),
       {"study.yaml:7:", "method 'a'", "window.perod"}},
      {head() + kData + "methods:\n" + method("a", "as_lio_plus", "set: [1]"),
       {"study.yaml:7:", "must be a block of dotted paths"}},
      {head() + kData + one + "vary: [{path: overlap.voxel, values: []}]\n",
       {"study.yaml:8:", "must be a list of values"}},
      {head() + kData + one + "vary: [{path: overlap.voxel, values: [0.1, -1]}]\n",
       {"study.yaml:7:", "method 'fixed_voxel_-1'", "out of range"}},
      {head() + kData + one + "baseline: fixd\n", {"study.yaml:8:11", "'fixd'; there are: fixed"}},
      {head() + kData + one + "metrics: [ate]\n", {"study.yaml:8:11", "must be one of"}},
      {head() + kData + one + "order_seeds: [0, 0.5]\n", {"study.yaml:8:14", "must be whole numbers"}},
  };
  for (const Case& wrong : cases) {
    const std::string complaint = files.complaint(wrong.text);
    INFO(wrong.text << "\n" << complaint);
    CHECK_FALSE(complaint.empty());
    for (const std::string& part : wrong.expected) CHECK_THAT(complaint, Contains(part));
  }
}

TEST_CASE("a pattern of datasets is all that it matches, in order") {
  const StudyFiles files;
  const std::string one = "methods:\n" + method("a", "fixed_window");
  const auto text = [&](const std::string& entry) { return head() + "datasets: [{" + entry + "}]\n" + one; };
  std::filesystem::copy(std::filesystem::path(ASLIO_SOURCE_DIR) / "configs/sensors/livox_avia.yaml",
                        files.folder / "avia.yaml");
  write_text(files.folder / "points.bag", "none is read");
  for (const char* name : {"walk_2", "walk_1", "ride_1"}) {
    std::filesystem::create_directories(files.folder / "sets" / name);
    write_text(files.folder / "sets" / name / "dataset.yaml",
               "schema: aslio/dataset/1\ninput: ../../points.bag\nsensor: ../../avia.yaml\n");
  }
  const Study study = files.load(text("dataset: 'sets/walk_*'"));
  REQUIRE(study.data.size() == 2);
  CHECK(study.data[0].name == "walk_1");
  CHECK(study.data[1].name == "walk_2");
  CHECK(files.load(text("dataset: 'sets/[rw]*/dataset.yaml'")).data.size() == 3);
  CHECK(files.load(text("dataset: 'sets/r*', name: ride")).data[0].name == "ride");
  CHECK_THAT(files.complaint(text("dataset: 'sets/run_*'")),
             Contains("study.yaml:5:") && Contains("'sets/run_*' matches nothing: give a pattern of dataset files"));
  CHECK_THAT(
      files.complaint(text("dataset: 'sets/walk_*', name: w")),
      Contains("study.yaml:5:") && Contains("'w' would be the name of 2 recordings") && Contains("leave it out"));
}

TEST_CASE("names that would mix what belongs apart are refused") {
  const StudyFiles files;
  const std::string orders = head() + kData + "order_seeds: [0, 1]\nmethods:\n" + method("a", "fixed_window");
  CHECK_THAT(files.complaint(orders + method("a_order_1", "as_lio_plus")),
             Contains("study.yaml:9:12") && Contains("'a_order_1' with order seed 0 and 'a' with order seed 1") &&
                 Contains("folder 'a_order_1': name one of them otherwise"));
  CHECK(files.complaint(orders + method("a_order_2", "as_lio_plus")).empty());
  const std::string one = "methods:\n" + method("a", "fixed_window");
  const auto data = [&](const std::string& first, const std::string& second) {
    return head() + "datasets: [{scene: scene_a.yaml, name: s}, {" + first + ", seeds: 2, name: s" + second + "}]\n" +
           one;
  };
  for (const std::string& other : {data("scene: scene_b.yaml", ""), data("scene: scene_a.yaml", ", set: [a=1]")}) {
    CHECK_THAT(files.complaint(other), Contains("study.yaml:5:") && Contains("differ in more than the seed") &&
                                           Contains("both are called 's': give one of them another name"));
  }
  CHECK(files.complaint(data("scene: scene_a.yaml", "")).empty());
}

TEST_CASE("stages that do not fit each other, or a schedule that is not there, are told before anything runs") {
  const StudyFiles files;
  const auto complaint = [&](const std::string& set) {
    return files.complaint(head() + kData + "methods:\n" + method("a", "as_lio_plus") +
                           method("b", "as_lio_plus", "set: {" + set + "}"));
  };
  struct Case {
    std::string set;
    std::vector<std::string> expected;
  };
  const std::vector<Case> cases = {
      {"map: {type: ikd_tree}", {"--set map={type: ikd_tree}: map: 'ikd_tree' holds points", "planes to 'neighbours'"}},
      {"estimator.residual.planes: neighbours", {"as_lio_plus.yaml:", "map: 'staggered_planes' holds surfaces"}},
      {"insertion: cell_nearest", {"--set insertion=cell_nearest: insertion: 'cell_nearest'", "on_exit"}},
      {"window: {type: replay, file: gone.csv}", {"window: gone.csv: cannot open the schedule"}}};
  for (const Case& wrong : cases) {
    const std::string told = complaint(wrong.set);
    INFO(wrong.set << "\n" << told);
    CHECK_THAT(told, Contains("study.yaml:8:") && Contains("method 'b'"));
    for (const std::string& part : wrong.expected) CHECK_THAT(told, Contains(part));
  }
  // What a run of the study writes is not there yet; the rest is checked all the same.
  CHECK(complaint("window: {type: replay, file: '{run:a}/updates.csv'}").empty());
  CHECK(complaint("window: {type: replay, file: '{data}/oracle.csv'}").empty());
  CHECK_THAT(complaint("window: {type: replay, file: '{run:a}/updates.csv'}, map: {type: ikd_tree}"),
             Contains("'ikd_tree' holds points"));
}

TEST_CASE("an error of several lines in a file that is named stays one line each") {
  const StudyFiles files;
  const std::string complaint = files.complaint(head() + kData + "methods:\n" +
                                                method("a", "as_lio_plus", "set: {window.perod: 1, map.voxl: 2}"));
  INFO(complaint);
  CHECK_THAT(complaint, Contains("voxl") && Contains("perod") && !Contains("\\x0a"));
  CHECK(std::count(complaint.begin(), complaint.end(), '\n') == 1);
}

TEST_CASE("a placeholder names a method that stands before it") {
  const StudyFiles files;
  const std::string replay =
      method("shifted", "as_lio_plus", "set: {window: {type: replay, file: '{run:as_lio_plus}/updates.csv'}}");
  const std::string good = head() + kData + "methods:\n" + method("as_lio_plus", "as_lio_plus") + replay;
  const Study study = files.load(good);
  REQUIRE(study.methods[1].uses.size() == 1);
  CHECK(study.methods[1].uses[0] == std::pair<std::string, std::size_t>("as_lio_plus", 0));
  // With axes, the run at the same values is meant.
  const Study varied = files.load(good + "vary: [{path: overlap.voxel, values: [0.1, 0.2]}]\n");
  CHECK(varied.methods[3].uses[0].second == 1);
  CHECK_THAT(
      files.complaint(head() + kData + "methods:\n" + replay + method("as_lio_plus", "as_lio_plus")),
      Contains("study.yaml:7:") && Contains("{run:as_lio_plus}: no method of that name stands before 'shifted'"));
}

TEST_CASE("an axis is a path with values, paths in step, or a list of named points") {
  const StudyFiles files;
  const Study study = files.load(head() + kData + "methods:\n" + method("fixed", "fixed_window") +
                                 "vary:\n"
                                 "  - {path: window.period, values: [0.1, 0.05]}\n"
                                 "  - {zip: {map.voxel: [0.5, 1], overlap.voxel: [0.1, 0.2]}}\n"
                                 "  - {list: [{name: plain, set: {estimator.noise: physical}},\n"
                                 "            {name: short, set: {window.period: 0.02, estimator.noise: fastlio}}],\n"
                                 "     name: kind}\n");
  CHECK(study.axes == std::vector<std::string>{"window.period", "map.voxel", "overlap.voxel", "kind"});
  REQUIRE(study.methods.size() == 8);
  CHECK(study.methods[0].name == "fixed_period_0.1_voxel_0.5_voxel_0.1_plain");
  CHECK(study.methods[7].axes == std::vector<std::string>{"0.05", "1", "0.2", "short"});
  CHECK(study.methods[7].set == std::vector<std::string>{"window.period=0.05", "map.voxel=1", "overlap.voxel=0.2",
                                                         "window.period=0.02", "estimator.noise=fastlio"});
  const std::string one = head() + kData + "methods:\n" + method("fixed", "fixed_window");
  for (const char* wrong :
       {"vary: [{zip: {map.voxel: [0.5, 1], overlap.voxel: [0.1]}}]\n", "vary: [{zip: {map.voxel: 1}}]\n",
        "vary: [{list: [{name: a}]}]\n", "vary: [{list: [{name: a/b, set: {map.voxel: 1}}]}]\n", "vary: [{}]\n",
        "vary: [{path: map.voxel, values: [1], zip: {map.voxel: [1]}}]\n", "vary: [{list: [], name: a}]\n"}) {
    INFO(wrong);
    CHECK_THAT(files.complaint(one + wrong), Contains("study.yaml:8:"));
  }
}

TEST_CASE("a comparison may differ in what the study names, and in nothing else") {
  const StudyFiles files;
  const std::string fixed = head() + kData + "baseline: fixed\nmethods:\n" + method("fixed", "fixed_window");
  // By `set`, of the same pipeline: named by itself.
  CHECK(files.complaint(fixed + method("slow", "fixed_window", "set: {window.period: 0.2}")).empty());
  // By another pipeline file, whether nothing or not all of it is stated: refused, with the line that says it.
  for (const char* stated : {"", "differs: [window]"}) {
    const std::string complaint = files.complaint(fixed + method("other", "as_lio_plus", stated));
    INFO(complaint);
    CHECK_THAT(complaint, Contains("study.yaml:9:") && Contains("'other' differs from the baseline 'fixed'") &&
                              Contains("or say so: differs: [") && Contains("history"));
    CHECK((complaint.find("window") == std::string::npos) == (*stated != '\0'));
  }
  // A key inside a block does not name the other type of the block; the block and its type do.
  CHECK_THAT(
      files.complaint(fixed + method("other", "as_lio_plus", "set: {window.seg_step: 0.05}, differs: [history]")),
      Contains("or say so: differs: [window]"));
  CHECK_THAT(files.complaint(fixed + method("other", "as_lio_plus", "differs: [window.seg_step, history.type]")),
             Contains("or say so: differs: [window]"));
  CHECK(files.complaint(fixed + method("other", "as_lio_plus", "differs: [window.type, history.type]")).empty());
  // Stated in full, by the method or for all of them.
  const std::string all = "differs: [window, history]";
  const Study stated = files.load(fixed + method("other", "as_lio_plus", all));
  CHECK(unnamed_keys(stated.methods[1], stated.methods[0]).empty());
  CHECK(files.complaint(fixed + method("other", "as_lio_plus") + all + "\n").empty());
}

TEST_CASE("differs names keys and blocks that there are") {
  const StudyFiles files;
  const std::string fixed = head() + kData + "baseline: fixed\nmethods:\n" + method("fixed", "fixed_window");
  const std::string study =
      files.complaint(fixed + method("other", "as_lio_plus") + "differs: [window, histry, bogus.key]\n");
  INFO(study);
  CHECK_THAT(study, Contains("study.yaml:10:19: 'differs' names 'histry'") && Contains("(did you mean 'history'?)") &&
                        Contains("study.yaml:10:27: 'differs' names 'bogus.key'") && Contains("give a key or a block"));
  // What it was meant to excuse is told with it.
  CHECK_THAT(study, Contains("or say so: differs: [history]"));
  const std::string one =
      files.complaint(fixed + method("other", "as_lio_plus", "differs: [window, history, map.voxl]"));
  INFO(one);
  CHECK_THAT(one, Contains("study.yaml:9:") && Contains("'map.voxl'") && Contains("(did you mean 'map.voxel'?)"));
  // Keys of either pipeline, elements of lists and what is in them.
  for (const char* there :
       {"window.seg_step", "window.period", "samplers", "samplers.1", "samplers.1.leaf", "map.type"}) {
    CHECK(
        files
            .complaint(fixed + method("other", "as_lio_plus", std::string("differs: [window, history, ") + there + "]"))
            .empty());
  }
  CHECK_THAT(files.complaint(fixed + method("other", "as_lio_plus", "differs: [window, history, samplers.9]")),
             Contains("'samplers.9'"));
}

TEST_CASE("a method may have a baseline of its own") {
  const StudyFiles files;
  const std::string start = head() + kData + "baseline: fixed\nmethods:\n" + method("fixed", "fixed_window") +
                            method("as_lio_plus", "as_lio_plus", "differs: [window, history]");
  const std::string own = method("hard", "as_lio_plus", "set: {window.seg_step: 0.2}, baseline: as_lio_plus");
  const Study study = files.load(start + own);
  CHECK(study.baseline == std::vector<std::optional<std::size_t>>{std::nullopt, 0, 1});
  const Study varied = files.load(start + own + "vary: [{path: overlap.voxel, values: [0.1, 0.2]}]\n");
  CHECK(varied.baseline[5] == 3);  // at the same values
  CHECK_THAT(files.complaint(start + method("hard", "as_lio_plus", "set: {window.seg_step: 0.2}, baseline: aslio")),
             Contains("study.yaml:10:") && Contains("'baseline' names no method: 'aslio'"));
}
