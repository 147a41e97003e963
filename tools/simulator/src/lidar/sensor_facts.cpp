#include "aslio/simulator/scan_pattern.hpp"

namespace aslio::simulator {
namespace {

constexpr double kRadPerDeg = 0.017453292519943295;

SensorFacts livox_avia() {
  SensorFacts f;
  f.name = "avia";
  f.p_imu_lidar = Vec3(0.04165, 0.02326, -0.0284);
  f.min_range = 0.5;
  f.max_range = 200;
  f.range_noise = 0.02;
  f.angle_noise = 0.025 * kRadPerDeg;
  f.beam_divergence = 0.15 * kRadPerDeg;
  f.footprint_azimuth = 0.03 * kRadPerDeg;
  f.footprint_elevation = 0.28 * kRadPerDeg;
  f.motor = 7294.0 / 60;  // the first prism
  f.lidar_topic = "/livox/lidar";
  f.imu_topic = "/livox/imu";
  f.frame_id = "livox_frame";
  return f;
}

SensorFacts livox_mid360() {
  SensorFacts f = livox_avia();
  f.name = "mid360";
  f.p_imu_lidar = Vec3(-0.011, -0.02329, 0.04412);
  f.min_range = 0.1;
  f.max_range = 70;
  f.angle_noise = 0.05 * kRadPerDeg;
  f.beam_divergence = 0.2 * kRadPerDeg;
  f.footprint_azimuth = 0.15 * kRadPerDeg;
  f.footprint_elevation = 0.25 * kRadPerDeg;
  f.motor = 0;
  return f;
}

/// It has no IMU of its own: the place of the IMU is this project's choice, as with spinning sensors.
SensorFacts livox_mid40() {
  SensorFacts f = livox_avia();
  f.name = "mid40";
  f.p_imu_lidar = Vec3(0, 0, 0.1);
  f.min_range = 1;
  f.max_range = 260;
  f.angle_noise = 0.05 * kRadPerDeg;
  return f;
}

SensorFacts spinning(std::string_view name, double max_range) {
  SensorFacts f;
  f.name = name;
  f.p_imu_lidar = Vec3(0, 0, 0.1);
  f.min_range = 0.5;
  f.max_range = max_range;
  f.range_noise = 0.02;
  f.angle_noise = 0.02 * kRadPerDeg;
  f.beam_divergence = f.footprint_azimuth = 0.17 * kRadPerDeg;
  f.footprint_elevation = 0.09 * kRadPerDeg;
  f.motor = 10;
  f.lidar_topic = "/velodyne_points";
  f.imu_topic = "/imu/data";
  f.frame_id = "velodyne";
  return f;
}

}  // namespace

const SensorFacts& facts(SensorKind kind) {
  static const SensorFacts avia = livox_avia(), mid360 = livox_mid360(), mid40 = livox_mid40();
  static const SensorFacts spin16 = spinning("spin16", 100), spin32 = spinning("spin32", 100);
  static const SensorFacts spin64 = spinning("spin64", 120), vlp16 = spinning("vlp16", 100);
  switch (kind) {
    case SensorKind::mid360:
      return mid360;
    case SensorKind::spin16:
      return spin16;
    case SensorKind::spin32:
      return spin32;
    case SensorKind::spin64:
      return spin64;
    case SensorKind::vlp16:
      return vlp16;
    case SensorKind::mid40:
      return mid40;
    default:
      return avia;
  }
}

}  // namespace aslio::simulator
