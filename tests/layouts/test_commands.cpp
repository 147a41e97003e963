/// `aslio simulate` with --format and --as, as a user calls it.
#include <catch2/catch.hpp>

#include "aslio/config/load.hpp"
#include "aslio/experiment/dataset.hpp"
#include "cli/child.hpp"
#include "layouts/written.hpp"

using namespace aslio;
using namespace aslio::test;
using Catch::Matchers::Contains;

namespace {

namespace fs = std::filesystem;

struct Room {
  TemporaryFolder folder;
  Room() {
    folder.write("room.obj", simulator::test::kRoomObj);
    folder.write("walk.yaml", simulator::test::room_scene("imu: {preset: ideal, rate: 100}\nlidar: {columns: 400}\n"));
  }
  fs::path operator/(const std::string& name) const { return folder / name; }
  Ended simulate(const std::string& output, const std::vector<std::string>& more) const {
    std::vector<std::string> all = {"simulate", folder / "walk.yaml", "--output", folder / output, "--duration",
                                    "1",        "--threads",          "1"};
    all.insert(all.end(), more.begin(), more.end());
    return run_aslio(all);
  }
};

}  // namespace

TEST_CASE("stand-ins: every format of a recording is a dataset with the same measurements") {
  const Room room;
  std::string first;
  const std::vector<std::tuple<std::string, std::string, std::string>> all = {{"bag", "1", "walk.bag"},
                                                                              {"bag", "3", "walk"},
                                                                              {"db3", "1", "walk"},
                                                                              {"mcap", "1", "walk.mcap"},
                                                                              {"mcap", "2", "walk"}};
  for (const auto& [format, parts, input] : all) {
    CAPTURE(format, parts);
    const std::string output = "out_" + format + parts;
    const Ended ended = room.simulate(output, {"--sensor", "avia", "--format", format, "--parts", parts});
    INFO(ended.err);
    REQUIRE(ended.code == 0);
    CHECK_THAT(ended.out, Contains(input) && Contains("SHA-256"));
    const experiment::Dataset dataset = experiment::load_dataset(room / (output + "/dataset.yaml"));
    CHECK_THAT(text_of(room / (output + "/dataset.yaml")), Contains("input: \"" + input + "\""));
    const auto sensor =
        config::load<io::SensorConfig>(dataset.sensor, config::FileKind::sensor, built_in_stages()).value;
    const std::string now = digest(read({room / (output + "/" + input)}, sensor));
    if (first.empty()) first = now;
    CHECK(now == first);
  }
}

TEST_CASE("stand-ins: fewer parts than before leave none of the earlier ones") {
  const Room room;
  for (const char* parts : {"4", "2"}) {
    REQUIRE(room.simulate("out", {"--sensor", "avia", "--format", "db3", "--parts", parts}).code == 0);
  }
  CHECK(names_below(room / "out/walk") == std::vector<std::string>{"metadata.yaml", "walk_0.db3", "walk_1.db3"});
}

TEST_CASE("stand-ins: a stand-in is refused where it could be taken for something else") {
  const Room room;
  const Ended nothing = room.simulate("out", {"--as", "newer_college_2021"});
  CHECK(nothing.code == 2);
  CHECK_THAT(nothing.err, Contains("FAMILY/SEQUENCE"));
  const Ended unknown = room.simulate("out", {"--as", "newer_college_2021/quad_eazy"});
  CHECK(unknown.code == 2);
  CHECK_THAT(unknown.err, Contains("quad_easy"));
  const Ended sensor = room.simulate("out", {"--as", "newer_college_2021/quad_easy", "--sensor", "avia"});
  CHECK(sensor.code == 2);
  CHECK_THAT(sensor.err, Contains("--sensor"));
  fs::create_directories(room / "published/quad_easy");
  write_text(room / "published/quad_easy/real.bag", "published");
  const Ended mixed = room.simulate("published", {"--as", "newer_college_2021/quad_easy"});
  CHECK(mixed.code == 2);
  CHECK_THAT(mixed.err, Contains("not mixed"));
  CHECK(names_below(room / "published") == std::vector<std::string>{"quad_easy/real.bag"});
  const Ended format = room.simulate("out", {"--as", "newer_college_2021/quad_easy", "--format", "mcap"});
  CHECK(format.code == 2);
  REQUIRE(room.simulate("out", {"--as", "newer_college_2021/quad_easy", "--quiet"}).code == 0);
  const Ended again = room.simulate("out", {"--as", "newer_college_2021/quad_easy"});
  CHECK(again.code == 2);
  CHECK_THAT(again.err, Contains("already"));
  REQUIRE(room.simulate("out", {"--as", "newer_college_2021/quad_hard", "--quiet"}).code == 0);
}

TEST_CASE("stand-ins: a quiet one still says that it is simulated, and a run takes it") {
  const Room room;
  const Ended ended = room.simulate("data", {"--as", "newer_college_2021/quad_easy", "--quiet"});
  INFO(ended.err);
  REQUIRE(ended.code == 0);
  CHECK_THAT(ended.out, Contains("SIMULATED    these are not the published data of Newer College"));
  const std::vector<std::string> names = names_below(room / "data");
  const auto has = [&](const std::string& name) { return std::find(names.begin(), names.end(), name) != names.end(); };
  CHECK(has("SIMULATED.md"));
  CHECK(has("quad_easy/gt-nc-quad-easy.csv"));
  CHECK(has("simulated/quad_easy/truth.tum"));
  CHECK_FALSE(has("simulated/quad_easy/dataset.yaml"));
  const Ended run = run_aslio({"run", std::string(ASLIO_SOURCE_DIR) + "/configs/pipelines/as_lio.yaml", "--dataset",
                               "newer_college_2021/quad_easy", "--data", room / "data", "--output", room / "run"});
  INFO(run.err);
  CHECK((run.code == 0 || run.code == 4));
  CHECK_THAT(run.out, Contains("ATE"));
}
