#include "faults/injector.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <utility>

#include "aslio/simulator/random.hpp"

namespace aslio::test::faults {
namespace {

/// Streams of random numbers, one for each kind of noise.
enum Purpose : std::uint64_t { kJitter = 9001, kRange = 9002, kRain = 9003 };

struct Interval {
  TimeNs begin = 0, end = 0;
  bool holds(TimeNs t) const { return t >= begin && t < end; }
};

Interval interval(const Measurements& m, Span span) {
  if (m.empty()) return {};
  const TimeNs begin = stamp_of(m.front()) + to_ns(span.begin);
  return {begin, begin + to_ns(span.length)};
}

/// Calls `visit` with each measurement of type T within the span and its index among them.
template <class T, class Visit>
void each(Measurements& measurements, Span span, Visit&& visit) {
  const Interval within = interval(measurements, span);
  std::size_t index = 0;
  for (Measurement& m : measurements) {
    auto* value = std::get_if<T>(&m);
    if (value != nullptr && within.holds(stamp_of(m))) visit(*value, index++);
  }
}

/// Drops each measurement of type T within the span for which `drop` says so.
template <class T, class Drop>
void drop(Measurements& measurements, Span span, Drop&& drop_it) {
  const Interval within = interval(measurements, span);
  std::size_t index = 0;
  std::erase_if(measurements, [&](const Measurement& m) {
    return std::holds_alternative<T>(m) && within.holds(stamp_of(m)) && drop_it(index++);
  });
}

template <class T>
void repeat(Measurements& measurements, Span span) {
  const Interval within = interval(measurements, span);
  Measurements out;
  out.reserve(measurements.size());
  for (Measurement& m : measurements) {
    const bool twice = std::holds_alternative<T>(m) && within.holds(stamp_of(m));
    if (twice) out.push_back(m);
    out.push_back(std::move(m));
  }
  measurements = std::move(out);
}

void shift_packet(LidarPacket& packet, TimeNs shift) {
  packet.stamp += shift;
  for (TimedPoint& point : packet.points) point.t += shift;
}

void scale(TimedPoint& point, double by) {
  point.x = static_cast<float>(point.x * by);
  point.y = static_cast<float>(point.y * by);
  point.z = static_cast<float>(point.z * by);
}

double range(const TimedPoint& p) { return std::hypot(double{p.x}, double{p.y}, double{p.z}); }

TimeNs last_time(const LidarPacket& packet) {
  TimeNs last = packet.stamp;
  for (const TimedPoint& point : packet.points) last = std::max(last, point.t);
  return last;
}

}  // namespace

TimeNs stamp_of(const Measurement& measurement) {
  const auto* imu = std::get_if<ImuSample>(&measurement);
  return imu != nullptr ? imu->t : std::get<LidarPacket>(measurement).stamp;
}

Fault keep(Span span) {
  return [=](Measurements& m) {
    const Interval within = interval(m, span);
    std::erase_if(m, [&](const Measurement& measurement) { return !within.holds(stamp_of(measurement)); });
  };
}

Fault both(Fault first, Fault second) {
  return [first = std::move(first), second = std::move(second)](Measurements& m) {
    first(m);
    second(m);
  };
}

Fault alter_imu(Span span, std::function<void(ImuSample&, std::size_t)> change) {
  return [=](Measurements& m) { each<ImuSample>(m, span, change); };
}

Fault drop_imu(Span span, std::size_t keep_every) {
  return [=](Measurements& m) {
    drop<ImuSample>(m, span, [=](std::size_t index) { return keep_every == 0 || index % keep_every != 0; });
  };
}

Fault repeat_imu(Span span) {
  return [=](Measurements& m) { repeat<ImuSample>(m, span); };
}

Fault swap_imu(Span span) {
  return [=](Measurements& m) {
    ImuSample* before = nullptr;
    each<ImuSample>(m, span, [&](ImuSample& sample, std::size_t) {
      if (before != nullptr) {
        std::swap(*std::exchange(before, nullptr), sample);
      } else {
        before = &sample;
      }
    });
  };
}

Fault delay_imu(Span span) {
  return [=](Measurements& measurements) {
    const Interval within = interval(measurements, span);
    Measurements out, held;
    for (Measurement& m : measurements) {
      const bool imu = std::holds_alternative<ImuSample>(m);
      if (imu && within.holds(stamp_of(m))) {
        held.push_back(std::move(m));
        continue;
      }
      if (imu && stamp_of(m) >= within.end) {
        out.insert(out.end(), std::make_move_iterator(held.begin()), std::make_move_iterator(held.end()));
        held.clear();
      }
      out.push_back(std::move(m));
    }
    measurements = std::move(out);
  };
}

Fault multiply_imu_rate(std::size_t times) {
  return [=](Measurements& measurements) {
    Measurements out;
    const ImuSample* before = nullptr;
    for (const Measurement& m : measurements) {
      const auto* sample = std::get_if<ImuSample>(&m);
      for (std::size_t k = 1; sample != nullptr && before != nullptr && k < times; ++k) {
        const double share = static_cast<double>(k) / static_cast<double>(times);
        out.push_back(ImuSample{before->t + std::llround(share * static_cast<double>(sample->t - before->t)),
                                (1 - share) * before->gyro + share * sample->gyro,
                                (1 - share) * before->acc + share * sample->acc});
      }
      out.push_back(m);
      if (sample != nullptr) before = sample;
    }
    measurements = std::move(out);
  };
}

Fault freeze_imu(Span span) {
  return [=](Measurements& m) {
    ImuSample held;
    each<ImuSample>(m, span, [&](ImuSample& sample, std::size_t index) {
      if (index == 0) held = sample;
      sample.gyro = held.gyro;
      sample.acc = held.acc;
    });
  };
}

Fault jitter_imu_stamps(Span span, double sigma_s, std::uint64_t seed) {
  return [=](Measurements& m) {
    simulator::RandomStream random(seed, kJitter);
    each<ImuSample>(m, span, [&](ImuSample& sample, std::size_t) { sample.t += to_ns(sigma_s * random.normal()); });
  };
}

Fault clip_imu(Span span, double gyro, double acc) {
  return alter_imu(span, [=](ImuSample& sample, std::size_t) {
    sample.gyro = sample.gyro.cwiseMin(gyro).cwiseMax(-gyro);
    sample.acc = sample.acc.cwiseMin(acc).cwiseMax(-acc);
  });
}

Fault add_gyro_bias(Span span, const Vec3& bias) {
  return alter_imu(span, [=](ImuSample& sample, std::size_t) { sample.gyro += bias; });
}

Fault alter_packets(Span span, std::function<void(LidarPacket&, std::size_t)> change) {
  return [=](Measurements& m) { each<LidarPacket>(m, span, change); };
}

Fault alter_points(Span span, std::function<void(TimedPoint&)> change) {
  return alter_packets(span, [=](LidarPacket& packet, std::size_t) {
    for (TimedPoint& point : packet.points) change(point);
  });
}

Fault drop_packets(Span span) {
  return [=](Measurements& m) { drop<LidarPacket>(m, span, [](std::size_t) { return true; }); };
}

Fault empty_packets(Span span) {
  return alter_packets(span, [](LidarPacket& packet, std::size_t) { packet.points.clear(); });
}

Fault thin_packets(Span span, std::size_t count) {
  return alter_packets(span, [=](LidarPacket& packet, std::size_t) {
    if (packet.points.size() <= count) return;
    std::vector<TimedPoint> left;
    for (std::size_t k = 0; k < count; ++k) left.push_back(packet.points[k * packet.points.size() / count]);
    packet.points = std::move(left);
  });
}

Fault repeat_packets(Span span) {
  return [=](Measurements& m) { repeat<LidarPacket>(m, span); };
}

Fault block_view(Span span, double from, double width) {
  return alter_packets(span, [=](LidarPacket& packet, std::size_t) {
    std::erase_if(packet.points, [=](const TimedPoint& p) {
      const double turn = (std::atan2(p.y, p.x) - from) / (2 * std::numbers::pi);
      return 2 * std::numbers::pi * (turn - std::floor(turn)) < width;
    });
  });
}

Fault add_range_noise(Span span, double sigma, std::uint64_t seed) {
  return [=](Measurements& m) {
    simulator::RandomStream random(seed, kRange);
    alter_points(span, [&](TimedPoint& point) {
      const double r = range(point), error = sigma * random.normal();
      if (r > 0) scale(point, (r + error) / r);
    })(m);
  };
}

Fault add_rain(Span span, double share, double farthest, std::uint64_t seed) {
  return [=](Measurements& m) {
    simulator::RandomStream random(seed, kRain);
    alter_points(span, [&](TimedPoint& point) {
      const double draw = random.uniform(), r = range(point), at = random.uniform(0.5, farthest);
      if (draw < share && r > at) scale(point, at / r);
    })(m);
  };
}

Fault shift_imu_stamps(Span span, TimeNs shift) {
  return alter_imu(span, [=](ImuSample& sample, std::size_t) { sample.t += shift; });
}

Fault shift_packet_stamps(Span span, TimeNs shift) {
  return alter_packets(span, [=](LidarPacket& packet, std::size_t) { shift_packet(packet, shift); });
}

Fault shift_stamps(Span span, TimeNs shift) {
  return [=](Measurements& m) {
    const Interval within = interval(m, span);  // the first may move, too
    for (Measurement& measurement : m) {
      if (!within.holds(stamp_of(measurement))) continue;
      if (auto* imu = std::get_if<ImuSample>(&measurement)) imu->t += shift;
      if (auto* packet = std::get_if<LidarPacket>(&measurement)) shift_packet(*packet, shift);
    }
  };
}

Fault teleport(Span span) {
  return [=](Measurements& m) {
    const Interval cut = interval(m, span);
    std::erase_if(m, [&](const Measurement& measurement) {
      const TimeNs stamp = stamp_of(measurement);
      const auto* packet = std::get_if<LidarPacket>(&measurement);
      if (packet == nullptr) return cut.holds(stamp);
      return stamp < cut.end && last_time(*packet) >= cut.begin;
    });
    const double rest = 1e9 - span.begin - span.length;
    shift_stamps({span.begin + span.length, rest}, cut.begin - cut.end)(m);
  };
}

std::vector<StampedPose> teleported(const std::vector<StampedPose>& truth, TimeNs begin, Span span) {
  const TimeNs from = begin + to_ns(span.begin), until = from + to_ns(span.length);
  std::vector<StampedPose> out;
  for (const StampedPose& pose : truth) {
    if (pose.t < from) out.push_back(pose);
    if (pose.t >= until) out.push_back({pose.t - (until - from), pose.T});
  }
  return out;
}

std::optional<Measurement> VectorSource::next() {
  if (next_ == measurements_.size()) return std::nullopt;
  return std::move(measurements_[next_++]);
}

std::optional<TimeNs> VectorSource::begin_time() const {
  if (measurements_.empty()) return std::nullopt;
  return stamp_of(measurements_.front());
}

std::optional<TimeNs> VectorSource::end_time() const {
  if (measurements_.empty()) return std::nullopt;
  return stamp_of(measurements_.back());
}

Measurements read_all(io::MeasurementSource& source) {
  Measurements out;
  while (auto measurement = source.next()) out.push_back(std::move(*measurement));
  return out;
}

Measurements altered(Measurements recording, const Fault& fault) {
  fault(recording);
  return recording;
}

std::unique_ptr<io::MeasurementSource> altered(io::MeasurementSource& source, const Fault& fault) {
  return std::make_unique<VectorSource>(altered(read_all(source), fault));
}

}  // namespace aslio::test::faults
