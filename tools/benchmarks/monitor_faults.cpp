/// Plays a recording with faults that are put into its measurements, and writes what a monitor could see of every
/// update.
///   monitor_faults RECORDING SENSOR.yaml TRUTH.tum PIPELINE OUT.csv FAULT AT [PIPELINE OPTION]..
/// FAULT: clean, cut, gap, .. (see the table below), from data time AT [s] after the first measurement on.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "aslio/config/load.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/core/lie.hpp"
#include "aslio/core/trajectory.hpp"
#include "aslio/io/source.hpp"
#include "aslio/io/writers.hpp"
#include "aslio/pipeline/odometry.hpp"
#include "aslio/pipeline/stage_set.hpp"
#include "aslio/stages/motion.hpp"
#include "register_all.hpp"

using namespace aslio;

namespace {

constexpr double kCut = 4.0, kSilence = 10.0;  // [s]

/// What becomes of one measurement; `since`: seconds after the fault begins (negative: before).
struct Fault {
  std::string name;
  TimeNs at = 0;
  std::optional<ImuSample> held;

  /// Rather than in the sensor file, or none.
  bool in_data() const { return !name.starts_with("rot_") && !name.starts_with("move_") && name != "clean"; }

  /// False: it is lost.
  bool apply(Measurement& m) {
    auto* imu = std::get_if<ImuSample>(&m);
    auto* packet = std::get_if<LidarPacket>(&m);
    const TimeNs t = imu != nullptr ? imu->t : packet->stamp;
    const double since = to_seconds(t - at);
    if (since < 0) return true;
    if (name == "cut" || name == "gap") {
      if (since < kCut) return false;
      if (name == "cut") shift(m, -to_ns(kCut));
      return true;
    }
    return imu == nullptr || spoil(*imu);
  }

  static void shift(Measurement& m, TimeNs by) {
    if (auto* imu = std::get_if<ImuSample>(&m)) {
      imu->t += by;
      return;
    }
    auto& packet = std::get<LidarPacket>(m);
    packet.stamp += by;
    for (TimedPoint& p : packet.points) p.t += by;
  }

  bool spoil(ImuSample& s) {
    if (name == "gyro_bias_02") s.gyro += Vec3(0.02, -0.02, 0.02);
    if (name == "gyro_bias_10") s.gyro += Vec3(0.1, -0.1, 0.1);
    if (name == "gyro_bias_50") s.gyro += Vec3(0.5, -0.5, 0.5);
    if (name == "gyro_clip_1") s.gyro = s.gyro.cwiseMax(-1.0).cwiseMin(1.0);
    if (name == "gyro_clip_2") s.gyro = s.gyro.cwiseMax(-2.0).cwiseMin(2.0);
    if (name == "gyro_deg") s.gyro *= 180.0 / std::numbers::pi;
    if (name == "gyro_rad") s.gyro *= std::numbers::pi / 180.0;
    if (name == "gyro_double") s.gyro *= 2.0;
    if (name == "acc_bias_3") s.acc += Vec3(3, 0, 0);
    if (name == "acc_g") s.acc /= kStandardGravity;
    if (name == "imu_silent") return to_seconds(s.t - at) >= kSilence;
    if (name == "imu_zero") s.gyro = s.acc = Vec3::Zero();
    if (name == "imu_stuck") {
      if (!held) held = s;
      s.gyro = held->gyro;
      s.acc = held->acc;
    }
    return true;
  }
};

/// Faults of the sensor file.
void spoil(SensorModel& sensor, const std::string& name) {
  const auto turned = [&](const Vec3& axis, double deg) {
    sensor.T_imu_lidar.R = exp_so3(axis * (deg * std::numbers::pi / 180.0)) * sensor.T_imu_lidar.R;
  };
  if (name == "rot_x90") turned(Vec3::UnitX(), 90);
  if (name == "rot_y90") turned(Vec3::UnitY(), 90);
  if (name == "rot_z90") turned(Vec3::UnitZ(), 90);
  if (name == "rot_x180") turned(Vec3::UnitX(), 180);
  if (name == "rot_z180") turned(Vec3::UnitZ(), 180);
  if (name == "rot_z20") turned(Vec3::UnitZ(), 20);
  if (name == "move_x1") sensor.T_imu_lidar.p.x() += 1;
  if (name == "move_y1") sensor.T_imu_lidar.p.y() += 1;
  if (name == "move_z1") sensor.T_imu_lidar.p.z() += 1;
}

/// Writes the signals of every update, with the error since the fault began (of the sensor file: since 2 s; of an IMU
/// that falls silent: since the new start after it).
class Dump final : public pipeline::UpdateObserver {
 public:
  Dump(const std::string& path, const Trajectory& truth, const Fault& fault, TimeNs begin)
      : out_(path), truth_(truth), fault_(fault), begin_(begin), aligned_at_(std::min(fault.at, begin + 2 * kSecond)) {
    if (fault.in_data()) aligned_at_ = fault.at;
    out_ << "t,dt,accepted,segment,tracking,error_m,path_m,fit_rise,match_loss,overlap_loss,pull_rise,misfit"
            ",velocity_pull,gyro_mismatch,mount,view_change,view_jump,unexplained,alarm"
            ",rms,shift_x,shift_y,shift_z,turn_x,turn_y,turn_z\n";
  }

  void on_update(const pipeline::UpdateRecord& r) override {
    const bool cut = fault_.name == "cut" && r.plan.end >= fault_.at;
    const auto truth = truth_.pose(r.plan.end + (cut ? to_ns(kCut) : 0));
    const Pose pose = r.state.pose();
    double error = 0;
    const bool again = !aligned_ || (fault_.name == "imu_silent" && r.segment != *aligned_);
    if (truth && (r.plan.end <= aligned_at_ || again)) {
      align_ = pose * truth->inverse();
      aligned_ = r.segment;
    } else if (truth) {
      error = (pose.p - align_ * truth->p).norm();
      path_ += last_ ? (truth->p - *last_).norm() : 0.0;
    }
    if (truth) last_ = truth->p;
    const pipeline::MonitorSignals& m = r.monitor;
    const NavState& prior = r.update->prior;
    const Vec3 shift = r.state.p - prior.p, turn = log_so3(r.state.R * prior.R.transpose());
    out_ << fmt::format(
        "{:.3f},{:.4f},{},{},{},{:.3f},{:.2f},{:.3f},{:.3f},{:.3f},{:.2f},{:.3f},{:.2f},{:.3f},{:.3f},"
        "{:.3f},{:.2f},{:.3f},{},{:.4f},{:.4f},{:.4f},{:.4f},{:.5f},{:.5f},{:.5f}\n",
        to_seconds(r.plan.end - begin_), to_seconds(r.plan.end - r.plan.fresh_begin), r.update->accepted ? 1 : 0,
        r.segment, pipeline::name(r.tracking), error, path_, m.fit_rise, m.match_loss, m.overlap_loss,
        std::max(m.velocity_pull_rise, m.turn_pull_rise), m.misfit, m.velocity_pull, m.gyro_mismatch, m.mount,
        m.view_change, m.view_jump, std::isfinite(m.unexplained) ? m.unexplained : -1.0, m.alarm ? 1 : 0,
        r.update->residual_rms, shift.x(), shift.y(), shift.z(), turn.x(), turn.y(), turn.z());
  }

 private:
  std::ofstream out_;
  const Trajectory& truth_;
  const Fault& fault_;
  TimeNs begin_, aligned_at_;
  Pose align_;
  std::optional<std::uint32_t> aligned_;  ///< segment that was aligned last
  double path_ = 0;
  std::optional<Vec3> last_;
};

int work(const std::vector<std::string>& a) {
  plugin::Catalog catalog;
  plugins::register_all(catalog);
  std::vector<config::Override> sets;
  for (std::size_t i = 7; i < a.size(); ++i) sets.push_back({a[i]});
  auto sensor = config::load<io::SensorConfig>(a[1], config::FileKind::sensor, catalog).value;
  const auto loaded = config::load<pipeline::PipelineConfig>(a[3], config::FileKind::pipeline, catalog, sets);
  const Trajectory truth(io::read_tum(a[2]));
  const auto source = io::open_source(a[0], sensor);
  SensorModel model = sensor.model;
  spoil(model, a[5]);
  exec::Executor executor(1);
  pipeline::Odometry odometry(loaded.value, {executor, model, std::make_shared<spdlog::logger>("faults"), 0});
  Fault fault{a[5], 0, {}};
  std::unique_ptr<Dump> dump;
  while (auto m = source->next()) {
    if (!dump) {
      const auto* imu = std::get_if<ImuSample>(&*m);
      const TimeNs begin = imu != nullptr ? imu->t : std::get<LidarPacket>(*m).stamp;
      fault.at = begin + to_ns(std::stod(a[6]));
      dump = std::make_unique<Dump>(a[4], truth, fault, begin);
      odometry.add_observer(*dump);
    }
    if (!fault.apply(*m)) continue;
    odometry.push(std::move(*m));
  }
  odometry.finish();
  for (const auto& loss : odometry.losses()) {
    std::cout << fmt::format("lost at {:.3f} s after the fault: {}\n", to_seconds(loss.t - fault.at), loss.reason);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  if (arguments.size() < 7) {
    std::cerr << "monitor_faults RECORDING SENSOR.yaml TRUTH.tum PIPELINE.yaml OUT.csv FAULT AT [OPTION]..\n";
    return 2;
  }
  try {
    return work(arguments);
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
}
