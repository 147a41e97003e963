// After two seconds of data the heap is left alone by window, estimator and overlap; only the map and the occupancy
// grow, now and then.
#include <catch2/catch.hpp>
#include <map>

#include "aslio/simulator/analytic_world.hpp"
#include "pipeline/allocation_meter.hpp"
#include "pipeline/runs.hpp"
#include "pipeline/spies.hpp"

using namespace aslio;
using namespace aslio::test;

namespace {

/// Allocations by call, and in how many calls there were any.
class Meter final : public Observer {
 public:
  struct Share {
    std::size_t calls = 0, allocating_calls = 0, allocations = 0;
  };
  void before(const std::string&) override {
    before_ = allocations_metered();
    arm_allocation_meter(true);
  }
  void after(const std::string& call) override {
    arm_allocation_meter(false);
    if (!counting) return;
    const std::size_t made = allocations_metered() - before_;
    Share& share = by_call[call];
    ++share.calls;
    share.allocations += made;
    share.allocating_calls += made > 0 ? 1U : 0U;
  }
  bool counting = false;
  std::map<std::string, Share> by_call;

 private:
  std::size_t before_ = 0;
};

}  // namespace

TEST_CASE("the meter sees both new and the malloc of Eigen") {
  const std::size_t before = allocations_metered();
  arm_allocation_meter(true);
  auto* one = new std::vector<int>(100);
  Eigen::MatrixXd other(static_cast<Eigen::Index>(one->size()), 3);
  arm_allocation_meter(false);
  other.setZero();
  CHECK(allocations_metered() - before == 3);
  delete one;
}

TEST_CASE("no allocation in window, update and overlap after two seconds, map growth is amortised") {
  const std::string name = GENERATE(std::string("as_lio_plus"), std::string("fixed_window"));
  CAPTURE(name);
  // Twice the usual speed: turns of 560 deg/s, rates up to the highest.
  const simulator::AnalyticWorld world({.duration_scale = 0.5});
  const auto source = world.source();
  const Recording recording = record(*source);
  Meter meter;
  const plugin::Catalog catalog = spied(built_in_stages(), meter);
  Run run(shipped(name, {}, catalog), world.sensor());
  run.updates.reserve(2000);
  for (const Measurement& m : recording) {
    const auto* imu = std::get_if<ImuSample>(&m);
    if (imu != nullptr && imu->t > world.begin_time() + to_ns(2.0)) meter.counting = true;
    run.push(m);
  }
  run.finish();
  for (const auto& [call, share] : meter.by_call) {
    UNSCOPED_INFO(call << ": " << share.allocations << " allocations in " << share.allocating_calls << " of "
                       << share.calls << " calls");
  }
  CHECK(meter.by_call["update"].calls >= 75);
  CHECK(meter.by_call["next"].allocations == 0);
  CHECK(meter.by_call["update"].allocations == 0);
  CHECK(meter.by_call["evaluate"].allocations == 0);
  for (const char* growing : {"insert", "extend", "select", "commit"}) {
    CAPTURE(growing);
    const Meter::Share& share = meter.by_call[growing];
    CHECK(4 * share.allocating_calls < share.calls);
  }
}
