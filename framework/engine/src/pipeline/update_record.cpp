#include "aslio/pipeline/update_record.hpp"

#include <cstring>

namespace aslio::pipeline {

std::string_view name(UpdateStatus status) {
  switch (status) {
    case UpdateStatus::ok:
      return "ok";
    case UpdateStatus::initialising:
      return "initialising";
    case UpdateStatus::few_matches:
      return "few_matches";
    case UpdateStatus::degenerate:
      return "degenerate";
    case UpdateStatus::not_converged:
      return "not_converged";
    case UpdateStatus::non_finite:
      return "non_finite";
  }
  return "?";
}

std::string_view name(TrackingStatus status) {
  switch (status) {
    case TrackingStatus::initialising:
      return "initialising";
    case TrackingStatus::ok:
      return "ok";
    case TrackingStatus::degraded:
      return "degraded";
    case TrackingStatus::lost:
      return "lost";
    case TrackingStatus::recovering:
      return "recovering";
  }
  return "?";
}

std::string_view name(RunStatus status) {
  switch (status) {
    case RunStatus::ok:
      return "ok";
    case RunStatus::degraded:
      return "degraded";
    case RunStatus::truncated:
      return "truncated";
    case RunStatus::interrupted:
      return "interrupted";
    case RunStatus::diverged:
      return "diverged";
    case RunStatus::failed:
      return "failed";
  }
  return "?";
}

std::uint64_t state_digest(const NavState& state) {
  std::uint64_t hash = 0xcbf29ce484222325ULL;  // FNV-1a over the bits of every component
  const auto add = [&hash](const void* bytes, std::size_t size) {
    const auto* byte = static_cast<const unsigned char*>(bytes);
    for (std::size_t i = 0; i < size; ++i) hash = (hash ^ byte[i]) * 0x100000001b3ULL;
  };
  add(&state.t, sizeof state.t);
  add(state.R.data(), 9 * sizeof(double));
  for (const Vec3* v : {&state.p, &state.v, &state.b_w, &state.b_a, &state.g}) add(v->data(), 3 * sizeof(double));
  add(state.S_w.data(), 9 * sizeof(double));
  add(&state.imu_delay, sizeof state.imu_delay);
  return hash;
}

}  // namespace aslio::pipeline
