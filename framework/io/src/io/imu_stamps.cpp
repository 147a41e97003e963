#include "imu_stamps.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "aslio/core/errors.hpp"

namespace aslio::io {
namespace {

bool same_values(const ImuSample& a, const ImuSample& b) { return a.gyro == b.gyro && a.acc == b.acc; }

/// Runs of samples that follow each other with one stamp; copies of the sample before do not count.
struct Packets {
  std::vector<TimeNs> stamps;
  std::size_t samples = 0;
  bool whole_seconds = true;

  explicit Packets(std::span<const ImuSample> all) {
    for (std::size_t i = 0; i < all.size(); ++i) {
      const bool first = stamps.empty() || all[i].t != stamps.back();
      if (!first && same_values(all[i], all[i - 1])) continue;
      if (first) stamps.push_back(all[i].t);
      ++samples;
      whole_seconds = whole_seconds && all[i].t % kSecond == 0;
    }
  }
  double per_stamp() const { return static_cast<double>(samples) / static_cast<double>(stamps.size()); }
  TimeNs median_step() const {
    std::vector<TimeNs> steps;
    for (std::size_t i = 1; i < stamps.size(); ++i) steps.push_back(stamps[i] - stamps[i - 1]);
    if (steps.empty()) return 0;
    const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
    std::nth_element(steps.begin(), middle, steps.end());
    return *middle;
  }
};

}  // namespace

ImuStamps judge_imu_stamps(std::span<const ImuSample> samples, const std::string& where) {
  constexpr std::size_t kEnough = 20;  // samples
  constexpr double kBurst = 1.5, kMaxBurst = 20;
  const Packets packets(samples);
  if (packets.samples < kEnough) return {};
  constexpr const char* kRemedy = "set `stamps: received` to take the times of recording";
  if (packets.stamps.size() == 1) {
    throw DataError(fmt::format("{}: the first {} samples all have the stamp {} ns: the driver does not fill it; {}",
                                where, packets.samples, packets.stamps.front(), kRemedy));
  }
  if (packets.per_stamp() > kMaxBurst || (packets.whole_seconds && packets.per_stamp() > kBurst)) {
    throw DataError(fmt::format("{}: the first {} samples have only {} stamps{}: the driver does not fill them; {}",
                                where, packets.samples, packets.stamps.size(),
                                packets.whole_seconds ? ", all of whole seconds" : "", kRemedy));
  }
  if (packets.per_stamp() <= kBurst || packets.median_step() <= 0) return {};
  return {
      packets.median_step(),
      fmt::format(
          "imu stamps: {:.1f} samples share one, that of a packet; they are spread over the {:.3f} ms between packets",
          packets.per_stamp(), 1e3 * to_seconds(packets.median_step()))};
}

void ImuSpreader::add(const ImuSample& sample, std::vector<ImuSample>& out) {
  if (period_ == 0) {
    out.push_back(sample);
    return;
  }
  if (!packet_.empty() && packet_.front().t != sample.t) flush(out);
  if (packet_.empty() || !same_values(packet_.back(), sample)) packet_.push_back(sample);
}

void ImuSpreader::flush(std::vector<ImuSample>& out) {
  const auto n = static_cast<TimeNs>(packet_.size());
  for (TimeNs i = 0; i < n; ++i) {
    ImuSample& sample = packet_[static_cast<std::size_t>(i)];
    sample.t -= (n - 1 - i) * period_ / n;
    out.push_back(sample);
  }
  packet_.clear();
}

}  // namespace aslio::io
