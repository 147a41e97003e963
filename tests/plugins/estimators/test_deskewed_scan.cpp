// De-skew and the trajectory of a window.
#include <catch2/catch.hpp>
#include <cmath>

#include "aslio/toolkit/deskewed_scan.hpp"

using namespace aslio;

namespace {

WindowTrajectory turning_trajectory(double rate, int segments, double dt,
                                    WindowTrajectory::Spread spread = WindowTrajectory::Spread::rigid,
                                    double faster = 0) {
  NavState state;
  state.t = 1'700'000'000'000'000'000;
  state.v = Vec3(1.0, 0.2, 0.0);
  WindowTrajectory trajectory(spread);
  trajectory.clear(state);
  for (int i = 0; i < segments; ++i) {
    MotionSegment s;
    s.t = state.t;
    s.dt = dt;
    s.R = state.R;
    s.p = state.p;
    s.v = state.v;
    s.w = Vec3(0.2 * rate, 0.1, rate);
    s.a_W = Vec3(0.5, -1.0, 0.3);
    s.w_dot = faster * Vec3(-10 * rate, 3.0, 20 * rate);
    state.t += to_ns(dt);
    const Pose end = s.pose(state.t);
    state.R = end.R;
    state.p = end.p;
    state.v += dt * s.a_W;
    trajectory.append(s, state);
  }
  return trajectory;
}

}  // namespace

TEST_CASE("de-skew puts a world point where every measurement of it says") {  // eqs. DSK-1, MOT-10
  // From slow turns with a fast IMU to half a radian per IMU step: the series and the closed form; at a rate that is
  // constant between two samples, and one that changes.
  for (const auto& [rate, segments, dt, faster] :
       {std::tuple{0.0, 20, 0.005, 0.0}, std::tuple{4.5, 20, 0.005, 0.0}, std::tuple{5.0, 2, 0.1, 0.0},
        std::tuple{0.0, 20, 0.005, 1.0}, std::tuple{4.5, 20, 0.005, 1.0}, std::tuple{5.0, 2, 0.1, 1.0}}) {
    const WindowTrajectory trajectory = turning_trajectory(rate, segments, dt, WindowTrajectory::Spread::rigid, faster);
    SensorModel sensor;
    sensor.T_imu_lidar = {exp_so3(Vec3(0.1, -0.2, 0.7)), Vec3(0.04, 0.02, -0.03)};
    DeskewedScan frame(sensor);
    const Vec3 target(7, -3, 2);
    std::vector<TimedPoint> raw;
    const TimeNs begin = trajectory.segments().front().t;
    const TimeNs end = trajectory.predicted_end().t;
    for (TimeNs t = begin + 1; t <= end; t += (end - begin) / 97) {
      const Vec3 p_L = (trajectory.pose(t) * sensor.T_imu_lidar).inverse() * target;
      TimedPoint p;
      p.x = static_cast<float>(p_L.x());
      p.y = static_cast<float>(p_L.y());
      p.z = static_cast<float>(p_L.z());
      p.t = t;
      raw.push_back(p);
    }
    SamplerChain keep_all;
    frame.sample_raw(raw, keep_all);
    frame.deskew(trajectory);
    frame.sample_body(keep_all);
    frame.place(trajectory);
    REQUIRE(frame.world(PointUse::match).size() == raw.size());
    for (const WorldPoint& p : frame.world(PointUse::match)) CHECK((p.p_W - target).norm() < 5e-6);
  }
}

namespace {

/// Moves every point by as much.
class Shift final : public Sampler {
 public:
  ActsOn acts_on() const override { return ActsOn::body; }
  bool moves_points() const override { return true; }
  void sample(SampleBatch& batch) override {
    for (Eigen::Vector3f& p : batch.body) p += Eigen::Vector3f(0.25F, 0, 0);
  }
};

}  // namespace

TEST_CASE("points that samplers have moved stay moved when they are de-skewed again") {
  const WindowTrajectory trajectory = turning_trajectory(2.0, 20, 0.005);
  DeskewedScan frame(SensorModel{});
  std::vector<TimedPoint> raw;
  for (int i = 1; i <= 10; ++i) {
    raw.push_back({.x = 3, .y = 1, .z = 0.5F, .t = trajectory.segments().front().t + i * 9'000'000});
  }
  std::vector<std::unique_ptr<Sampler>> chain;
  chain.push_back(std::make_unique<Shift>());
  SamplerChain samplers(std::move(chain));
  for (int window = 0; window < 2; ++window) {  // nor does a window move the points of the next
    StageTimes times;
    frame.load(raw, trajectory, samplers, times);
    const std::vector<Vec3> before(frame.match_body().begin(), frame.match_body().end());
    frame.deskew_matches(trajectory);
    for (std::size_t i = 0; i < before.size(); ++i) CHECK((frame.match_body()[i] - before[i]).norm() < 1e-5);
    frame.place(trajectory);
    const auto world = frame.world(PointUse::map);
    const std::vector<WorldPoint> placed(world.begin(), world.end());
    REQUIRE(placed.size() == raw.size());
    frame.deskew(trajectory);
    frame.place(trajectory);
    for (std::size_t i = 0; i < placed.size(); ++i) {
      CHECK((frame.world(PointUse::map)[i].p_W - placed[i].p_W).norm() < 1e-5);
    }
    SamplerChain none;
    frame.load(raw, trajectory, none, times);
    CHECK((frame.match_body()[0] + Vec3(0.25, 0, 0) - before[0]).norm() < 1e-5);
  }
}

TEST_CASE("points are seen from where the sensor is at the end of the window, not the IMU") {
  const WindowTrajectory trajectory = turning_trajectory(2.0, 20, 0.005);
  SensorModel sensor;
  sensor.T_imu_lidar = {exp_so3(Vec3(0.1, -0.2, 0.7)), Vec3(2, -1, 3)};
  DeskewedScan frame(sensor);
  const TimeNs begin = trajectory.segments().front().t;
  const std::vector<TimedPoint> raw{{.x = 3, .y = 1, .z = 0.5F, .t = begin + 10'000'000},
                                    {.x = -1, .y = 2, .z = 0.2F, .t = begin + 90'000'000}};
  StageTimes times;
  SamplerChain none;
  frame.load(raw, trajectory, none, times);
  frame.place(trajectory);
  const Pose& end = trajectory.corrected_end();
  const Vec3 viewpoint = frame.viewpoint(end);
  CHECK((viewpoint - end * sensor.T_imu_lidar.p).norm() < 1e-12);
  const auto world = frame.world(PointUse::map);
  REQUIRE(world.size() == 2);
  for (const WorldPoint& point : world) {
    CHECK((point.view.vector().cast<double>() - (point.p_W - viewpoint).normalized()).norm() < 0.02);
  }
}

TEST_CASE("points are placed where the corrected trajectory was when they were measured") {  // eq. DSK-2
  using Spread = WindowTrajectory::Spread;
  // Corrections as they come, and one of half a radian: the series and the closed form.
  for (const auto& [spread, correction] :
       {std::pair{Spread::rigid, 1.0}, {Spread::linear, 1.0}, {Spread::linear, 15.0}}) {
    CAPTURE(correction);
    WindowTrajectory trajectory = turning_trajectory(3.0, 20, 0.005, spread);
    SensorModel sensor;
    sensor.T_imu_lidar = {exp_so3(Vec3(0.1, -0.2, 0.7)), Vec3(0.04, 0.02, -0.03)};
    DeskewedScan frame(sensor);
    std::vector<TimedPoint> raw(50);
    for (std::size_t i = 0; i < raw.size(); ++i) {
      raw[i].x = 5.0F;
      raw[i].y = static_cast<float>(i) / 10.0F;
      raw[i].t = trajectory.begin() + (static_cast<TimeNs>(i) + 1) * kSecond / 1000;
    }
    SamplerChain keep_all;
    frame.sample_raw(raw, keep_all);
    frame.deskew(trajectory);
    frame.sample_body(keep_all);
    const Pose end = trajectory.predicted_end().pose();
    trajectory.correct({end.R * exp_so3(correction * Vec3(0.02, -0.03, 0.01)), end.p + Vec3(0.1, 0.2, -0.1)});
    frame.place(trajectory);
    const auto placed = frame.world(PointUse::map);
    REQUIRE(placed.size() == raw.size());
    for (std::size_t i = 0; i < raw.size(); ++i) {
      const Vec3 p_L(raw[i].x, raw[i].y, raw[i].z);
      CHECK((placed[i].p_W - trajectory.pose(raw[i].t) * (sensor.T_imu_lidar * p_L)).norm() < 2e-6);
    }
  }
}

TEST_CASE("a trajectory that is moved as a whole keeps its shape, its correction included") {  // eq. DSK-4
  for (const auto spread : {WindowTrajectory::Spread::rigid, WindowTrajectory::Spread::linear}) {
    WindowTrajectory trajectory = turning_trajectory(3.0, 20, 0.005, spread, 1.0);
    const Pose predicted = trajectory.predicted_end().pose();
    trajectory.correct(predicted.moved((Vec6() << 0.02, -0.03, 0.05, 0.1, -0.2, 0.05).finished()));
    const WindowTrajectory before = trajectory;
    const Pose T{exp_so3(Vec3(0.2, -0.1, 0.7)), Vec3(3, -2, 1)};
    trajectory.move(T);
    const TimeNs begin = before.begin(), end = before.predicted_end().t;
    for (TimeNs t = begin; t <= end; t += (end - begin) / 53) {
      const Pose expected = T * before.pose(t), there = trajectory.pose(t);
      REQUIRE((there.p - expected.p).norm() < 1e-12);
      REQUIRE((there.R - expected.R).norm() < 1e-12);
    }
    CHECK((trajectory.corrected_end().p - T * before.corrected_end().p).norm() < 1e-12);
  }
}

TEST_CASE("the trajectory moves with its end and its Jacobian agrees with central differences") {  // eq. TRJ-1
  const auto spread = GENERATE(WindowTrajectory::Spread::rigid, WindowTrajectory::Spread::linear);
  WindowTrajectory trajectory = turning_trajectory(3.0, 10, 0.01, spread);
  const Pose end{exp_so3(Vec3(0.5, -0.1, 0.3)), Vec3(3, 2, 1)};
  trajectory.correct(end);
  const TimeNs t = trajectory.segments()[4].t + 3'000'000;
  CHECK((trajectory.pose(trajectory.predicted_end().t).p - end.p).norm() < 1e-12);
  if (spread == WindowTrajectory::Spread::linear) {  // what was corrected before stays
    const MotionSegment& first = trajectory.segments().front();
    CHECK((trajectory.pose(first.t).p - first.p).norm() < 1e-12);
    CHECK((trajectory.pose(first.t).R - first.R).norm() < 1e-12);
  }
  Eigen::MatrixXd J;
  trajectory.jacobian(t, J);
  REQUIRE(J.cols() == trajectory.dof());
  const double h = 1e-6;
  for (int i = 0; i < 6; ++i) {
    Vec6 d = Vec6::Zero();
    d[i] = h;
    const auto moved = [&](double sign) {
      trajectory.correct(end.moved(sign * d));
      return trajectory.pose(t);
    };
    const Pose up = moved(1);
    const Pose down = moved(-1);
    Vec6 column;
    column << log_so3(down.R.transpose() * up.R) / (2 * h), (up.p - down.p) / (2 * h);
    CHECK((column - J.col(i)).norm() < 1e-8);
  }
}
