#include <algorithm>
#include <cmath>

#include "aslio/simulator/simulation.hpp"
#include "lidar/glass.hpp"
#include "mesh/roughness.hpp"

namespace aslio::simulator {
namespace {

constexpr TimeNs kBlock = kSecond / 100;
constexpr std::size_t kFiringsPerView = 8;
constexpr int kMaxPanes = 4;  ///< that one pulse is followed through

/// Casts the firings of one packet. Holds the scratch that they share.
class PacketSimulation {
 public:
  PacketSimulation(const Simulation& simulation, std::size_t index)
      : simulation_(simulation),
        model_(simulation.scene().lidar, facts(simulation.sensor_kind()), simulation.options().seed, index,
               simulation.realism()),
        beams_(simulation.pattern().beams_per_firing()),
        pulses_(beams_.size()),
        directions_(beams_.size()),
        hits_(beams_.size()) {}

  SimulatedPacket run(std::size_t index) {
    const TimeNs begin = static_cast<TimeNs>(index) * Simulation::kPacketPeriod;
    const TimeNs end = std::min(begin + Simulation::kPacketPeriod, to_ns(simulation_.duration()));
    const TimeNs period = simulation_.pattern().firing_period();
    out_.packet.stamp = simulation_.begin_time() + begin;
    out_.packet.sweep_id = static_cast<std::uint32_t>(index);
    out_.packet.points.reserve(static_cast<std::size_t>((end - begin) / period + 1) * beams_.size());
    for (TimeNs t = (begin + period - 1) / period * period; t < end; t += period) {
      if (const TimeNs block = t - (t - begin) % kBlock; out_.blocks.empty() || block != block_) {
        block_ = block;
        out_.blocks.push_back({simulation_.begin_time() + block, {}, 0});
        out_.blocks.back().cells.reserve(static_cast<std::size_t>(kBlock / period + 1) * beams_.size());
      }
      fire(t);
    }
    return std::move(out_);
  }

 private:
  void fire(TimeNs since) {
    const double t = t_ = to_seconds(since);
    const MotionState m = simulation_.motion().at(t);
    const Pose T_W_L = Pose{m.R, m.p} * simulation_.sensor().T_imu_lidar;
    simulation_.pattern().fire(since, beams_);
    for (std::size_t k = 0; k < beams_.size(); ++k) {
      pulses_[k] = model_.emit(beams_[k], k, t);
      directions_[k] = T_W_L.R * pulses_[k].direction;
    }
    cast(T_W_L);
    simulation_.people().in_view(t, T_W_L.p, directions_, bodies_);
    simulation_.cars().in_view(t, T_W_L.p, directions_, cars_);
    out_.rays += beams_.size();
    in_view_ = firings_++ % kFiringsPerView == 0;
    for (std::size_t k = 0; k < beams_.size(); ++k) receive(since, k, T_W_L);
  }

  Vec3 origin(std::size_t k, const Pose& T_W_L) const { return T_W_L.p + beams_[k].height * T_W_L.R.col(2); }

  void cast(const Pose& T_W_L) {
    if (!simulation_.pattern().has_heights()) {
      simulation_.caster().cast(T_W_L.p, directions_, model_.max_range(), hits_);
      for (std::size_t k = 0; k < hits_.size(); ++k) simulation_.roughness().apply(T_W_L.p, directions_[k], hits_[k]);
      return;
    }
    for (std::size_t k = 0; k < hits_.size(); ++k)
      hits_[k] = cast_static(origin(k, T_W_L), directions_[k], model_.max_range());
  }

  SurfaceHit cast_static(const Vec3& from, const Vec3& direction, double max_range) const {
    SurfaceHit hit = simulation_.caster().cast(from, direction, max_range);
    simulation_.roughness().apply(from, direction, hit);
    return hit;
  }

  /// People and cars on the way of a pulse. Those in view of the beams were found before; behind a mirror others are.
  void cast_moving(const Vec3& from, const Vec3& direction, bool mirrored, SurfaceHit& hit) {
    if (mirrored) {
      simulation_.people().in_view(t_, from, {&direction, 1}, behind_mirror_);
      simulation_.cars().in_view(t_, from, {&direction, 1}, cars_behind_mirror_);
    }
    cast_people(mirrored ? behind_mirror_ : bodies_, from, direction, hit);
    cast_cars(mirrored ? cars_behind_mirror_ : cars_, from, direction, hit);
  }

  /// Follows a pulse through panes and mirrors; the range is that of the whole way. True: by a mirror, so that what it
  /// reports is not there.
  bool follow_glass(const Vec3& from, Vec3 direction, double draw, SurfaceHit& hit) {
    const double clear = simulation_.realism().glass;
    bool mirrored = false;
    Vec3 at = from;
    double way = 0;
    for (int panes = 0; panes < kMaxPanes && is_glass(hit); ++panes) {
      const PaneEffect effect = pane_effect(draw, clear, hit.cos_incidence);
      if (effect == PaneEffect::returned) break;
      const double share = clear * mirrored_share(hit.cos_incidence);
      at += (hit.range - way) * direction;
      way = hit.range;
      if (effect == PaneEffect::mirrored) {
        mirrored = true;
        direction -= 2 * direction.dot(hit.normal) * hit.normal;
        draw /= share;
        hit = behind(at, direction, way, mirrored);
      } else {
        draw = (draw - share) / (clear - share);
        hit = behind(at, direction, way, mirrored);
        // The other face of the same pane.
        if (is_glass(hit) && hit.range - way < kPaneThickness) {
          at += (hit.range - way) * direction;
          way = hit.range;
          hit = behind(at, direction, way, mirrored);
        }
      }
    }
    return mirrored;
  }

  /// What a pulse meets that goes on from a pane.
  SurfaceHit behind(const Vec3& at, const Vec3& direction, double way, bool mirrored) {
    const Vec3 start = at + kBehindPane * direction;
    SurfaceHit hit = cast_static(start, direction, model_.max_range() - way);
    cast_moving(start, direction, mirrored, hit);
    hit.range += way + kBehindPane;
    return hit;
  }

  void receive(TimeNs since, std::size_t k, const Pose& T_W_L) {
    SurfaceHit& hit = hits_[k];
    const Vec3 from = origin(k, T_W_L);
    const Pulse& pulse = pulses_[k];
    cast_moving(from, directions_[k], false, hit);
    const bool mirrored = follow_glass(from, directions_[k], pulse.glass, hit);
    if (hit.moving) {
      ++out_.blocks.back().people_rays;
    } else if (std::isfinite(hit.range) && !mirrored) {
      const Vec3 p_W = from + hit.range * directions_[k];
      out_.blocks.back().cells.push_back(cell_key(p_W));
      if (in_view_) out_.view.push_back(p_W.cast<float>());
    }
    SurfaceHit second;
    if (pulse.mixed) {
      const Vec3 direction = T_W_L.R * pulse.second;
      second = cast_static(from, direction, model_.max_range());
      cast_moving(from, direction, false, second);
      follow_glass(from, direction, pulse.glass, second);
    }
    const std::optional<Return> received = model_.receive(pulse, hit, second);
    if (!received) return;
    Vec3 p_L = received->range * beams_[k].direction;
    if (beams_[k].height != 0) p_L.z() += beams_[k].height;
    TimedPoint point;
    point.x = static_cast<float>(p_L.x());
    point.y = static_cast<float>(p_L.y());
    point.z = static_cast<float>(p_L.z());
    point.intensity = received->intensity;
    point.t = simulation_.begin_time() + since;
    point.sweep_id = out_.packet.sweep_id;
    point.line = static_cast<std::uint8_t>(k);
    point.tag = received->tag;
    out_.packet.points.push_back(point);
  }

  const Simulation& simulation_;
  ReturnModel model_;
  std::vector<Beam> beams_;
  std::vector<Pulse> pulses_;
  std::vector<Vec3> directions_;
  std::vector<SurfaceHit> hits_;
  std::vector<Body> bodies_;
  std::vector<CarBody> cars_;
  std::vector<Body> behind_mirror_;
  std::vector<CarBody> cars_behind_mirror_;
  double t_ = 0;  ///< of the firing, since the start [s]
  std::size_t firings_ = 0;
  TimeNs block_ = 0;
  bool in_view_ = false;
  SimulatedPacket out_;
};

}  // namespace

SimulatedPacket Simulation::packet(std::size_t index) const { return PacketSimulation(*this, index).run(index); }

}  // namespace aslio::simulator
