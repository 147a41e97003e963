#include "pipeline/spies.hpp"

namespace aslio::test {

namespace {

/// `inner` as it is, but what it builds is wrapped by a Spy.
template <class Spy, class S>
plugin::Entry wrapped(const plugin::Entry& inner, Observer& observer) {
  plugin::Entry entry = inner;
  entry.make = [make = inner.make, &observer](const void* params, const BuildContext& context) {
    return std::make_unique<Spy>(std::unique_ptr<S>(static_cast<S*>(make(params, context).release())), observer);
  };
  return entry;
}

}  // namespace

plugin::Catalog spied(const plugin::Catalog& real, Observer& observer) {
  plugin::Catalog out;
  for (const std::string& family : real.families()) {
    out.declare(family);
    for (const std::string& type : real.types(family)) {
      const plugin::Entry& entry = *real.find(family, type);
      if (family == WindowStrategy::family) {
        out.add(wrapped<WindowSpy, WindowStrategy>(entry, observer));
      } else if (family == OverlapMetric::family) {
        out.add(wrapped<OverlapSpy, OverlapMetric>(entry, observer));
      } else if (family == HistoryPolicy::family) {
        out.add(wrapped<HistorySpy, HistoryPolicy>(entry, observer));
      } else if (family == Estimator::family) {
        out.add(wrapped<EstimatorSpy, Estimator>(entry, observer));
      } else if (family == Insertion::family) {
        out.add(wrapped<InsertionSpy, Insertion>(entry, observer));
      } else {
        out.add(entry);
      }
    }
  }
  return out;
}

}  // namespace aslio::test
