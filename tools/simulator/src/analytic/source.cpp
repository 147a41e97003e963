#include <algorithm>
#include <cmath>

#include "aslio/simulator/analytic_world.hpp"
#include "aslio/simulator/avia.hpp"
#include "aslio/simulator/random.hpp"
#include "purposes.hpp"

namespace aslio::simulator {
namespace {

constexpr TimeNs kPacketPeriod = kSecond / 10;
constexpr std::uint8_t kSingleReturn = 0x10;

/// Casts the rays of one packet after the other.
class LidarSimulation {
 public:
  explicit LidarSimulation(const AnalyticWorld& world)
      : world_(world),
        range_(world.options().seed, purpose::kRange),
        angle_(world.options().seed, purpose::kAngle),
        dropout_(world.options().seed, purpose::kDropout) {}

  /// Firings in [begin, end).
  LidarPacket packet(std::uint32_t sweep_id, TimeNs begin, TimeNs end) {
    LidarPacket out;
    out.stamp = begin;
    out.sweep_id = sweep_id;
    out.points.reserve(static_cast<std::size_t>((end - begin) / avia::kFiringPeriod) * avia::kLines);
    for (TimeNs t = begin; t < end; t += avia::kFiringPeriod) fire(t, out);
    return out;
  }

 private:
  void fire(TimeNs t, LidarPacket& out) {
    const Pose T_W_L = world_.pose(t) * world_.sensor().T_imu_lidar;
    const std::vector<Box> people = world_.people(t);
    const auto beams = avia::firing(to_seconds(t - world_.begin_time()));
    for (std::size_t line = 0; line < beams.size(); ++line) {
      const LidarNoise& noise = world_.lidar_noise();
      Vec3 direction = beams[line].direction;
      double range_error = 0;
      bool lost = false;
      if (world_.options().lidar_noise) {
        // The beam leaves in a direction slightly off the one that is reported.
        direction += noise.angle * angle_.normal() * beams[line].azimuth;
        direction += noise.angle * angle_.normal() * beams[line].elevation;
        direction.normalize();
        range_error = noise.range * range_.normal();
        lost = dropout_.uniform() < noise.dropout;
      }
      const Hit hit = world_.scene().cast(T_W_L.p, T_W_L.R * direction, people);
      const double range = hit.range + range_error;
      lost = lost || hit.solid < 0 || hit.cos_incidence < noise.max_incidence_cos;
      if (lost || range < world_.sensor().min_range || range > world_.sensor().max_range) continue;
      out.points.push_back(returned(beams[line].direction * range, hit, t, out.sweep_id, line));
    }
  }

  static TimedPoint returned(const Vec3& p_L, const Hit& hit, TimeNs t, std::uint32_t sweep_id, std::size_t line) {
    TimedPoint p;
    p.x = static_cast<float>(p_L.x());
    p.y = static_cast<float>(p_L.y());
    p.z = static_cast<float>(p_L.z());
    p.intensity = static_cast<float>(std::round(255 * hit.reflectivity * hit.cos_incidence));
    p.t = t;
    p.sweep_id = sweep_id;
    p.line = static_cast<std::uint8_t>(line);
    p.tag = kSingleReturn;
    return p;
  }

  const AnalyticWorld& world_;
  RandomStream range_, angle_, dropout_;
};

class WorldSource final : public io::MeasurementSource {
 public:
  explicit WorldSource(const AnalyticWorld& world) : world_(world), lidar_(world), packet_begin_(world.begin_time()) {}

  std::optional<Measurement> next() override {
    const auto& samples = world_.imu().samples;
    const bool packets_left = packet_begin_ < world_.end_time();
    const TimeNs packet_end = std::min(packet_begin_ + kPacketPeriod, world_.end_time());
    if (next_imu_ < samples.size() && (!packets_left || samples[next_imu_].t <= packet_end))
      return samples[next_imu_++];
    if (!packets_left) return std::nullopt;
    LidarPacket packet = lidar_.packet(sweep_id_++, packet_begin_, packet_end);
    packet_begin_ = packet_end;
    return packet;
  }

  io::InputStatus status() const override { return io::InputStatus::complete; }
  const io::SourceNotes& notes() const override { return notes_; }
  std::optional<TimeNs> begin_time() const override { return world_.begin_time(); }
  std::optional<TimeNs> end_time() const override { return world_.end_time(); }

 private:
  const AnalyticWorld& world_;
  LidarSimulation lidar_;
  io::SourceNotes notes_;
  std::size_t next_imu_ = 0;
  std::uint32_t sweep_id_ = 0;
  TimeNs packet_begin_;
};

}  // namespace

std::unique_ptr<io::MeasurementSource> AnalyticWorld::source() const { return std::make_unique<WorldSource>(*this); }

}  // namespace aslio::simulator
