/// The clean recording and its runs, kept in the build folder from case to case.

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <filesystem>
#include <stdexcept>

#include "aslio/config/load.hpp"
#include "aslio/core/sha256.hpp"
#include "aslio/io/writers.hpp"
#include "aslio/plugin/registry.hpp"
#include "aslio/simulator/simulation.hpp"
#include "aslio/simulator/version.hpp"
#include "faults/driver.hpp"
#include "integration/recorded_scene.hpp"

namespace aslio::test::faults {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr double kDuration = 12;     // [s]
constexpr std::size_t kKeepOne = 3;  // of so many firings: 6700 points of a sweep
constexpr std::uint64_t kSeed = 107;

/// Held by one process at a time; the others wait, and find what it has made.
class Lock {
 public:
  explicit Lock(const fs::path& file) : fd_(::open(file.c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0600)) {
    if (fd_ < 0 || ::flock(fd_, LOCK_EX) != 0) throw std::runtime_error("no lock: " + file.string());
  }
  ~Lock() { ::close(fd_); }
  Lock(const Lock&) = delete;
  Lock& operator=(const Lock&) = delete;

 private:
  int fd_;
};

fs::path kept() {
  const fs::path folder = fs::path(ASLIO_BINARY_DIR) / "faults";
  fs::create_directories(folder);
  return folder;
}

simulator::SceneFile scene() {
  return simulator::load_scene(ASLIO_SOURCE_DIR "/configs/scenes/quickstart.yaml", {"people.crossing=0"});
}

/// One firing in kKeepOne, as a slower LiDAR of the same view would have it.
void thin(LidarPacket& packet) {
  std::size_t firing = 0;
  TimeNs last = kTimeMin;
  std::erase_if(packet.points, [&](const TimedPoint& point) {
    if (point.t != last) ++firing;
    last = point.t;
    return firing % kKeepOne != 0;
  });
}

void make(const fs::path& folder, const simulator::SceneFile& file) {
  const simulator::Simulation simulation(file, {.seed = kSeed, .sensor = simulator::SensorKind::mid360});
  Recording recording = record(simulation, kDuration);
  for (Measurement& m : recording) {
    if (auto* packet = std::get_if<LidarPacket>(&m)) thin(*packet);
  }
  const fs::path part = folder.string() + ".part";
  fs::remove_all(part);
  fs::create_directories(part);
  write_bag(part / "walk.bag", recording);
  const Trajectory truth = simulation.truth();
  std::vector<StampedPose> poses(truth.samples().begin(), truth.samples().end());
  const TimeNs end = simulation.begin_time() + to_ns(kDuration);
  std::erase_if(poses, [end](const StampedPose& pose) { return pose.t > end; });
  io::write_tum(part / "truth.tum", poses);
  write_text(part / "sensor.yaml", sensor_text(simulation.claimed_sensor()));
  fs::rename(part, folder);
}

Walk load(const fs::path& folder) {
  const plugin::Catalog no_stages;
  const auto sensor = config::load<io::SensorConfig>(folder / "sensor.yaml", config::FileKind::sensor, no_stages).value;
  Walk walk;
  walk.data = read_all(*io::open_source(folder / "walk.bag", sensor));
  walk.truth = io::read_tum(folder / "truth.tum");
  walk.sensor = sensor.model;
  return walk;
}

}  // namespace

const Walk& clean_walk() {
  static const Walk walk = [] {
    const simulator::SceneFile file = scene();
    const std::string key = sha256_of(
        fmt::format("{} {} {} {} {}", file.resolved, simulator::sources_digest(), kSeed, kDuration, kKeepOne));
    const fs::path folder = kept() / ("walk_" + key.substr(0, 12));
    const Lock lock(kept() / "walk.lock");
    if (!fs::exists(folder)) make(folder, file);
    return load(folder);
  }();
  return walk;
}

Outcome run_clean(const std::string& pipeline) {
  const std::string key = sha256_of_file(ASLIO_PROGRAM) + sha256_of_file("/proc/self/exe");
  const fs::path file = kept() / fmt::format("clean_{}_{}.json", pipeline, sha256_of(key).substr(0, 12));
  const Lock lock(kept() / (pipeline + ".lock"));
  Outcome out;
  if (fs::exists(file)) {
    const Json json = Json::parse(content(file));
    out.exit_code = json.at("exit_code");
    out.summary = json.at("summary");
    out.trajectory = json.at("trajectory");
    out.ate = json.at("ate_m").get<double>();
    return out;
  }
  const Walk& walk = clean_walk();
  out = run_over(walk.data, walk.truth, walk.sensor, {.pipeline = pipeline});
  const Json json = {{"exit_code", out.exit_code},
                     {"summary", out.summary},
                     {"trajectory", out.trajectory},
                     {"ate_m", out.ate.value()}};
  io::AtomicFile written(file);
  written.write(json.dump());
  written.close();
  return out;
}

}  // namespace aslio::test::faults
