#include "pipeline/runs.hpp"

#include <algorithm>

#include "aslio/config/load.hpp"
#include "register_all.hpp"

namespace aslio::test {

Recording record(io::MeasurementSource& source, TimeNs until) {
  Recording recording;
  while (auto measurement = source.next()) {
    const auto* imu = std::get_if<ImuSample>(&*measurement);
    const TimeNs t = imu != nullptr ? imu->t : std::get<LidarPacket>(*measurement).stamp;
    if (t > until) break;
    recording.push_back(std::move(*measurement));
  }
  return recording;
}

Recording repacked(const Recording& recording, TimeNs period) {
  std::vector<TimedPoint> points;
  std::vector<ImuSample> imu;
  for (const Measurement& m : recording) {
    if (const auto* packet = std::get_if<LidarPacket>(&m)) {
      points.insert(points.end(), packet->points.begin(), packet->points.end());
    } else {
      imu.push_back(std::get<ImuSample>(m));
    }
  }
  Recording out;
  std::size_t next_point = 0, next_imu = 0;
  std::uint32_t sweep = 0;
  for (TimeNs begin = points.front().t; next_point < points.size(); begin += period) {
    LidarPacket packet;
    packet.stamp = begin;
    packet.sweep_id = sweep++;
    for (; next_point < points.size() && points[next_point].t < begin + period; ++next_point) {
      packet.points.push_back(points[next_point]);
      packet.points.back().sweep_id = packet.sweep_id;
    }
    for (; next_imu < imu.size() && imu[next_imu].t <= begin + period; ++next_imu) out.push_back(imu[next_imu]);
    if (!packet.points.empty()) out.push_back(std::move(packet));
  }
  for (; next_imu < imu.size(); ++next_imu) out.push_back(imu[next_imu]);
  return out;
}

const plugin::Catalog& built_in_stages() {
  static const plugin::Catalog catalog = [] {
    plugin::Catalog c;
    plugins::register_all(c);
    return c;
  }();
  return catalog;
}

pipeline::PipelineConfig shipped(const std::string& name, const std::vector<std::string>& overrides,
                                 const config::StageLookup& stages) {
  std::vector<config::Override> sets;
  for (const std::string& assignment : overrides) sets.push_back({assignment});
  const std::string path = std::string(ASLIO_SOURCE_DIR) + "/configs/pipelines/" + name + ".yaml";
  return config::load<pipeline::PipelineConfig>(path, config::FileKind::pipeline, stages, sets).value;
}

Run::Run(const pipeline::PipelineConfig& config, const SensorModel& sensor, int threads)
    : sensor_(sensor),
      exec_(threads),
      odometry(config,
               {.exec = exec_, .sensor = sensor_, .log = std::make_shared<spdlog::logger>("test"), .order_seed = 0}) {
  odometry.add_observer(*this);
}

void Run::push(const Measurement& measurement) { odometry.push(Measurement(measurement)); }

Run& Run::play(const Recording& recording) {
  for (const Measurement& measurement : recording) push(measurement);
  finish();
  return *this;
}

void Run::on_update(const pipeline::UpdateRecord& record) {
  P = record.update->P;
  updates.push_back(record);
  updates.back().update = nullptr;
}

std::vector<std::uint64_t> Run::digests() const {
  std::vector<std::uint64_t> out;
  for (const auto& u : updates) out.push_back(u.digest);
  return out;
}

Trajectory Run::trajectory() const {
  std::vector<StampedPose> poses;
  for (const auto& u : updates) poses.push_back({u.plan.end, u.state.pose()});
  return Trajectory(std::move(poses));
}

double Run::rate(TimeNs begin, TimeNs end) const {
  TimeNs covered = 0;
  std::size_t n = 0;
  for (const auto& u : updates) {
    if (u.plan.end <= begin || u.plan.end > end) continue;
    covered += u.plan.end - u.plan.fresh_begin;
    ++n;
  }
  return covered > 0 ? static_cast<double>(n) / to_seconds(covered) : 0.0;
}

const pipeline::UpdateRecord& Run::first_of(std::uint32_t segment) const {
  return *std::find_if(updates.begin(), updates.end(), [&](const auto& u) { return u.segment >= segment; });
}

std::pair<double, double> Run::error_at_end(const std::function<Pose(TimeNs)>& truth, std::uint32_t segment) const {
  const pipeline::UpdateRecord &first = first_of(segment), &last = updates.back();
  const Pose moved = first.state.pose().inverse() * last.state.pose();
  const Pose error = (truth(first.plan.end).inverse() * truth(last.plan.end)).inverse() * moved;
  return {error.p.norm(), log_so3(error.R).norm()};
}

std::size_t Run::count(UpdateStatus status) const {
  return static_cast<std::size_t>(
      std::count_if(updates.begin(), updates.end(), [status](const auto& u) { return u.status == status; }));
}

}  // namespace aslio::test
