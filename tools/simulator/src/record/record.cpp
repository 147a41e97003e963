#include "aslio/simulator/record.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <system_error>
#include <vector>

#include "aslio/core/errors.hpp"
#include "aslio/exec/executor.hpp"
#include "aslio/io/source.hpp"
#include "aslio/io/writers.hpp"
#include "record/native_layout.hpp"
#include "record/stream.hpp"
#include "record/tables.hpp"
#include "record/top_view.hpp"

namespace aslio::simulator {
namespace {

namespace fs = std::filesystem;

/// Packets in work at once, for each thread: enough that no thread waits long for the last one.
constexpr std::size_t kBatchPerThread = 4;

void write_text(const fs::path& path, std::string_view text) {
  io::AtomicFile file(path);
  file.write(text);
  file.close();
}

void create_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw DataError(fmt::format("{}: cannot create the folder: {}", folder.string(), error.message()));
}

/// Says no longer that the files are whole: they are about to change.
void remove_dataset_file(const fs::path& path) {
  std::error_code error;
  fs::remove(path, error);
  if (error)
    throw DataError(fmt::format("{}: cannot replace it: {}; name another folder, or let this one be written",
                                path.string(), error.message()));
}

/// Takes packets in order to everything that is made of them.
class Recording {
 public:
  Recording(const Simulation& simulation, const Trajectory& truth, const RecordOptions& options,
            const RecordLayout& layout, RecordResult& result)
      : simulation_(simulation),
        stream_(simulation, truth, layout),
        overlap_(options.folder / "overlap.csv"),
        top_view_(truth, simulation.caster().mesh(), simulation.ground()),
        result_(result) {}

  void add(const SimulatedPacket& packet, std::size_t index) {
    stream_.add(packet.packet, index);
    for (std::size_t k = 0; k < packet.blocks.size(); ++k) {
      const bool last = k + 1 == packet.blocks.size();
      const TimeNs packet_end = std::min(packet.packet.stamp + Simulation::kPacketPeriod, simulation_.end_time());
      overlap_.add(packet.blocks[k], last ? packet_end : packet.blocks[k + 1].begin);
    }
    top_view_.add(packet.view);
    result_.points += packet.packet.points.size();
    result_.rays += packet.rays;
  }

  void close() {
    stream_.close();
    overlap_.close();
    result_.packets = stream_.lidar_messages();
    result_.imu_samples = stream_.imu_messages();
    result_.files = stream_.files();
  }

  const TopView& top_view() const { return top_view_; }

 private:
  const Simulation& simulation_;
  RecordingStream stream_;
  OverlapTable overlap_;
  TopView top_view_;
  RecordResult& result_;
};

/// False: stopped.
bool cast_all(const Simulation& simulation, Recording& recording, int threads, const RecordProgress& progress) {
  exec::Executor executor(threads);
  const std::size_t count = simulation.packet_count();
  std::vector<SimulatedPacket> batch(kBatchPerThread * static_cast<std::size_t>(threads));
  for (std::size_t begin = 0; begin < count; begin += batch.size()) {
    const std::size_t size = std::min(batch.size(), count - begin);
    auto cast = [&](std::size_t k) { batch[k] = simulation.packet(begin + k); };
    executor.for_chunks(size, exec::ChunkFunction(cast));
    for (std::size_t k = 0; k < size; ++k) recording.add(batch[k], begin + k);
    if (progress && !progress(static_cast<double>(begin + size) / static_cast<double>(count))) return false;
  }
  return true;
}

/// The usual reason is a mesh in another unit or another frame than the motion.
DataError nothing_returned(const Simulation& simulation, const Trajectory& truth) {
  Eigen::AlignedBox3d path, world;
  for (const StampedPose& pose : truth.samples()) path.extend(pose.T.p);
  for (const Eigen::Vector3f& vertex : simulation.caster().mesh().vertices) world.extend(vertex.cast<double>());
  const auto text = [](const Vec3& p) { return fmt::format("({:.4g}, {:.4g}, {:.4g})", p.x(), p.y(), p.z()); };
  return DataError(fmt::format(
      "{}: no ray has returned: the path runs from {} to {} [m], the world reaches from {} to {}; give motion and mesh "
      "the same frame and unit",
      simulation.scene().world.mesh.file.empty() ? "scene" : simulation.scene().world.mesh.file, text(path.min()),
      text(path.max()), text(world.min()), text(world.max())));
}

}  // namespace

bool record(const Simulation& simulation, const SceneFile& scene, const RecordOptions& options,
            const RecordProgress& progress, RecordResult& result) {
  const auto start = std::chrono::steady_clock::now();
  result = {};
  create_folder(options.folder);
  const fs::path dataset = options.folder / "dataset.yaml";
  remove_dataset_file(dataset);
  const bool native = !options.layout;
  const RecordLayout layout = native ? native_layout(simulation, options) : *options.layout;
  if (native) remove_earlier_parts(options);
  const Trajectory truth = simulation.truth();
  result.data_s = simulation.duration();
  result.path_length_m = truth.path_length();
  Recording recording(simulation, truth, options, layout, result);
  if (!cast_all(simulation, recording, options.threads, progress)) return false;
  if (result.points == 0) throw nothing_returned(simulation, truth);
  recording.close();
  io::write_tum(options.folder / "truth.tum", truth.samples());
  write_truth_table(simulation, options.folder / "truth.csv");
  write_text(options.folder / "scene.yaml", scene_file(simulation, scene));
  const std::string title = fmt::format("{}: {:.0f} m, {:.0f} s, {}", options.name, result.path_length_m, result.data_s,
                                        facts(simulation.sensor_kind()).name);
  write_text(options.folder / "preview.svg", recording.top_view().svg(truth, title));
  if (native) {
    write_text(options.folder / "sensor.yaml", sensor_file(simulation));
    result.input = native_input(options);
    result.bag_sha256 = io::input_digest(options.folder / result.input);
    write_text(dataset, dataset_file(simulation, options.name, result.input));
  }
  result.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return true;
}

}  // namespace aslio::simulator
