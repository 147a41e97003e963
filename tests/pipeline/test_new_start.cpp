// Where a run goes on after it was lost. eq. INI-5.
#include <Eigen/LU>
#include <catch2/catch.hpp>

#include "aslio/pipeline/new_start.hpp"

using namespace aslio;
using namespace aslio::pipeline;

namespace {

constexpr TimeNs kEpoch = 1'700'000'000 * kSecond;
const Vec3 kUp(0, 0, kStandardGravity);

/// Dead-reckons to one state, whenever that is.
class Reckoner final : public Estimator {
 public:
  explicit Reckoner(bool uses_imu = true) : uses_imu_(uses_imu) {}
  bool uses_imu() const override { return uses_imu_; }
  void reset(const InitialState&) override {}
  void adopt(const InertialEstimate&) override {}
  const Update& update(const Window&, const HistorySelection&, const StepContext&) override { return update_; }
  const NavState& state() const override { return reckoned; }
  NavState predict(std::span<const ImuSample>) const override { return reckoned; }

  NavState reckoned;

 private:
  bool uses_imu_;
  Update update_;
};

TimeNs at(double t) { return kEpoch + to_ns(t); }

/// IMU data that are still to arrive, the last estimator, and what was known at the loss.
struct Lost {
  explicit Lost(double lost, bool uses_imu = true) : estimator(uses_imu) {
    known.lost = at(lost);
    known.accepted = at(lost) - kSecond;
    known.pose = {exp_so3(Vec3(0, 0, 0.7)) * exp_so3(Vec3(0.2, 0, 0)), Vec3(4, 5, 6)};
    estimator.reckoned.v = Vec3(1, 2, 0);
    estimator.reckoned.p = Vec3(7, 8, 9);
    estimator.reckoned.R = exp_so3(Vec3(0, 0, 0.9));
    estimator.reckoned.b_w = Vec3(0.01, 0, 0);
  }
  /// Samples every 5 ms in [begin, end); `shaken`: as of a walk.
  Lost& imu(double begin, double end, const Vec3& acc, bool shaken = false) {
    for (int k = 0; begin + 0.005 * k < end - 1e-9; ++k) {
      const Vec3 shake = shaken ? Vec3(k % 2 == 0 ? 1.0 : -1.0, 0, 0) : Vec3(0, 0, 0);
      stream.push(ImuSample{at(begin + 0.005 * k), Vec3::Zero(), acc + shake});
    }
    return *this;
  }
  Lost& believes_its_state() {
    known.state = estimator.reckoned;
    known.state->t = known.lost - kSecond / 10;
    return *this;
  }
  std::optional<Initialisation> find() { return NewStart(known, params, SensorModel{}).find(stream, estimator); }

  stream::MeasurementStream stream;
  Reckoner estimator;
  LastKnown known;
  InitialisationParams params;
};

}  // namespace

TEST_CASE(
    "new start: at rest, from samples after the loss, at the last place, with the last heading and the tilt of now") {
  Lost lost(1.2);
  lost.imu(0, 1.0, kUp).imu(1.0, 2.0, Vec3(0, kStandardGravity, 0)).estimator.reckoned.v.setZero();
  lost.known.pose.R = exp_so3(Vec3(0, 0, 0.7)) * exp_so3(Vec3(1.4, 0, 0));  // its y axis points up, almost
  lost.estimator.reckoned.R = lost.known.pose.R;
  lost.estimator.reckoned.p = lost.known.pose.p;
  const auto found = lost.believes_its_state().find();
  REQUIRE(found);
  const InitialState& initial = found->initial;
  CHECK(initial.state.t == at(1.3));
  CHECK(initial.mode == InitialMode::static_start);
  CHECK(initial.sigma_velocity == Approx(0.05));
  CHECK(initial.state.p == lost.known.pose.p);
  CHECK((initial.state.R * Vec3(0, 1, 0) - Vec3::UnitZ()).norm() < 1e-12);
  // Turned no further than it takes to bring y up.
  CHECK(log_so3(initial.state.R * lost.known.pose.R.transpose()).norm() ==
        Approx(std::acos(-1) / 2 - 1.4).margin(1e-9));
  lost.known.lost = at(1.95);
  CHECK_FALSE(lost.find());  // not yet
}

TEST_CASE("new start: an acceleration that cannot be gravity is passed over, and the search goes on where it stood") {
  Lost lost(0.0);
  NewStart all_at_once(lost.known, lost.params, SensorModel{}), bit_by_bit = all_at_once;
  for (int k = 0; k < 200; ++k) {
    const double t = 0.005 * k;
    lost.imu(t, t + 0.005, t < 0.52 ? Vec3(30.0 * kUp) : kUp);
    const auto found = bit_by_bit.find(lost.stream, lost.estimator);
    if (!found) {
      // What has been searched may be forgotten.
      lost.stream.release(bit_by_bit.keep_imu_from());
      CHECK(lost.stream.buffered_imu() < 40);
      continue;
    }
    Lost whole(0.0);
    whole.imu(0, 0.52, 30.0 * kUp).imu(0.52, 1.0, kUp);
    const auto same = all_at_once.find(whole.stream, whole.estimator);
    REQUIRE(same);
    CHECK(found->initial.state.t == same->initial.state.t);
    CHECK(found->initial.state.t == at(0.7));
    return;
  }
  FAIL("no start was found");
}

TEST_CASE("new start: without IMU at the next point, with the whole attitude that was known") {
  Lost lost(0.2, false);
  lost.stream.leave_imu_out();
  CHECK_FALSE(lost.find());
  LidarPacket packet;
  packet.stamp = at(0.5);
  for (const double t : {0.5, 0.6}) {
    TimedPoint point;
    point.x = 3;
    point.t = at(t);
    packet.points.push_back(point);
  }
  lost.stream.push(std::move(packet));
  const auto found = lost.find();
  REQUIRE(found);
  CHECK(found->initial.state.t == at(0.5) - 1);
  CHECK(found->initial.state.R == lost.known.pose.R);
  CHECK(found->initial.state.p == lost.known.pose.p);
}

TEST_CASE("new start: in motion it recalls what was dead-reckoned, the less surely the longer that was") {
  Lost soon(10.0), late(10.0), cold(10.0);
  late.known.accepted = at(0.0);
  for (Lost* lost : {&soon, &late, &cold}) lost->imu(9.0, 11.0, kUp, true);
  const auto a = soon.believes_its_state().find(), b = late.believes_its_state().find(), c = cold.find();
  REQUIRE((a && b && c));
  CHECK(a->initial.mode == InitialMode::dynamic_start);  // the velocity is still looked for
  CHECK(a->initial.state.t == at(10.1));
  CHECK(a->initial.state.R == soon.estimator.reckoned.R);
  CHECK(a->initial.state.v == Vec3(1, 2, 0));
  CHECK(a->initial.state.p == Vec3(7, 8, 9));
  CHECK(a->initial.state.b_w == Vec3(0.01, 0, 0));
  CHECK(a->initial.sigma_velocity == Approx(0.3 + 0.11));
  CHECK(b->initial.sigma_velocity == Approx(0.3 + 1.01));
  CHECK(a->initial.sigma_tilt < b->initial.sigma_tilt);
  CHECK(b->initial.state.p == late.known.pose.p);  // after ten seconds a position is worth no more than the last
  CHECK(c->initial.state.v == Vec3::Zero());
  CHECK(c->initial.sigma_velocity == 3.0);
  CHECK(c->initial.state.p == cold.known.pose.p);

  Lost tilted(10.0);
  tilted.imu(9.0, 11.0, kUp, true).estimator.reckoned.R = exp_so3(Vec3(0.5, 0, 0));  // 29 deg from the vertical of now
  const auto d = tilted.believes_its_state().find();
  REQUIRE(d);
  CHECK(d->initial.state.v == Vec3::Zero());
  CHECK(d->initial.sigma_velocity == 3.0);
}

TEST_CASE("new start: a quiet IMU is no rest where dead reckoning has a speed, whatever the recording began with") {
  Lost cruise(10.0);
  cruise.params.mode = InitialisationMode::static_start;
  cruise.imu(9.0, 11.0, kUp).believes_its_state();
  const auto moving = cruise.find();
  REQUIRE(moving);
  CHECK(moving->initial.mode == InitialMode::dynamic_start);
  CHECK(moving->initial.state.v == Vec3(1, 2, 0));

  Lost slow(10.0);
  slow.imu(9.0, 11.0, kUp).estimator.reckoned.v = Vec3(0.3, 0, 0);
  const auto resting = slow.believes_its_state().find();
  REQUIRE(resting);
  CHECK(resting->initial.mode == InitialMode::static_start);
  CHECK(resting->initial.state.v == Vec3::Zero());
  CHECK(resting->initial.sigma_velocity == Approx(0.3));  // it may yet be one

  Lost unknown(10.0), too_fast(10.0);
  unknown.imu(9.0, 11.0, kUp);
  too_fast.imu(9.0, 11.0, kUp).estimator.reckoned.v = Vec3(31, 0, 0);
  for (Lost* lost : {&unknown, &too_fast.believes_its_state()}) {
    const auto open = lost->find();
    REQUIRE(open);
    CHECK(open->initial.mode == InitialMode::dynamic_start);
    CHECK(open->initial.state.v == Vec3::Zero());
    CHECK(open->initial.sigma_velocity == 3.0);
  }
}

TEST_CASE("new start: dead reckoning over more than half a minute, or over a gap of the IMU, is forgotten") {
  Lost long_ago(10.0), torn(10.0);
  long_ago.imu(9.0, 11.0, kUp, true).believes_its_state().known.state->t = at(10.1) - NewStart::kLongestReckoning - 1;
  torn.imu(9.0, 9.95, kUp, true).imu(10.2, 11.0, kUp, true).believes_its_state();
  for (Lost* lost : {&long_ago, &torn}) {
    const auto found = lost->find();
    REQUIRE(found);
    CHECK(found->initial.sigma_velocity == 3.0);
  }
}
