// Matches of one plane of the map share its error, whatever the windows are (eq. RES-5).
#include <catch2/catch.hpp>

#include "plugins/estimators/room_filter.hpp"

using namespace aslio;
using namespace aslio::test;

namespace {

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

/// Trace of the position's covariance [m^2] after one update of 2000 points whose window holds `old` points, too.
double position_variance(const std::string& plane_sigma, int old) {
  const std::string residual = "{type: point_to_plane, planes: map, plane_sigma: " + plane_sigma + "}";
  Filter filter({"estimator={type: ieskf, residual: " + residual + "}", "map={type: voxel_plane}"}, 3.0);
  filter.build_map(1);
  std::vector<HistoryPoint> points;
  for (const WorldPoint& p : wall_points(old)) {
    points.push_back({.p_W = p.p_W, .t = kRoomEpoch, .range = static_cast<float>(p.p_W.norm()), .sequence = 5});
  }
  const Update& found = filter.update(RoomWindow(kRoomEpoch, kTenth, Pose{}, 6, 2000),
                                      {.points = points, .max_stamp = 5, .covariance = HistoryCovariance::all});
  REQUIRE(found.accepted);
  REQUIRE(found.history_matches > static_cast<std::uint32_t>(old) / 2);
  return found.P.block<3, 3>(block::p, block::p).trace();
}

/// Trace of the position's covariance [m^2] after a window of 7000 points that a smoother takes in `parts` slices.
double position_variance_in_parts(const std::string& plane_sigma, int parts) {
  const std::string residual = "{type: point_to_plane, planes: map, plane_sigma: " + plane_sigma + "}";
  Filter filter({"estimator={type: smoother, residual: " + residual + "}", "map={type: voxel_plane}"}, 3.0);
  filter.build_map(1);
  RoomWindow room(kRoomEpoch, kTenth, Pose{}, 2, 7000);
  cut(room, parts);
  const Update& found = filter.update(room);
  REQUIRE(found.accepted);
  return found.P.block<3, 3>(block::p, block::p).trace();
}

}  // namespace

TEST_CASE("however many slices a smoother has, together they know no more than the planes they see") {
  const double free = position_variance_in_parts("0", 1), free_cut = position_variance_in_parts("0", 7);
  const double shared = position_variance_in_parts("0.2", 1), shared_cut = position_variance_in_parts("0.2", 7);
  CHECK(shared > 10 * free);
  CHECK(shared_cut / shared > 0.7 * free_cut / free);
}

TEST_CASE("old points of a window, as fresh ones, know no more than the planes they lie on") {
  CHECK(position_variance("0", 20000) < 0.3 * position_variance("0", 1000));
  CHECK(position_variance("1", 20000) > 0.7 * position_variance("1", 1000));
  // They count once more: what fresh points say of a plane does not silence them.
  CHECK(position_variance("1", 20000) < 0.8 * position_variance("1", 1));
}

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
