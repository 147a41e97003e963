// The nearest point: rows, gate, kernel, and the Jacobian.
#include <catch2/catch.hpp>
#include <limits>

#include "plugins/build_environment.hpp"
#include "residuals/point_to_point.hpp"

using namespace aslio;
using plugins::PointToPoint;

namespace {

struct OneMatch {
  explicit OneMatch(const PointToPoint::Params& params, const Vec3& offset, bool found = true)
      : residual(params, environment.context()) {
    neighbours.resize(1, 1);
    neighbours.count[0] = found ? 1 : 0;
    neighbours.offsets[0] = offset.cast<float>();
    residual.fit(query, neighbours, surface);
  }
  std::vector<ResidualRow> rows(const Vec3& at, double sigma) {
    std::vector<ResidualRow> out(3);
    const std::vector<Vec3> world{at};
    const std::vector<float> range{5.0F};
    residual.evaluate(world, range, surface, sigma, out);
    return out;
  }
  test::BuildEnvironment environment;
  PointToPoint residual;
  std::vector<Vec3> query{Vec3(100, 200, 300)};
  Neighbours neighbours;
  std::vector<Surface> surface{1};
};

}  // namespace

TEST_CASE(
    "point_to_point: three rows that point away from the nearest point, with the weight of their length") {  // eq.
                                                                                                             // RES-2
  OneMatch match({}, Vec3(0.25, -0.5, 0.125));
  const double sigma = 0.5;
  const Vec3 r(-0.25, 0.5, -0.125);
  const auto rows = match.rows(match.query[0], sigma);
  const double bell = sigma / (sigma + r.squaredNorm());
  for (int axis = 0; axis < 3; ++axis) {
    const ResidualRow& row = rows[static_cast<std::size_t>(axis)];
    CHECK(row.r == Approx(r[axis]));
    CHECK(row.J == Vec3::Unit(axis));
    CHECK(row.information == Approx(bell * bell / (sigma * sigma)));
    // Central difference of r over p_W.
    const double h = 1e-4;
    const double slope = (match.rows(match.query[0] + h * row.J, sigma)[static_cast<std::size_t>(axis)].r -
                          match.rows(match.query[0] - h * row.J, sigma)[static_cast<std::size_t>(axis)].r) /
                         (2 * h);
    CHECK(slope == Approx(1.0));
  }
}

TEST_CASE("point_to_point: nothing found, too far, not finite") {
  OneMatch nothing({}, Vec3::Zero(), false);
  CHECK(nothing.rows(nothing.query[0], 1.0)[0].information == 0);
  OneMatch match({.gate = 3.0}, Vec3(0.3, 0, 0));
  CHECK(match.rows(match.query[0], 0.11)[0].information > 0);
  CHECK(match.rows(match.query[0], 0.09)[0].information == 0);
  OneMatch open({.gate = 0, .kernel = PointToPoint::Kernel::none}, Vec3(0.3, 0, 0));
  CHECK(open.rows(open.query[0], 0.1)[0].information == Approx(100.0));
  CHECK(open.rows(Vec3::Constant(std::numeric_limits<double>::quiet_NaN()), 0.1)[0].information == 0);
  CHECK(open.residual.query().k == 1);
  CHECK(open.residual.rows_per_match() == 3);
}
