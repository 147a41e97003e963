#include "aslio/experiment/truth.hpp"

#include <fmt/format.h>

#include "aslio/experiment/measure.hpp"

namespace aslio::experiment {

namespace {

/// Positions farther from their origin lose digits when they are squared, and in the floats of a page [m].
constexpr double kFar = 10'000;

evaluation::Rule rule_of(io::Association association) {
  switch (association) {
    case io::Association::nearest:
      return evaluation::Rule::evo;
    case io::Association::at_reference:
      return evaluation::Rule::at_reference;
    case io::Association::interpolated:
      break;
  }
  return evaluation::Rule::interpolated;
}

void move_origin(std::vector<StampedPose>& poses, Truth& truth) {
  const Vec3 first = poses.front().T.p;
  if (first.norm() < kFar) return;
  truth.origin = first;
  for (StampedPose& pose : poses) pose.T.p -= first;
  truth.notes.push_back(
      fmt::format("positions from the first on, which is ({:.3f}, {:.3f}, {:.3f}) m", first.x(), first.y(), first.z()));
}

}  // namespace

Truth load_truth(const io::ReferenceSpec& spec, const io::SensorConfig* sensor) {
  const io::ReferenceSpec effective = io::with_protocol(spec);
  const Pose T_imu_reference =
      io::pose_in_imu(effective, sensor != nullptr ? sensor->all_transforms() : std::vector<io::NamedTransform>{});
  io::Reference read = io::read_reference(effective);
  Truth truth;
  truth.spec = io::in_place(effective, T_imu_reference);
  truth.positions_only = read.positions_only;
  truth.notes = std::move(read.notes);
  truth.warnings = std::move(read.warnings);
  move_origin(read.poses, truth);
  if (truth.positions_only) {
    truth.point = T_imu_reference.p;
  } else {
    const Pose T_reference_imu = T_imu_reference.inverse();
    const bool moves = !T_imu_reference.p.isZero(0) || !T_imu_reference.R.isIdentity(0);
    for (StampedPose& pose : read.poses) pose.T = moves ? pose.T * T_reference_imu : pose.T;
  }
  if (!T_imu_reference.p.isZero(0) || !T_imu_reference.R.isIdentity(0)) {
    truth.notes.push_back(fmt::format("reference {} at ({:.4f}, {:.4f}, {:.4f}) m in the IMU frame",
                                      truth.positions_only ? "point" : "frame", T_imu_reference.p.x(),
                                      T_imu_reference.p.y(), T_imu_reference.p.z()));
  }
  truth.trajectory = Trajectory(std::move(read.poses));
  return truth;
}

std::vector<StampedPose> Truth::comparable(std::span<const StampedPose> imu) const {
  std::vector<StampedPose> poses(imu.begin(), imu.end());
  if (!positions_only || point.isZero(0)) return poses;
  for (StampedPose& pose : poses) pose.T.p += pose.T.R * point;
  return poses;
}

evaluation::Options Truth::options() const {
  evaluation::Options options = measuring_options(trajectory, rule_of(spec.association));
  if (spec.max_gap) options.max_reference_gap = *spec.max_gap;
  if (spec.max_neighbour) options.max_neighbour = *spec.max_neighbour;
  options.evo_max_difference = spec.max_difference;
  options.positions_only = positions_only;
  options.reference_origin = origin;
  // The rules of the data sets weigh every pair alike.
  options.weight_by_time = spec.protocol == io::Protocol::none;
  if (spec.protocol == io::Protocol::hilti_2022) options.scoring = evaluation::Scoring::hilti_2022;
  if (spec.protocol == io::Protocol::hilti_2023) options.scoring = evaluation::Scoring::hilti_2023;
  return options;
}

evaluation::Evaluation evaluate_against(const Truth& truth, std::span<const StampedPose> imu,
                                        const evaluation::Options& options) {
  auto result = evaluation::evaluate(Trajectory(truth.comparable(imu)), truth.trajectory, options);
  result.warnings.insert(result.warnings.begin(), truth.warnings.begin(), truth.warnings.end());
  result.notes = truth.notes;
  return result;
}

}  // namespace aslio::experiment
