// Poses inside a slice of the smoother, and what its points tell of the two ends.
#include <catch2/catch.hpp>
#include <random>

#include "estimators/slice_path.hpp"

using namespace aslio;
using namespace aslio::plugins;

namespace {

constexpr TimeNs kStart = 1'000 * kSecond, kPart = 5'000'000;

/// A slice of four IMU intervals between two poses: in W, velocities and accelerations stay as they are when the begin
/// moves, and attitudes turn with it.
SlicePath path_between(TimeNs start, const Pose& begin, const Pose& end) {
  NavState state;
  state.t = start;
  state.R = begin.R;
  state.p = begin.p;
  SlicePath path;
  path.clear(state, start + 4 * kPart);
  for (int i = 0; i < 4; ++i) {
    const MotionSegment segment{state.t,
                                to_seconds(kPart),
                                state.R,
                                state.p,
                                Vec3(1.0, -0.5 * i, 0.3),
                                Vec3(3, 1 - i, 2),
                                Vec3(2, -1, 0.5 * i),
                                Vec3(-40, 70, 20 * i)};
    const Pose after = segment.pose(state.t + kPart);
    state.t += kPart;
    state.R = after.R;
    state.p = after.p;
    path.append(segment, state);
  }
  NavState found = state;
  found.R = end.R;
  found.p = end.p;
  path.meet(found);
  return path;
}

struct Ends {
  Pose a{exp_so3(Vec3(0.3, -0.2, 0.5)), Vec3(1, 2, 3)};
  Pose b{exp_so3(Vec3(0.4, -0.15, 0.55)), Vec3(1.03, 1.98, 3.01)};
  Pose c{exp_so3(Vec3(0.45, -0.1, 0.58)), Vec3(1.05, 1.97, 3.03)};

  void move(const Eigen::VectorXd& by) {
    for (const auto& [pose, at] : {std::pair{&a, 0}, {&b, 6}, {&c, 12}}) {
      pose->R = pose->R * exp_so3(by.segment<3>(at));
      pose->p += by.segment<3>(at + 3);
    }
  }
};

struct TwoSlices {
  explicit TwoSlices(const Ends& ends)
      : first(path_between(kStart, ends.a, ends.b)), second(path_between(kStart + 4 * kPart, ends.b, ends.c)) {
    chain.append(first);
    chain.append(second);
  }
  TwoSlices(const TwoSlices&) = delete;
  SlicePath first, second;
  SliceChain chain;
};

Eigen::VectorXd unit(int at, double step) {
  Eigen::VectorXd by = Eigen::VectorXd::Zero(18);
  by[at] = step;
  return by;
}

}  // namespace

TEST_CASE("a slice begins and ends where its states are, and its Jacobian is that of its poses") {  // eq. SMO-1
  const TwoSlices two{Ends{}};
  CHECK(two.chain.dof() == 18);
  CHECK((two.chain.pose(kStart).p - Ends{}.a.p).norm() < 1e-12);
  CHECK((two.chain.pose(kStart + 4 * kPart).R - Ends{}.b.R).norm() < 1e-12);
  CHECK((two.chain.pose(kStart + 8 * kPart).p - Ends{}.c.p).norm() < 1e-12);
  constexpr double step = 1e-6;
  for (const TimeNs after : {TimeNs{1}, kPart / 3, 2 * kPart, 4 * kPart, 4 * kPart + kPart / 2, 7 * kPart, 8 * kPart}) {
    const TimeNs t = kStart + after;
    CAPTURE(after);
    Eigen::MatrixXd jacobian;
    two.chain.jacobian(t, jacobian);
    for (int k = 0; k < 18; ++k) {
      Ends more, less;
      more.move(unit(k, step));
      less.move(unit(k, -step));
      const Pose up = TwoSlices(more).chain.pose(t), down = TwoSlices(less).chain.pose(t);
      Vec6 slope;
      slope << log_so3(down.R.transpose() * up.R), up.p - down.p;
      CHECK((jacobian.col(k) - slope / (2 * step)).norm() < 1e-8);
    }
  }
}

TEST_CASE("points lie where the pose of their time places them") {  // eq. SMO-1
  const TwoSlices two{Ends{}};
  std::vector<Vec3> body, world(40), lever(40);
  std::vector<double> share(40);
  std::vector<TimeNs> times;
  for (int i = 0; i < 40; ++i) {
    body.emplace_back(5.0 - i, 2.0, 0.1 * i);
    times.push_back(kStart + 1 + i * kPart / 10);
  }
  two.first.place(body, times, world, lever, share);
  for (std::size_t i = 0; i < 40; ++i) {
    const Pose here = two.first.pose(times[i]);
    CHECK((world[i] - here * body[i]).norm() < 1e-10);
    CHECK((lever[i] - here.R * body[i]).norm() < 1e-10);
    CHECK(share[i] == two.first.share(times[i]));
  }
}

TEST_CASE("the sums over a slice are those of rows for both of its ends") {  // eq. SMO-1
  // Ends that the IMU has met: what is left out, the turn of a row by the small correction, is zero there.
  Ends ends;
  ends.b = path_between(kStart, ends.a, ends.a).predicted().pose();
  const SlicePath path = path_between(kStart, ends.a, ends.b);
  std::mt19937 random(4);
  std::normal_distribution<double> normal;
  const auto vector = [&] { return Vec3(normal(random), normal(random), normal(random)); };
  SliceInformation sums;
  EndsMatrix A = EndsMatrix::Zero();
  EndsVector b = EndsVector::Zero();
  double squares = 0;
  for (int i = 0; i < 30; ++i) {
    const TimeNs t = kStart + 1 + (i * 4 * kPart) / 30;
    const Vec3 p = 5 * vector(), u = vector().normalized();
    const double z = 0.1 * normal(random), information = 1.0 + i;
    EndsVector h;
    for (int k = 0; k < kEndsDim; ++k) {
      constexpr double step = 1e-6;
      Ends more = ends, less = ends;
      more.move(unit(k, step));
      less.move(unit(k, -step));
      const Vec3 up = path_between(kStart, more.a, more.b).pose(t) * p;
      const Vec3 down = path_between(kStart, less.a, less.b).pose(t) * p;
      h[k] = u.dot(up - down) / (2 * step);
    }
    A += information * h * h.transpose();
    b += information * z * h;
    squares += information * z * z;
    sums.add(path.pose(t).R * p, path.share(t), u, z, information);
  }
  SliceEquations told;
  sums.tell(ends.a.R, ends.b.R, told);
  CHECK((told.A - A).norm() < 1e-6 * A.norm());
  CHECK((told.b - b).norm() < 1e-6 * b.norm());
  CHECK(told.weighted_sum == Approx(squares));
}
