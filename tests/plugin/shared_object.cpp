#include "aslio/plugin/shared_object.hpp"

#include <sys/stat.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <fstream>

#include "aslio/config/description.hpp"
#include "aslio/core/sha256.hpp"
#include "aslio/plugin/abi.hpp"
#include "aslio/stages/window.hpp"
#include "config/stages.hpp"

using namespace aslio;
using Catch::Matchers::Contains;
using Catch::Matchers::EndsWith;
using Catch::Matchers::StartsWith;
namespace fs = std::filesystem;

namespace {

const fs::path kObjects = ASLIO_TEST_PLUGINS;

fs::path example() {
  const char* built_elsewhere = std::getenv("ASLIO_TEST_EXAMPLE");
  return built_elsewhere != nullptr ? fs::path(built_elsewhere) : kObjects / "good" / "my_window.so";
}

std::string load_error(plugin::Catalog& catalog, const fs::path& file) {
  try {
    plugin::load_shared_object(catalog, file);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "loaded";
}

std::string error_of(const fs::path& file) {
  plugin::Catalog catalog = test::make_catalog();
  return load_error(catalog, file);
}

std::string search_error(const std::string& search_path) {
  plugin::Catalog catalog;
  try {
    plugin::load_shared_objects(catalog, {}, search_path);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "loaded";
}

/// "plugin FILE: reason".
std::string because(const fs::path& file, const std::string& reason) {
  return std::string("plugin ").append(file.string()).append(": ").append(reason);
}

/// An empty directory of the build that goes with the test.
class Folder {
 public:
  explicit Folder(const std::string& name) : path(fs::path(ASLIO_BINARY_DIR) / ("plugin_test_" + name)) {
    fs::remove_all(path);
    fs::create_directories(path);
  }
  ~Folder() {
    std::error_code ignored;
    fs::remove_all(path, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  fs::path path;
};

struct WindowFile {
  config::Nested<WindowStrategy> window;
  static void describe(config::Binder& b, WindowFile& p) { b.stage("window", p.window, "the window"); }
};

/// A stream that has ended at 0.12 s, with one IMU sample.
class ShortStream final : public StreamView {
 public:
  explicit ShortStream(double gyro) { sample_.gyro.z() = gyro; }
  TimeNs points_until() const override { return kTimeMax; }
  TimeNs imu_until() const override { return kTimeMax; }
  TimeNs last_point() const override { return to_ns(0.12); }
  TimeNs last_imu() const override { return 0; }
  std::span<const TimedPoint> points(TimeNs, TimeNs) const override { return {}; }
  std::span<const ImuSample> imu(TimeNs, TimeNs) const override { return {&sample_, 1}; }
  std::optional<TimeNs> sweep_end_after(TimeNs) const override { return std::nullopt; }

 private:
  ImuSample sample_;
};

class NoProbe final : public OverlapProbe {
 public:
  OverlapScore overlap(TimeNs) override { return {}; }
};

}  // namespace

TEST_CASE("The example is listed, described, read from YAML, made and called") {
  plugin::Catalog catalog;
  const plugin::SharedObject object = plugin::load_shared_object(catalog, example());
  CHECK(object.path == fs::canonical(example()));
  CHECK(object.sha256 == sha256_of_file(example()));
  CHECK(object.types == std::vector<std::string>{"windows/my_window"});
  CHECK(catalog.types("windows") == std::vector<std::string>{"my_window"});
  CHECK_THAT(config::describe_stage(catalog, "windows", "my_window"),
             StartsWith(std::string("windows/my_window: a period that shortens while turning\nfrom: ")
                            .append(object.path.string())) &&
                 Contains("\n  turn_rate: number, > 0 rad/s, default 1\n"));

  const auto read = [&](const std::string& window) {
    return config::parse<WindowFile>(std::string("schema: aslio/pipeline/1\nwindow: ").append(window), "a.yaml",
                                     config::FileKind::pipeline, catalog);
  };
  CHECK_THROWS_WITH(read("{type: my_window, turning_period: 0.2}"),
                    "a.yaml:2:43: 'window.turning_period' = 0.2 must not exceed period");
  const auto loaded = read("{type: my_window, turn_rate: 2}");
  exec::Executor exec(1);
  const SensorModel sensor;
  const auto window = loaded.value.window.make({.exec = exec, .sensor = sensor, .log = nullptr});
  NoProbe probe;
  const Feedback start{};
  CHECK(window->next(ShortStream(1.0), start, probe)->end == to_ns(0.1));
  CHECK(window->next(ShortStream(3.0), start, probe)->end == to_ns(0.05));
  Feedback later{};
  later.t = to_ns(0.1);
  const auto last = window->next(ShortStream(1.0), later, probe);
  REQUIRE(last.has_value());
  CHECK(last->end == to_ns(0.12));
  CHECK(last->partial);
}

TEST_CASE("Files that are no plugin name the reason") {
  const Folder folder("files");
  const fs::path absent = folder.path / "absent.so";
  CHECK(error_of(absent) == because(absent, "cannot be found: No such file or directory"));
  CHECK(error_of(folder.path) == because(folder.path, "is not a regular file"));
  const fs::path text = folder.path / "text.so";
  std::ofstream(text) << "not a shared object";
  CHECK_THAT(error_of(text), StartsWith(because(text, "cannot be loaded: ")) && Contains("file too short"));
  std::ofstream(text) << std::string(10'000, 'x');
  CHECK_THAT(error_of(text), StartsWith(because(text, "cannot be loaded: ")) && Contains("invalid ELF header"));
  CHECK(error_of(kObjects / "no_entry.so") ==
        because(kObjects / "no_entry.so", "has no entry 'aslio_plugin': add ASLIO_PLUGIN(register_function)"));
}

TEST_CASE("A plugin that was cut short is refused before it is mapped") {
  const Folder folder("cut");
  const fs::path file = folder.path / "my_window.so";
  const auto whole = fs::file_size(example());
  // The loader reads the first page; behind it begin the mapped parts, and at the end stand the headers of sections.
  for (const std::uintmax_t bytes : {std::uintmax_t{200}, whole / 4, whole / 2, whole - 1}) {
    fs::copy_file(example(), file, fs::copy_options::overwrite_existing);
    fs::resize_file(file, bytes);
    CHECK_THAT(error_of(file), StartsWith(because(file, "is cut short or damaged: ")) &&
                                   Contains("behind its " + std::to_string(bytes) + " bytes; build it again"));
  }
  fs::copy_file(example(), file, fs::copy_options::overwrite_existing);
  CHECK(error_of(file) == "loaded");
}

TEST_CASE("What anybody could have written is not loaded") {
  const Folder folder("writable");
  const fs::path file = folder.path / "my_window.so";
  fs::copy_file(example(), file);
  REQUIRE(chmod(file.c_str(), 0757) == 0);
  CHECK_THAT(error_of(file), StartsWith(because(file, "can be written by anybody: chmod o-w it. Where rights")));
  REQUIRE(chmod(file.c_str(), 0755) == 0);
  REQUIRE(chmod(folder.path.c_str(), 01777) == 0);
  const std::string directory = fs::canonical(folder.path).string();
  const std::string reason =
      std::string("its directory ").append(directory).append(" can be written by anybody: move the plugin elsewhere");
  CHECK_THAT(error_of(file), StartsWith(because(file, reason)));
  const fs::path deeper = folder.path / "deeper";
  fs::create_directory(deeper);
  REQUIRE(chmod(deeper.c_str(), 0755) == 0);
  fs::rename(file, deeper / "my_window.so");
  CHECK(error_of(deeper / "my_window.so") == "loaded");
  REQUIRE(chmod(folder.path.c_str(), 0777) == 0);
  CHECK_THAT(error_of(deeper / "my_window.so"), StartsWith(because(deeper / "my_window.so", reason)));
}

TEST_CASE("A file system without rights: the user may allow a plugin that is named, with a warning") {
  const Folder folder("no_rights");
  const fs::path file = folder.path / "my_window.so";
  fs::copy_file(example(), file);
  REQUIRE(chmod(file.c_str(), 0777) == 0);
  REQUIRE(chmod(folder.path.c_str(), 0777) == 0);
  CHECK_THAT(error_of(file), Contains("WSL") && EndsWith("ASLIO_ALLOW_WRITABLE_PLUGINS=1 allows it for --plugin"));
  REQUIRE(setenv(plugin::kAllowWritableVariable, "yes", 1) == 0);
  CHECK(plugin::writable_plugins() == plugin::WritablePlugins::refused);
  REQUIRE(setenv(plugin::kAllowWritableVariable, "1", 1) == 0);
  const auto allowed = plugin::writable_plugins();
  REQUIRE(unsetenv(plugin::kAllowWritableVariable) == 0);
  CHECK(plugin::writable_plugins() == plugin::WritablePlugins::refused);
  plugin::Catalog catalog;
  const std::vector<std::string> files{file.string()};
  const auto objects = plugin::load_shared_objects(catalog, files, "", allowed);
  REQUIRE(objects.size() == 1);
  CHECK_THAT(objects[0].warning, StartsWith(because(file, "can be written by anybody")));
  // What a directory holds was named by nobody.
  plugin::Catalog other;
  CHECK_THROWS_AS(plugin::load_shared_objects(other, {}, folder.path.string(), allowed), ConfigError);
}

TEST_CASE("Entries of another version or build are refused before their code runs") {
  const auto error = [](const std::string& name, const std::string& reason) {
    const fs::path file = kObjects / (name + ".so");
    CHECK(error_of(file) == because(file, reason));
  };
  error("wrong_magic", "'aslio_plugin' is not the entry of a plugin (wrong magic number)");
  error("wrong_version", "has plugin ABI version 14, this program has 13: build it again with this version's headers");
  error("wrong_size", "its entry has 40 bytes, this program expects 32: build it again with this version's headers");
  error("no_stamp", "its entry is incomplete");
  const fs::path stamp = kObjects / "wrong_stamp.so";
  CHECK_THAT(error_of(stamp), StartsWith(because(stamp,
                                                 "was built differently: it has framework 0.0.9; this program "
                                                 "has framework 0.2.0, ")) &&
                                  Contains("TimedPoint 40/8") &&
                                  Contains(": build both with one compiler and one version"));
}

TEST_CASE("A failing registration is told and leaves the catalog as it was") {
  plugin::Catalog catalog;
  const auto error = [&](const std::string& name) { return load_error(catalog, kObjects / (name + ".so")); };
  CHECK(error("throws") == because(kObjects / "throws.so", "its registration failed: no licence found"));
  CHECK(error("throws_number") ==
        because(kObjects / "throws_number.so", "its registration failed: an exception that is no std::exception"));
  CHECK(error("changes") == because(kObjects / "changes.so",
                                    "was changed while it was loaded, so its SHA-256 is not that of the code: load it "
                                    "again"));
  CHECK(error("empty") == because(kObjects / "empty.so", "registers no type"));
  CHECK(catalog.families().empty());
  CHECK(
      error_of(kObjects / "taken.so") ==
      because(kObjects / "taken.so", "its type clocks/quartz is registered already, by built-in: rename one of them"));
}

TEST_CASE("Two shared objects with one type are told apart by their paths") {
  const Folder folder("twice");
  const fs::path copy = folder.path / "copy.so";
  fs::copy_file(example(), copy);
  plugin::Catalog catalog;
  plugin::load_shared_object(catalog, example());
  CHECK(load_error(catalog, copy) == because(copy, std::string("its type windows/my_window is registered already, by ")
                                                       .append(fs::canonical(example()).string())
                                                       .append(": rename one of them")));
}

TEST_CASE("ASLIO_PLUGIN_PATH: every .so of its directories, by name, and a file that comes up twice counts once") {
  const Folder folder("path");
  fs::copy_file(example(), folder.path / "b.so");
  fs::copy_file(kObjects / "taken.so", folder.path / "a.so");
  std::ofstream(folder.path / "notes.txt") << "no plugin";
  plugin::Catalog catalog;
  const std::vector<std::string> files{(folder.path / "b.so").string()};
  const auto objects = plugin::load_shared_objects(catalog, files, folder.path.string());
  REQUIRE(objects.size() == 2);
  CHECK(objects[0].path.filename() == "b.so");
  CHECK(objects[1].path.filename() == "a.so");
  CHECK(catalog.find("clocks", "quartz")->origin == objects[1].path.string());
  REQUIRE(setenv("ASLIO_PLUGIN_PATH", "/opt/aslio", 1) == 0);
  CHECK(plugin::plugin_search_path() == "/opt/aslio");
  REQUIRE(unsetenv("ASLIO_PLUGIN_PATH") == 0);
  CHECK(plugin::plugin_search_path().empty());
}

TEST_CASE("ASLIO_PLUGIN_PATH: relative, missing and leaking directories are errors") {
  CHECK(search_error("plugins") == "ASLIO_PLUGIN_PATH: 'plugins' is not an absolute directory");
  CHECK(search_error(":/opt") == "ASLIO_PLUGIN_PATH: '' is not an absolute directory");
  CHECK(search_error("/no/such/place") ==
        "ASLIO_PLUGIN_PATH: '/no/such/place' cannot be found: No such file or directory");
  const Folder folder("leak");
  CHECK(search_error(folder.path.string() + ":") == "ASLIO_PLUGIN_PATH: ends with ':', remove it");
  fs::create_symlink(example(), folder.path / "link.so");
  CHECK(search_error(folder.path.string()) == std::string("ASLIO_PLUGIN_PATH: '")
                                                  .append(folder.path.string())
                                                  .append("' holds ")
                                                  .append((fs::canonical(folder.path) / "link.so").string())
                                                  .append(", which leads out of it"));
}
