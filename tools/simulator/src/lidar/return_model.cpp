#include "aslio/simulator/return_model.hpp"

#include <algorithm>
#include <cmath>

#include "aslio/core/angles.hpp"
#include "purposes.hpp"
#include "range_errors.hpp"

namespace aslio::simulator {
namespace {

/// Surfaces nearer to each other along the beam than the first merge into one return; farther apart than the second
/// they are told apart, and the nearer one is reported.
constexpr double kSameSurface = 0.15, kToldApart = 1.5;  // [m]
/// Share of the weak range over which returns fade.
constexpr double kFade = 0.3;

double cosine(double degrees) { return std::cos(degrees * kRadPerDeg); }

}  // namespace

ReturnModel::ReturnModel(const LidarParams& params, const SensorFacts& sensor, std::uint64_t seed, std::uint64_t packet,
                         const Realism& realism)
    : params_(params),
      range_noise_(params.range_noise.value_or(sensor.range_noise)),
      angle_noise_(params.angle_noise ? *params.angle_noise * kRadPerDeg : sensor.angle_noise),
      min_range_(params.min_range.value_or(sensor.min_range)),
      max_range_(params.max_range.value_or(sensor.max_range)),
      cos_grazing_begin_(cosine(params.grazing_begin)),
      cos_grazing_end_(cosine(params.grazing_end)),
      spread_azimuth_(sensor.beam_divergence),
      spread_elevation_(sensor.beam_divergence),
      range_(seed, purpose::kRange, packet),
      angle_(seed, purpose::kAngle, packet),
      loss_(seed, purpose::kDropout, packet),
      outlier_(seed, purpose::kOutlier, packet),
      mixed_(seed, purpose::kMixedPixel, packet),
      glass_(seed, purpose::kGlass, packet),
      footprint_(realism.footprint > 0) {
  if (footprint_) {
    params_.mixed = 1;
    spread_azimuth_ = realism.footprint * sensor.footprint_azimuth;
    spread_elevation_ = realism.footprint * sensor.footprint_elevation;
  }
  if (params.noise) errors_ = std::make_unique<RangeErrors>(realism.ranging, seed);
}

ReturnModel::~ReturnModel() = default;

Pulse ReturnModel::emit(const Beam& beam, std::size_t line, double t) {
  Pulse pulse;
  pulse.direction = beam.direction;
  pulse.glass = glass_.uniform();
  if (!params_.noise) return pulse;
  const double along_azimuth = angle_noise_ * angle_.normal(), along_elevation = angle_noise_ * angle_.normal();
  const auto deflected = [&](double azimuth, double elevation) -> Vec3 {
    return (beam.direction + azimuth * beam.azimuth + elevation * beam.elevation).normalized();
  };
  pulse.direction = deflected(along_azimuth, along_elevation);
  pulse.range_error = range_noise_ * range_.normal();
  pulse.lost = loss_.uniform() < params_.dropout;
  pulse.keep = loss_.uniform();
  const bool outlier = outlier_.uniform() < params_.outliers;
  const double where = outlier_.uniform();
  if (outlier) pulse.outlier_range = where;
  pulse.mixed = mixed_.uniform() < params_.mixed;
  const double u = mixed_.uniform(-0.5, 0.5), v = mixed_.uniform(-0.5, 0.5);
  pulse.mix = mixed_.uniform();
  if (pulse.mixed)
    pulse.second = deflected(along_azimuth + spread_azimuth_ * u, along_elevation + spread_elevation_ * v);
  pulse.bias = errors_->standing(line, t);
  return pulse;
}

std::optional<Return> ReturnModel::receive(const Pulse& pulse, const SurfaceHit& hit, const SurfaceHit& second) const {
  if (pulse.lost) return std::nullopt;
  // A footprint at an edge against the sky returns with the share of it that the surface covers.
  const bool covered = footprint_ && pulse.mixed && !std::isfinite(hit.range) && std::isfinite(second.range);
  if (covered) return pulse.mix < 0.5 ? reported(pulse, second, second.range) : std::nullopt;
  if (!std::isfinite(hit.range)) return std::nullopt;
  double range = hit.range;
  if (pulse.mixed && std::isfinite(second.range)) {
    const double apart = std::abs(second.range - hit.range);
    if (apart > kToldApart) {
      range = std::min(hit.range, second.range);
    } else if (apart > kSameSurface) {
      range = pulse.mix * hit.range + (1 - pulse.mix) * second.range;
    }
  }
  // The surface that the range is of decides on the echo.
  const bool of_second =
      footprint_ && range != hit.range && std::abs(range - second.range) < std::abs(range - hit.range);
  return reported(pulse, of_second ? second : hit, range);
}

std::optional<Return> ReturnModel::reported(const Pulse& pulse, const SurfaceHit& hit, double range) const {
  // What is left of the pulse: by incidence, and by range against what the surface sends back.
  const double steep =
      std::clamp((hit.cos_incidence - cos_grazing_end_) / (cos_grazing_begin_ - cos_grazing_end_), 0.0, 1.0);
  const double echo = hit.reflectivity * hit.cos_incidence;
  const double reach = params_.weak_range * std::sqrt(echo / 0.1);
  const double near = std::clamp(1 + (reach - range) / (kFade * reach + 1e-9), 0.0, 1.0);
  if (steep <= 0 || near <= 0 || pulse.keep > steep * near) return std::nullopt;
  if (errors_) {
    range += errors_->noise(range, reach) * pulse.range_error + pulse.bias +
             errors_->of_echo(range, hit.cos_incidence, hit.reflectivity);
  }
  if (pulse.outlier_range >= 0) range = min_range_ + pulse.outlier_range * (range - min_range_);
  if (range < min_range_ || range > max_range_) return std::nullopt;
  Return report;
  report.range = range;
  report.intensity = static_cast<std::uint8_t>(std::lround(std::min(255.0, 255 * echo)));
  return report;
}

}  // namespace aslio::simulator
