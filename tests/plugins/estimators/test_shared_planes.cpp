// Matches of one plane of the map share its error, whatever the windows are (eq. RES-5).
#include <catch2/catch.hpp>

#include "plugins/estimators/room_filter.hpp"

using namespace aslio;
using namespace aslio::test;

namespace {

constexpr TimeNs kTenth = kSecond / 10;

/// Information of the least known direction after one update of `points` over `length`.
double least_known(const std::string& plane_sigma, TimeNs length, int points, const std::string& shared_time = "0.1") {
  const std::string residual = "{type: point_to_plane, planes: map, plane_sigma: " + plane_sigma + "}";
  const std::string estimator = "estimator={type: ieskf, shared_time: " + shared_time + ", residual: " + residual + "}";
  Filter filter({estimator, "map={type: voxel_plane}"}, 0.01);
  filter.build_map(1);
  const Update& found = filter.update(RoomWindow(kRoomEpoch, length, Pose{}, 2, points));
  REQUIRE(found.accepted);
  return found.spectrum[0];
}

}  // namespace

TEST_CASE("however many points a window has, it knows no more than the planes it sees") {
  // Without an error in common, five times the points know five times as much; with one of 1 m, hardly more.
  CHECK(least_known("0", kTenth, 10000) > 4.0 * least_known("0", kTenth, 2000));
  CHECK(least_known("1", kTenth, 10000) < 1.5 * least_known("1", kTenth, 2000));
}

TEST_CASE("a view cut into shorter windows knows no more than the whole, since its planes stay the same") {
  // Five windows of a fifth of the points each.
  const double whole = least_known("1", kTenth, 10000), part = least_known("1", kTenth / 5, 2000);
  CHECK(5.0 * part < 1.5 * whole);
  CHECK(5.0 * part > 0.5 * whole);
  // Over half that time, half of the error is new: as if the view had seen the planes twice.
  const double half = least_known("1", kTenth / 5, 2000, "0.05");
  CHECK(half == Approx(2.0 * part).epsilon(0.05));
}
