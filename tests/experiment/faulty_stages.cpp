// `faulty`: a window that takes its process down, or its time, or its memory, or throws; an overlap that gives up on
// the way; and a residual that is not a number.
#include <chrono>
#include <cstdlib>
#include <limits>
#include <stdexcept>
#include <thread>
#include <vector>

#include "aslio/config/binder.hpp"
#include "aslio/plugin/entry.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/stages/overlap.hpp"
#include "aslio/stages/residual.hpp"
#include "aslio/stages/window.hpp"

namespace {

using namespace aslio;

class FaultyWindow final : public WindowStrategy {
 public:
  enum class Fault : std::uint8_t {
    crash,
    hang,
    memory,
    slow,
    throws,
    throws_int,
    made_throws_int,
    throws_where_none_may
  };
  struct Params {
    Fault fault = Fault::crash;
  };

  static void describe(config::Binder& b, Params& p) {
    b.choice("fault", p.fault,
             {{"crash", Fault::crash},
              {"hang", Fault::hang},
              {"memory", Fault::memory},
              {"slow", Fault::slow},
              {"throws", Fault::throws},
              {"throws_int", Fault::throws_int},
              {"made_throws_int", Fault::made_throws_int},
              {"throws_where_none_may", Fault::throws_where_none_may}},
             "what happens at the first window, or at every one");
  }

  FaultyWindow(const Params& params, const BuildContext&) : fault_(params.fault) {
    if (fault_ == Fault::made_throws_int) throw 5;
  }

  std::optional<WindowPlan> next(const StreamView& stream, const Feedback& feedback, OverlapProbe&) override {
    if (fault_ == Fault::crash) std::abort();
    if (fault_ == Fault::throws) throw std::runtime_error("on purpose");
    if (fault_ == Fault::throws_int) throw 5;
    if (fault_ == Fault::throws_where_none_may) throw_where_none_may();
    if (fault_ == Fault::slow) return tenth(stream, feedback.t);
    // 8 MB at a time, written to; some 40 s to the end where nobody intervenes.
    for (int i = 0; i < 4000; ++i) {
      if (fault_ == Fault::memory) hoard_.emplace_back(8'000'000, 'x');
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return std::nullopt;
  }

  TimeNs reach() const override { return kSecond; }

 private:
  /// As the destructor of a stage would.
  static void throw_where_none_may() noexcept { throw_number(); }
  static void throw_number() { throw 5; }

  static std::optional<WindowPlan> tenth(const StreamView& stream, TimeNs begin) {
    const TimeNs end = begin + kSecond / 10;
    if (stream.points_until() < end || stream.imu_until() < end || stream.last_point() <= begin) return std::nullopt;
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    return WindowPlan{.history_begin = begin, .fresh_begin = begin, .end = end};
  }

  Fault fault_;
  std::vector<std::vector<char>> hoard_;
};

/// Scores every frame as half known, and throws at one of them.
class FaultyOverlap final : public OverlapMetric {
 public:
  struct Params {
    std::int64_t frames = 5;
  };

  static void describe(config::Binder& b, Params& p) {
    b.integer("frames", p.frames, "", {.min = 0}, "frames that it scores before it throws");
  }

  FaultyOverlap(const Params& params, const BuildContext&) : left_(params.frames) {}

  OverlapScore evaluate(std::span<const WorldPoint> points, TimeNs) override {
    if (left_-- == 0) throw std::runtime_error("this metric knows no more frames");
    return {.value = 0.5, .layers = {}, .points = static_cast<std::uint32_t>(points.size())};
  }
  void extend(std::span<const WorldPoint>, TimeNs) override {}
  void trim(const Vec3&, double) override {}
  void clear() override {}
  std::size_t memory_bytes() const override { return 0; }

 private:
  std::int64_t left_;
};

/// Finds a plane at every point, and no number for how far away it is.
class FaultyResidual final : public Residual {
 public:
  struct Params {};
  static void describe(config::Binder&, Params&) {}
  FaultyResidual(const Params&, const BuildContext&) {}

  int rows_per_match() const override { return 1; }
  MapQuery query() const override { return {}; }
  bool surfaces_from_map() const override { return true; }
  void fit(std::span<const Vec3>, const Neighbours&, std::span<Surface>) override {}
  void evaluate(std::span<const Vec3>, std::span<const float>, std::span<const Surface>, double,
                std::span<ResidualRow> rows) override {
    for (ResidualRow& row : rows) row = {std::numeric_limits<double>::quiet_NaN(), Vec3::UnitX(), 1.0};
  }
};

void register_types(plugin::Catalog& catalog) {
  plugin::Registry<WindowStrategy>(catalog).add<FaultyWindow>("faulty", "a window that fails in one of some ways");
  plugin::Registry<OverlapMetric>(catalog).add<FaultyOverlap>("faulty", "an overlap that throws after some frames");
  plugin::Registry<Residual>(catalog).add<FaultyResidual>("faulty", "a residual that is not a number");
}

}  // namespace

ASLIO_PLUGIN(register_types)
