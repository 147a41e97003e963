/// A simulated walk round a closed loop, again and again without a pause: does memory grow, does time?

#include <fmt/format.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif
#include <spdlog/sinks/null_sink.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <string>
#include <unordered_map>
#include <vector>

#include "aslio/core/thrown.hpp"
#include "aslio/experiment/run.hpp"
#include "aslio/simulator/simulation.hpp"
#include "register_all.hpp"

namespace {

using namespace aslio;
namespace fs = std::filesystem;

constexpr double kMaxMegabytesPerHour = 1.0;
constexpr double kMaxSlowdown = 1.25;
constexpr std::size_t kKeepOne = 4;  ///< of so many firings: 5000 points of a sweep

/// What is seen at the end of each round. `cpu_s` is that of the run alone, `yardstick_s` that of the yardstick.
struct Round {
  double data_h = 0, rss_mb = 0, cpu_s = 0, yardstick_s = 0;
};

double rss_mb() {
  std::ifstream statm("/proc/self/statm");
  double size = 0, resident = 0;
  statm >> size >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) * 1e-6;
}

double cpu_s() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

/// One round: whole packets, and the IMU samples of their time.
struct Walk {
  std::vector<Measurement> measurements;
  TimeNs period = 0;
  TimeNs begin = 0;
  SensorModel sensor;
};

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

Walk simulate(const fs::path& scene) {
  const auto file = simulator::load_scene(scene);
  const simulator::Simulation simulation(file, {.seed = 107, .sensor = simulator::SensorKind::mid360});
  const TimeNs packet_period = simulator::Simulation::kPacketPeriod;
  const auto packets = static_cast<std::size_t>((simulation.end_time() - simulation.begin_time()) / packet_period);
  Walk walk{{}, static_cast<TimeNs>(packets) * packet_period, simulation.begin_time(), simulation.claimed_sensor()};
  const auto& imu = simulation.imu().samples;
  std::size_t sample = 0;
  for (std::size_t i = 0; i < packets; ++i) {
    LidarPacket packet = simulation.packet(i).packet;
    thin(packet);
    for (; sample < imu.size() && imu[sample].t < packet.stamp + packet_period; ++sample) {
      walk.measurements.emplace_back(imu[sample]);
    }
    walk.measurements.emplace_back(std::move(packet));
  }
  return walk;
}

/// Work that is the same after every round, of the kind that a map does. Its time says how fast the machine is just
/// then: what other processes do to the caches and the clock, they do to both.
class Yardstick {
 public:
  explicit Yardstick(const Walk& walk) {
    for (const Measurement& m : walk.measurements) {
      const auto* packet = std::get_if<LidarPacket>(&m);
      if (!packet || points_.size() >= kPoints) continue;
      for (const TimedPoint& p : packet->points) points_.emplace_back(p.x, p.y, p.z);
    }
    order_.resize(points_.size());
  }

  /// CPU time of one measure [s].
  double measure() {
    const double begin = cpu_s();
    for (int pass = 0; pass < kPasses; ++pass) {
      std::iota(order_.begin(), order_.end(), 0u);
      std::ranges::sort(order_, {}, [&](std::uint32_t i) { return points_[i].x() + points_[i].y(); });
      cells_.clear();
      Mat3 moments = Mat3::Zero();
      for (const std::uint32_t i : order_) {
        ++cells_[static_cast<std::int64_t>(points_[i].x() * 4) * 100'003 +
                 static_cast<std::int64_t>(points_[i].y() * 4)];
        moments += points_[i] * points_[i].transpose();
      }
      kept_ += moments.trace() + static_cast<double>(cells_.size());
    }
    return cpu_s() - begin;
  }
  double kept() const { return kept_; }  ///< so that no compiler leaves the work out

 private:
  static constexpr std::size_t kPoints = 200'000;
  static constexpr int kPasses = 4;
  std::vector<Vec3> points_;
  std::vector<std::uint32_t> order_;
  std::unordered_map<std::int64_t, int> cells_;
  double kept_ = 0;
};

/// The same walk without end, or as often as is asked for; stamps go on.
class LoopedSource final : public io::MeasurementSource {
 public:
  LoopedSource(const Walk& walk, std::size_t rounds, Yardstick& yardstick, std::vector<Round>& seen)
      : walk_(walk), rounds_(rounds), yardstick_(yardstick), seen_(seen) {}

  std::optional<Measurement> next() override {
    if (next_ == walk_.measurements.size()) {
      ++round_;
      next_ = 0;
      const double run_s = cpu_s() - yardsticks_s_, yardstick_s = yardstick_.measure();
      yardsticks_s_ += yardstick_s;
      seen_.push_back({to_seconds(static_cast<TimeNs>(round_) * walk_.period) / 3600, rss_mb(), run_s, yardstick_s});
    }
    if (round_ == rounds_) return std::nullopt;
    Measurement m = walk_.measurements[next_++];
    const TimeNs shift = static_cast<TimeNs>(round_) * walk_.period;
    if (auto* imu = std::get_if<ImuSample>(&m)) {
      imu->t += shift;
    } else {
      auto& packet = std::get<LidarPacket>(m);
      packet.stamp += shift;
      packet.sweep_id = sweep_++;
      for (TimedPoint& point : packet.points) {
        point.t += shift;
        point.sweep_id = packet.sweep_id;
      }
    }
    return m;
  }
  io::InputStatus status() const override { return io::InputStatus::complete; }
  const io::SourceNotes& notes() const override { return notes_; }
  std::optional<TimeNs> begin_time() const override { return walk_.begin; }
  std::optional<TimeNs> end_time() const override { return walk_.begin + static_cast<TimeNs>(rounds_) * walk_.period; }

 private:
  const Walk& walk_;
  std::size_t rounds_, round_ = 0, next_ = 0;
  std::uint32_t sweep_ = 0;
  Yardstick& yardstick_;
  double yardsticks_s_ = 0;
  std::vector<Round>& seen_;
  io::SourceNotes notes_;
};

class Quiet final : public experiment::RunMonitor {
 public:
  void on_start(const io::SourceNotes&) override {}
  void on_progress(const experiment::Progress&) override {}
  bool stop_requested() override { return false; }
};

/// By least squares over the second half of the rounds: the map has long seen all there is [MB/h].
double slope(const std::vector<Round>& rounds) {
  double n = 0, t = 0, m = 0, tt = 0, tm = 0;
  for (std::size_t i = rounds.size() / 2; i < rounds.size(); ++i) {
    const Round& r = rounds[i];
    n += 1;
    t += r.data_h;
    m += r.rss_mb;
    tt += r.data_h * r.data_h;
    tm += r.data_h * r.rss_mb;
  }
  return (n * tm - t * m) / (n * tt - t * t);
}

/// Median CPU time of a round in yardsticks of the same minute, among the first or last tenth; the very first left out.
double cost(const std::vector<Round>& rounds, bool last) {
  std::vector<double> costs;
  for (std::size_t i = 1; i < rounds.size(); ++i) {
    const double yardstick_s = 0.5 * (rounds[i].yardstick_s + rounds[i - 1].yardstick_s);
    costs.push_back((rounds[i].cpu_s - rounds[i - 1].cpu_s) / yardstick_s);
  }
  const std::size_t tenth = std::max<std::size_t>(1, costs.size() / 10);
  std::vector<double> part(last ? costs.end() - static_cast<std::ptrdiff_t>(tenth) : costs.begin(),
                           last ? costs.end() : costs.begin() + static_cast<std::ptrdiff_t>(tenth));
  std::sort(part.begin(), part.end());
  return part[part.size() / 2];
}

int report(const experiment::Summary& summary, const std::vector<Round>& rounds, double period_s) {
  const double growth = slope(rounds), first = cost(rounds, false), last = cost(rounds, true);
  fmt::print("{:>10} {:>10} {:>12} {:>14}\n", "data [min]", "RSS [MB]", "CPU/data", "yardstick [s]");
  const std::size_t step = std::max<std::size_t>(1, rounds.size() / 12);
  for (std::size_t i = step - 1; i < rounds.size(); i += step) {
    const double before = i >= step ? rounds[i - step].cpu_s : 0.0;
    const double over = static_cast<double>(i >= step ? step : i + 1) * period_s;
    fmt::print("{:>10.1f} {:>10.2f} {:>12.4f} {:>14.4f}\n", 60 * rounds[i].data_h, rounds[i].rss_mb,
               (rounds[i].cpu_s - before) / over, rounds[i].yardstick_s);
  }
  fmt::print("status {}{}{}\n", pipeline::name(summary.status), summary.reason.empty() ? "" : ": ", summary.reason);
  fmt::print("memory {:+.3f} MB per hour of data over the second half (at most {})\n", growth, kMaxMegabytesPerHour);
  fmt::print("time   {:.3f} yardsticks per round in the first tenth, {:.3f} in the last, x {:.3f} (at most {})\n",
             first, last, last / first, kMaxSlowdown);
  const bool good = growth < kMaxMegabytesPerHour && last < kMaxSlowdown * first &&
                    (summary.status == pipeline::RunStatus::ok || summary.status == pipeline::RunStatus::degraded);
  fmt::print("verdict {}\n", good ? "held" : "NOT held");
  return good ? 0 : 1;
}

/// The sensor file of the simulated sensor, as far as it matters here.
std::string sensor_text(const SensorModel& s) {
  return fmt::format(
      "schema: aslio/sensor/1\nT_imu_lidar: {{translation: [{}, {}, {}], rotation: [1, 0, 0, 0, 1, 0, 0, 0, 1]}}\n"
      "scan_lines: {}\nmin_range: {}\nmax_range: {}\n",
      s.T_imu_lidar.p.x(), s.T_imu_lidar.p.y(), s.T_imu_lidar.p.z(), s.scan_lines, s.min_range, s.max_range);
}

int soak(double hours, const fs::path& pipeline, const fs::path& scene) {
  const Walk walk = simulate(scene);
  const double period_s = to_seconds(walk.period);
  const auto rounds = static_cast<std::size_t>(std::max(8.0, hours * 3600 / period_s));
  const fs::path folder = fs::temp_directory_path() / fmt::format("aslio_soak_{}", getpid());
  fs::create_directories(folder);
  std::ofstream(folder / "sensor.yaml") << sensor_text(walk.sensor);
  Yardstick yardstick(walk);
  yardstick.measure();  // its memory is there before the first round
  std::vector<Round> seen;
  seen.reserve(rounds);
  experiment::RunOptions options;
  options.pipeline = pipeline;
  options.input = "simulated walk in a loop";
  options.sensor = folder / "sensor.yaml";
  options.output = folder / "out";
  options.open_input = [&](const io::SensorConfig&) {
    return std::make_unique<LoopedSource>(walk, rounds, yardstick, seen);
  };
  plugin::Catalog catalog;
  plugins::register_all(catalog);
  Quiet monitor;
  const auto log = std::make_shared<spdlog::logger>("soak", std::make_shared<spdlog::sinks::null_sink_mt>());
  fmt::print("{}: {} rounds of {:.1f} s, {:.2f} h of simulated data\n", scene.filename().string(), rounds, period_s,
             static_cast<double>(rounds) * period_s / 3600);
  std::fflush(stdout);
  const auto result = experiment::run(options, catalog, monitor, log);
  if (!std::isfinite(yardstick.kept())) return 1;
  std::error_code ignored;
  fs::remove_all(folder, ignored);
  return report(result.summary, seen, period_s);
}

/// As the program `aslio` does.
void keep_freed_memory() {
#ifdef __GLIBC__
  mallopt(M_MMAP_THRESHOLD, 16 << 20);
  mallopt(M_TRIM_THRESHOLD, 64 << 20);
#endif
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> words(argv + 1, argv + argc);
  double hours = 0;
  const bool numbered =
      words.size() == 3 && std::from_chars(words[0].data(), words[0].data() + words[0].size(), hours).ec == std::errc{};
  if (!numbered || !(hours > 0 && hours <= 1000)) {
    fmt::print(stderr, "usage: aslio_soak HOURS PIPELINE.yaml SCENE.yaml   (hours of simulated data, at most 1000)\n");
    return 2;
  }
  keep_freed_memory();
  try {
    return soak(hours, words[1], words[2]);
  } catch (...) {
    fmt::print(stderr, "error: {}\n", what_was_thrown());
    return 1;
  }
}
