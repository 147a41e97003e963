#include "aslio/toolkit/taps.hpp"

namespace aslio {

void describe_taps(config::Binder& b, TapNames& taps) {
  b.texts("taps", taps, {"overlap", "map", "match"}, "the consumers of points it acts for");
  b.require(!taps.empty(), "taps", "must name at least one of overlap, map, match; remove the sampler to thin nothing");
}

TapMask tap_mask(const TapNames& taps) {
  TapMask bits = 0;
  for (const std::string& name : taps) {
    bits = static_cast<TapMask>(bits | mask(name == "overlap" ? Tap::overlap : name == "map" ? Tap::map : Tap::match));
  }
  return bits;
}

}  // namespace aslio
