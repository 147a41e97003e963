// Matches farther off than the prior and the noise allow take no part (eq. IESKF-11).
#include <catch2/catch.hpp>

#include "plugins/estimators/room_filter.hpp"

using namespace aslio;
using namespace aslio::test;

namespace {

const std::vector<std::string> kUngated = {"estimator.sigma=0.02"};
const std::vector<std::string> kGated = {"estimator.sigma=0.02", "estimator.innovation_gate=3"};

struct Found {
  Vec3 p;
  std::uint32_t matches;
  std::ptrdiff_t recorded;  ///< matches that histories and telemetry are told of
};

/// The room from `T`, of which one point in four ahead is 0.15 m too near, by a filter that begins at rest at the
/// origin and knows its velocity to `sigma_velocity` [m/s].
Found locate(const std::vector<std::string>& overrides, const Pose& T, double sigma_velocity) {
  Filter filter(overrides, sigma_velocity);
  filter.build_map(1);
  RoomWindow room(kRoomEpoch, kTenth, T, 2);
  for (TimedPoint& p : room.fresh) {
    if (p.x < 2.0F || p.index % 4 != 0) continue;
    const float nearer = 1.0F - 0.15F / std::sqrt(p.x * p.x + p.y * p.y + p.z * p.z);
    p.x *= nearer;
    p.y *= nearer;
    p.z *= nearer;
  }
  const Update& update = filter.update(room);
  REQUIRE(update.accepted);
  const auto took_part = [](const MatchRecord& match) { return match.accepted; };
  return {update.state.p, update.fresh_matches, std::count_if(update.matches.begin(), update.matches.end(), took_part)};
}

}  // namespace

TEST_CASE("what lies off the walls by more than a certain prior allows does not pull") {
  const Found gated = locate(kGated, Pose{}, 0.01), ungated = locate(kUngated, Pose{}, 0.01);
  CHECK(gated.p.norm() < 1e-3);
  CHECK(ungated.p.norm() > 5 * gated.p.norm());
  CHECK(gated.matches < ungated.matches);
  CHECK(gated.matches > 900);  // the walls themselves are all matched
  CHECK(gated.recorded == gated.matches);
  CHECK(ungated.recorded == ungated.matches);
}

TEST_CASE("an uncertain prior opens the gate: a start in motion finds its place") {
  const Pose away{Mat3::Identity(), Vec3(0.12, -0.08, 0.05)};
  const Found uncertain = locate(kGated, away, 3.0);
  CHECK((uncertain.p - away.p).norm() < 0.02);
  // A filter that holds itself to be at rest refuses what says otherwise.
  CHECK((locate(kGated, away, 0.01).p - away.p).norm() > 3 * (uncertain.p - away.p).norm());
}

TEST_CASE("a match of several rows takes part as a whole or not at all") {
  // Nearest points, which lie along the walls by up to some decimetres from what they match.
  const std::string points = "estimator.residual={type: point_to_point, gate: 0, kernel: none}";
  const Found gated = locate({"estimator.sigma=0.02", "estimator.innovation_gate=3", points}, Pose{}, 0.01);
  const Found ungated = locate({"estimator.sigma=0.02", points}, Pose{}, 0.01);
  CHECK(gated.matches < ungated.matches);
  CHECK(gated.matches > 100);
  CHECK(static_cast<std::uint32_t>(gated.recorded) == gated.matches);
}
