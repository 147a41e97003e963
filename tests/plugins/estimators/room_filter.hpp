#pragma once
/// An estimator, `ieskf` unless the first override names another, in the room of room.hpp.

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "aslio/pipeline/odometry.hpp"
#include "pipeline/runs.hpp"
#include "plugins/estimators/room.hpp"
#include "plugins/estimators/unknown_residual.hpp"
#include "plugins/overlaps/one_stage.hpp"

namespace aslio::test {

/// A history in which every point has the given weight.
class ConstantHistory final : public HistoryPolicy {
 public:
  explicit ConstantHistory(double weight = 1.0) : weight_(weight) {}
  HistorySelection select(const Window&) override { return {}; }
  double weight(std::size_t, std::size_t) const override { return weight_; }
  double gate(double sigma) const override { return 3 * sigma; }
  void commit(const Window&, const Update&) override {}
  void reset() override {}

 private:
  double weight_;
};

/// At the origin, with a gyro bias and a velocity that nobody knows.
inline InitialState start_in_motion() {
  InitialState initial;
  initial.state.t = kRoomEpoch;
  initial.state.b_w = Vec3(0.001, 0.002, -0.001);
  initial.mode = InitialMode::dynamic_start;
  initial.sigma_velocity = 3.0;
  return initial;
}

/// The filter in the room, at the origin and at rest.
struct Filter {
  explicit Filter(const std::vector<std::string>& overrides = {}, double sigma_velocity = 0.05,
                  bool imu_is_known = false, const Vec3& gravity = Vec3(0, 0, -kStandardGravity), int threads = 1)
      : environment(threads) {
    environment.sensor.T_imu_lidar = Pose{};
    // Defaults, whatever the shipped files are tuned to.
    const auto is_map = [](const std::string& text) { return text.starts_with("map="); };
    std::vector<std::string> all;
    if (std::none_of(overrides.begin(), overrides.end(), is_map)) all.emplace_back("map={type: voxel_hash}");
    const bool other = !overrides.empty() && overrides.front().starts_with("estimator=");
    if (!other) all.emplace_back("estimator={type: ieskf}");
    all.insert(all.end(), overrides.begin(), overrides.end());
    const pipeline::PipelineConfig config = shipped("as_lio_plus", all, catalog);
    estimator = config.estimator.make(environment.context());
    map = config.map.make(environment.context());
    initial.state.t = kRoomEpoch;
    initial.state.g = gravity;
    initial.sigma_velocity = sigma_velocity;
    if (imu_is_known) initial.sigma_acc_bias = initial.sigma_tilt = initial.sigma_gyro_bias = 1e-4;
    estimator->reset(initial);
  }
  void add_sampler(const std::string& text) {
    std::vector<std::unique_ptr<Sampler>> chain;
    chain.push_back(make_stage<Sampler>(catalog, text, environment.context()));
    samplers = SamplerChain(std::move(chain));
  }
  void build_map(std::uint32_t stamp) { map->insert(wall_points(20000), stamp); }
  const Update& update(const RoomWindow& room, const HistorySelection& past = {}) {
    return estimator->update(room.window, past, {samplers, *map, history});
  }

  const plugin::Catalog catalog = stages_and_unknown();
  BuildEnvironment environment;
  SamplerChain samplers;
  ConstantHistory history;
  InitialState initial;
  std::unique_ptr<Estimator> estimator;
  std::unique_ptr<Map> map;
};

}  // namespace aslio::test
