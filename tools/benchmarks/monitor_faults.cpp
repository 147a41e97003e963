/// Plays a recording with faults that are put into its measurements, and writes what a monitor could see of every
/// update.
///   monitor_faults RECORDING SENSOR.yaml TRUTH.tum PIPELINE OUT.csv FAULT AT [PIPELINE OPTION]..
/// FAULT: clean, cut, gap, .. (see the table below), from data time AT [s] after the first measurement on.
#include <fmt/format.h>

#include <Eigen/Geometry>
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
#include "aslio/core/trajectory.hpp"
#include "aslio/io/source.hpp"
#include "aslio/io/writers.hpp"
#include "aslio/pipeline/odometry.hpp"
#include "aslio/pipeline/stage_set.hpp"
#include "aslio/pipeline/view_change.hpp"
#include "aslio/stages/motion.hpp"
#include "register_all.hpp"

using namespace aslio;

namespace {

constexpr double kCut = 4.0;  // [s]

/// What becomes of one measurement; `since`: seconds after the fault begins (negative: before).
struct Fault {
  std::string name;
  TimeNs at = 0;
  std::optional<ImuSample> held;

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

void put(std::ostream& out, const Vec3& v) { out << ',' << v.x() << ',' << v.y() << ',' << v.z(); }

class Dump final : public pipeline::UpdateObserver {
 public:
  Dump(const std::string& path, const Trajectory& truth, const Fault& fault, TimeNs begin, const SensorModel& sensor)
      : out_(path), truth_(truth), fault_(fault), begin_(begin), view_(sensor) {
    out_ << "t,dt,status,tracking,accepted,segment,rms,nis,n,matched,n_accepted,sod,e1,e2,e3,e4,e5,e6"
            ",thx,thy,thz,px,py,pz,vx,vy,vz,stx,sty,stz,spx,spy,spz,svx,svy,svz,gx,gy,gz,X,Y,Z,qx,qy,qz,qw"
            ",TX,TY,TZ,tqx,tqy,tqz,tqw,VX,VY,VZ,bwx,bwy,bwz,bax,bay,baz,s0,s1,s2,s3,s4,s5,s6,s7,s8"
            ",ss0,ss1,ss2,ss3,ss4,ss5,ss6,ss7,ss8,d,sd,sbw,sba,n_fresh,insert,gyro_rms,view\n";
    out_.precision(7);
  }
  void take(const ImuSample& s) { imu_.push_back(s); }
  void take(const LidarPacket& p) {
    points_.insert(points_.end(), p.points.begin(), p.points.end());
    std::stable_sort(points_.end() - static_cast<std::ptrdiff_t>(p.points.size()), points_.end(),
                     [](const auto& a, const auto& b) { return a.t < b.t; });
  }

  void on_update(const pipeline::UpdateRecord& r) override {
    const Update& u = *r.update;
    std::size_t matched = 0, accepted = 0;
    for (const MatchRecord& m : u.matches) {
      matched += m.matched ? 1U : 0U;
      accepted += m.accepted ? 1U : 0U;
    }
    out_ << to_seconds(r.plan.end - begin_) << ',' << to_seconds(r.plan.end - r.plan.fresh_begin) << ','
         << pipeline::name(r.status) << ',' << pipeline::name(r.tracking) << ',' << (u.accepted ? 1 : 0) << ','
         << r.segment << ',' << u.residual_rms << ',' << u.nis << ',' << u.matches.size() << ',' << matched << ','
         << accepted << ',' << r.overlap.value.value_or(-1);
    for (const double e : u.spectrum) out_ << ',' << e;
    const Mat3 Rt = u.prior.R.transpose();
    put(out_, log_so3(Rt * u.state.R));
    put(out_, Rt * (u.state.p - u.prior.p));
    put(out_, Rt * (u.state.v - u.prior.v));
    const StateVector sigma = u.P.diagonal().cwiseMax(0.0).cwiseSqrt();
    for (int i = 0; i < 9; ++i) out_ << ',' << sigma[i];
    put(out_, turned(r.plan.fresh_begin, r.plan.end));
    put(out_, u.state.p);
    Eigen::Quaterniond q(u.state.R);
    out_ << ',' << q.x() << ',' << q.y() << ',' << q.z() << ',' << q.w();
    const bool jumped = fault_.name == "cut" && r.plan.end >= fault_.at;
    const Pose truth = truth_.pose(r.plan.end + (jumped ? to_ns(kCut) : 0)).value_or(Pose{});
    put(out_, truth.p);
    q = Eigen::Quaterniond(truth.R);
    out_ << ',' << q.x() << ',' << q.y() << ',' << q.z() << ',' << q.w();
    put(out_, u.state.v);
    put(out_, u.state.b_w);
    put(out_, u.state.b_a);
    for (int i = 0; i < 9; ++i) out_ << ',' << u.state.S_w.data()[i];
    for (int i = 0; i < 9; ++i) out_ << ',' << sigma[block::s + i];
    out_ << ',' << u.state.imu_delay << ',' << sigma[block::d] << ',' << sigma.segment<3>(block::b_w).maxCoeff() << ','
         << sigma.segment<3>(block::b_a).maxCoeff() << ',' << r.n_fresh << ',' << (u.insert ? 1 : 0) << ','
         << r.gyro_rms << ',' << view(r) << '\n';
  }

 private:
  double view(const pipeline::UpdateRecord& r) {
    const auto at = [&](TimeNs t) {
      return std::upper_bound(points_.begin(), points_.end(), t, [](TimeNs a, const auto& p) { return a < p.t; });
    };
    const auto begin = at(r.plan.fresh_begin), end = at(r.plan.end);
    double out = -1;
    if (r.update->trajectory != nullptr) {
      out = view_.add(std::span(begin, end), *r.update->trajectory, r.plan.end).value_or(-1);
    }
    points_.erase(points_.begin(), end);
    return out;
  }
  Vec3 turned(TimeNs begin, TimeNs end) {
    while (next_ + 1 < imu_.size() && imu_[next_ + 1].t <= begin) ++next_;
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = next_; i + 1 < imu_.size() && imu_[i].t < end; ++i) {
      const TimeNs from = std::max(begin, imu_[i].t), to = std::min(end, imu_[i + 1].t);
      if (to > from) sum += to_seconds(to - from) * 0.5 * (imu_[i].gyro + imu_[i + 1].gyro);
    }
    return sum;
  }
  std::ofstream out_;
  const Trajectory& truth_;
  const Fault& fault_;
  TimeNs begin_;
  pipeline::ViewChange view_;
  std::vector<TimedPoint> points_;
  std::vector<ImuSample> imu_;
  std::size_t next_ = 0;
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
      dump = std::make_unique<Dump>(a[4], truth, fault, begin, model);
      odometry.add_observer(*dump);
    }
    if (!fault.apply(*m)) continue;
    std::visit([&](const auto& one) { dump->take(one); }, *m);
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
