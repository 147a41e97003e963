#include "aslio/toolkit/point_uses.hpp"

namespace aslio {

void describe_uses(config::Binder& b, UseNames& uses) {
  b.removed("taps", "use uses");
  b.texts("uses", uses, {"overlap", "map", "match"}, "the consumers of points it acts for");
  b.require(!uses.empty(), "uses", "must name at least one of overlap, map, match; remove the sampler to thin nothing");
}

PointUses use_mask(const UseNames& uses) {
  PointUses bits = 0;
  for (const std::string& name : uses) {
    bits = static_cast<PointUses>(bits | mask(name == "overlap" ? PointUse::overlap
                                              : name == "map"   ? PointUse::map
                                                                : PointUse::match));
  }
  return bits;
}

}  // namespace aslio
