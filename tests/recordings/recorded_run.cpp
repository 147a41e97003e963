#include "recordings/recorded_run.hpp"

#include <spdlog/sinks/null_sink.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <sstream>

#include "aslio/core/sha256.hpp"
#include "aslio/io/source.hpp"
#include "aslio/io/writers.hpp"
#include "recordings/unpacked.hpp"
#include "register_all.hpp"

namespace aslio::test {
namespace {

namespace fs = std::filesystem;

constexpr io::Section kPart{.start = 0, .duration = 5.0};

class Unwatched final : public experiment::RunMonitor {
 public:
  void on_start(const io::SourceNotes&) override {}
  void on_progress(const experiment::Progress&) override {}
  bool stop_requested() override { return false; }
};

/// Column t_ns, the first.
std::vector<TimeNs> read_update_times(const fs::path& csv) {
  std::ifstream file(csv);
  std::string line;
  std::getline(file, line);
  if (!line.starts_with("t_ns,")) throw std::runtime_error(csv.string() + ": the first column is not t_ns");
  std::vector<TimeNs> times;
  while (std::getline(file, line)) times.push_back(std::stoll(line));
  return times;
}

/// Columns t_ns, one per stage.
std::vector<UpdateCost> read_costs(const fs::path& csv) {
  std::ifstream file(csv);
  std::string line, field;
  std::getline(file, line);
  std::vector<bool> is_overlap;
  for (std::istringstream head(line); std::getline(head, field, ',');) is_overlap.push_back(field == "overlap_s");
  if (std::count(is_overlap.begin(), is_overlap.end(), true) != 1) {
    throw std::runtime_error(csv.string() + ": has no column overlap_s");
  }
  std::vector<UpdateCost> costs;
  while (std::getline(file, line)) {
    std::istringstream row(line);
    UpdateCost cost;
    for (std::size_t i = 0; i < is_overlap.size() && std::getline(row, field, ','); ++i) {
      if (i == 0) continue;  // the time
      cost.all += std::stod(field);
      if (is_overlap[i]) cost.overlap += std::stod(field);
    }
    costs.push_back(cost);
  }
  return costs;
}

RecordedRun run(const std::string& pipeline, int threads, const fs::path& input, const char* sensor,
                const fs::path& reference, const std::vector<std::string>& overrides = {}, std::uint64_t order_seed = 0,
                const io::Section& section = {}) {
  const fs::path configs = fs::path(ASLIO_SOURCE_DIR) / "configs";
  // Tests of one folder may run at once.
  const fs::path output =
      fs::path(ASLIO_BINARY_DIR) / "recordings" / ("run_" + pipeline + "_" + std::to_string(getpid()));
  experiment::RunOptions options;
  options.pipeline = configs / "pipelines" / (pipeline + ".yaml");
  options.input = input;
  options.sensor = configs / "sensors" / sensor;
  options.output = output;
  options.threads = threads;
  options.reference = reference;
  options.overrides = overrides;
  options.order_seed = order_seed;
  options.section = section;
  options.closed_loop = true;
  plugin::Catalog catalog;
  plugins::register_all(catalog);
  Unwatched monitor;
  const auto log = std::make_shared<spdlog::logger>("run", std::make_shared<spdlog::sinks::null_sink_mt>());
  RecordedRun out;
  out.summary = experiment::run(options, catalog, monitor, log).summary;
  out.trajectory_sha256 = sha256_of_file(output / "trajectory.tum");
  out.lidar = Trajectory(io::read_tum(output / "trajectory_lidar.tum"));
  out.update_times = read_update_times(output / "updates.csv");
  out.costs = read_costs(output / "timings.csv");
  fs::remove_all(output);
  return out;
}

}  // namespace

RecordedRun run_on_avia(const std::string& pipeline, int threads, const std::vector<std::string>& overrides,
                        std::uint64_t order_seed) {
  return run(pipeline, threads, unpacked_avia(), "livox_avia.yaml", recorded("avia_corridor.gt.tum"), overrides,
             order_seed);
}

RecordedRun run_on_kitti(const std::string& pipeline, int threads, const std::string& reference) {
  return run(pipeline, threads, unpacked_kitti(), "kitti_hdl64.yaml", recorded(reference));
}

RecordedRun run_on_moving_kitti(const std::string& pipeline, double start_s) {
  return run(pipeline, 1, unpacked_kitti("0013"), "kitti_hdl64.yaml", recorded("reference/kitti_0013/oxts.tum"), {}, 0,
             {.start = start_s, .duration = {}});
}

bool same_bits_on_avia(const std::string& pipeline) {
  const auto digest = [&](int threads) {
    return run(pipeline, threads, unpacked_avia(), "livox_avia.yaml", recorded("avia_corridor.gt.tum"), {}, 0, kPart)
        .trajectory_sha256;
  };
  return digest(1) == digest(2);
}

bool same_bits_on_kitti(const std::string& pipeline) {
  const auto digest = [&](int threads) {
    return run(pipeline, threads, unpacked_kitti(), "kitti_hdl64.yaml", recorded("reference/kitti_0005/fast_lio2.tum"),
               {}, 0, kPart)
        .trajectory_sha256;
  };
  return digest(1) == digest(2);
}

}  // namespace aslio::test
