// What is injected is what is meant: a fault that changes nothing would be passed by every program.
#include <catch2/catch.hpp>

#include "faults/injector.hpp"

using namespace aslio;
using namespace aslio::test::faults;

namespace {

constexpr TimeNs kStart = 100 * kSecond;

/// 3 s: IMU at 100 Hz, a packet of 10 points every 0.1 s, which arrives when it is complete.
Measurements recording() {
  Measurements out;
  for (int i = 0; i < 300; ++i) {
    const TimeNs t = kStart + TimeNs{i} * 10'000'000;
    out.push_back(ImuSample{t, Vec3(i, 0, 0), Vec3(0, 0, 9.8)});
    if (i % 10 != 9) continue;
    LidarPacket packet;
    packet.stamp = kStart + (i / 10) * kSecond / 10;
    for (int k = 0; k < 10; ++k) {
      TimedPoint point;
      point.x = k < 5 ? 4.0F : -4.0F;
      point.t = packet.stamp + k * 10'000'000;
      packet.points.push_back(point);
    }
    out.push_back(packet);
  }
  return out;
}

template <class T>
std::vector<T> all(const Measurements& measurements) {
  std::vector<T> out;
  for (const Measurement& m : measurements) {
    if (const auto* value = std::get_if<T>(&m)) out.push_back(*value);
  }
  return out;
}

}  // namespace

TEST_CASE("injector: faults of the IMU touch the samples of their span alone") {
  const auto clean = all<ImuSample>(recording());
  const auto imu = [](const Fault& fault) { return all<ImuSample>(altered(recording(), fault)); };
  CHECK(imu(drop_imu({1, 0.5})).size() == 250);
  CHECK(imu(drop_imu({0, 10}, 2)).size() == 150);
  CHECK(imu(repeat_imu({1, 0.5})).size() == 350);
  CHECK(imu(multiply_imu_rate(5)).size() == 299 * 5 + 1);
  const auto swapped = imu(swap_imu({1, 0.02}));
  CHECK(swapped[100].t == clean[101].t);
  CHECK(swapped[101].t == clean[100].t);
  CHECK(swapped[102].t == clean[102].t);
  const auto frozen = imu(freeze_imu({1, 0.5}));
  CHECK(frozen[149].gyro == clean[100].gyro);
  CHECK(frozen[150].gyro == clean[150].gyro);
  CHECK(frozen[149].t == clean[149].t);
  CHECK(imu(clip_imu({0, 10}, 50, 5)).back().gyro.x() == 50);
  const auto jittered = imu(jitter_imu_stamps({1, 1}, 1e-3, 101));
  CHECK(jittered[99].t == clean[99].t);
  CHECK(jittered[100].t != clean[100].t);
  const Measurements late = altered(recording(), delay_imu({1, 0.5}));
  CHECK(late.size() == recording().size());
  CHECK(all<ImuSample>(late)[120].t == clean[120].t);
  CHECK(stamp_of(late[110]) == kStart + kSecond);  // a packet, with no sample before it
  CHECK(std::holds_alternative<LidarPacket>(late[110]));
}

TEST_CASE("injector: faults of the LiDAR touch the packets of their span alone") {
  const auto packets = [](const Fault& fault) { return all<LidarPacket>(altered(recording(), fault)); };
  CHECK(packets(drop_packets({1, 0.5})).size() == 25);
  CHECK(packets(repeat_packets({1, 0.5})).size() == 35);
  CHECK(packets(empty_packets({1, 0.1}))[10].points.empty());
  CHECK(packets(empty_packets({1, 0.1}))[11].points.size() == 10);
  CHECK(packets(thin_packets({1, 0.1}, 3))[10].points.size() == 3);
  const auto blocked = packets(block_view({0, 10}, -1, 2));
  CHECK(blocked[3].points.size() == 5);
  CHECK(blocked[3].points.front().x == -4.0F);
  CHECK(packets(add_range_noise({0, 10}, 0.1, 101))[2].points[0].x != 4.0F);
  const auto rainy = packets(add_rain({0, 10}, 1.0, 2.0, 101));
  for (const TimedPoint& point : rainy[2].points) CHECK(std::abs(point.x) <= 2.0F);
}

TEST_CASE("injector: a jump of the pose is a piece of the data cut out, and the gap closed") {
  const Span cut{1, 1};
  const Measurements jumped = altered(recording(), teleport(cut));
  const auto imu = all<ImuSample>(jumped);
  const auto packets = all<LidarPacket>(jumped);
  CHECK(imu.size() == 200);
  CHECK(packets.size() == 20);
  for (std::size_t i = 1; i < imu.size(); ++i) CHECK(imu[i].t - imu[i - 1].t == 10'000'000);
  CHECK(imu[100].gyro.x() == 200);
  for (std::size_t i = 1; i < packets.size(); ++i) CHECK(packets[i].stamp - packets[i - 1].stamp == kSecond / 10);
  CHECK(packets[10].points[3].t == packets[10].stamp + 30'000'000);
  std::vector<StampedPose> truth;
  for (int i = 0; i <= 30; ++i) truth.push_back({kStart + i * kSecond / 10, Pose{Mat3::Identity(), Vec3(i, 0, 0)}});
  const auto moved = teleported(truth, kStart, cut);
  CHECK(moved.size() == 21);
  CHECK(moved[10].T.p.x() == 20);
  CHECK(moved[10].t == truth[10].t);
}

TEST_CASE("injector: clocks that jump move stamps and points, and the arrival stays") {
  const Measurements clean = recording();
  const Measurements back = altered(recording(), shift_stamps({1, 1e6}, -10 * kSecond));
  REQUIRE(back.size() == clean.size());
  CHECK(stamp_of(back.back()) == stamp_of(clean.back()) - 10 * kSecond);
  CHECK(stamp_of(back.front()) == stamp_of(clean.front()));
  const auto packets = all<LidarPacket>(back);
  CHECK(packets.back().points.back().t - packets.back().stamp == 90'000'000);
  VectorSource source(clean);
  CHECK(read_all(*altered(source, drop_packets({0, 1e6}))).size() == 300);
}
