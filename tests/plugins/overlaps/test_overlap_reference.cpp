// hard_voxel and soft_voxel against brute force over whole lives: what is known is a list of all cells ever learnt.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <optional>
#include <random>

#include "aslio/core/spread.hpp"
#include "aslio/stages/overlap.hpp"
#include "plugins/build_environment.hpp"
#include "plugins/overlaps/one_stage.hpp"
#include "register_all.hpp"

using namespace aslio;

namespace {

constexpr TimeNs kMs = kSecond / 1000;

struct Settings {
  int layers = 0;
  TimeNs delay = 0, frame_length = 0;  // frame_length 0: a frame is its latest points
  std::size_t max_points = 0;
  std::string metric = "chebyshev";
  std::string text() const {
    return fmt::format(
        "{{type: {}, voxel: 0.125, delay: {}, max_points: {}, min_points: 1, points: {}, frame_length: 0.12{}",  //
        layers == 0 ? "hard_voxel" : "soft_voxel", to_seconds(delay), max_points,
        frame_length > 0 ? "window" : "latest",
        layers == 0 ? std::string() : fmt::format(", layers: {}, metric: {}", layers, metric));
  }
  /// Layer of a cell that is (x, y, z) cells from the occupied one.
  int layer(int x, int y, int z) const {
    x = std::abs(x), y = std::abs(y), z = std::abs(z);
    if (metric == "manhattan") return x + y + z;
    if (metric == "euclid") return static_cast<int>(std::lround(std::sqrt(1.0 * x * x + 1.0 * y * y + 1.0 * z * z)));
    return std::max({x, y, z});
  }
};

/// docs/equations.md SOD-1 to SOD-3, word for word.
class Reference {
 public:
  explicit Reference(const Settings& settings, std::uint64_t seed) : is_(settings), seed_(seed) {}

  OverlapScore evaluate(const std::vector<WorldPoint>& points, TimeNs t) const {
    std::vector<std::optional<Cell>> frame;
    for (const auto& [time, cell] : window_) {
      if (time > t - is_.frame_length) frame.emplace_back(cell);
    }
    for (const WorldPoint& point : points) frame.push_back(cell_at(point));
    const std::size_t taken = is_.max_points == 0 ? frame.size() : std::min(frame.size(), is_.max_points);
    StratifiedPick choice(taken, frame.size(), seed_);
    const TimeNs horizon = t - is_.delay - std::min((t - extended_) / 2, is_.delay / 2);
    OverlapScore score;
    double sum = 0;
    bool any = false;
    for (const auto& known : known_) any |= known.counts_from <= horizon;
    for (std::size_t i = 0; i < taken; ++i) {
      const auto cell = frame[choice.next()];
      if (!cell) continue;
      ++score.points;
      if (any) {
        const int layer = layer_of(*cell, horizon);
        if (layer <= is_.layers) ++score.layers[static_cast<std::size_t>(layer)];
      }
    }
    for (int i = 0; i <= is_.layers; ++i) {
      sum += (1.0 - i / (is_.layers + 1.0)) * score.layers[static_cast<std::size_t>(i)];
    }
    if (any && score.points > 0) score.value = sum / score.points;
    return score;
  }

  void extend(const std::vector<WorldPoint>& points, TimeNs t) {
    std::erase_if(window_, [&](const auto& held) { return held.first <= t - is_.frame_length; });
    TimeNs time = std::min(extended_, t), begin = 0;
    std::vector<Known> slice;
    const auto finish = [&] {
      for (Known& known : slice) known_.push_back({known.cell, slice.back().counts_from});
      slice.clear();
    };
    for (const WorldPoint& point : points) {
      time = std::clamp(point.t, time, t);
      const auto cell = cell_at(point);
      if (!cell) continue;
      if (is_.frame_length > 0) window_.emplace_back(point.t, *cell);
      if (!slice.empty() && time > begin + 5 * kMs) finish();
      if (slice.empty()) begin = time;
      slice.push_back({*cell, time});
    }
    finish();
    extended_ = t;
  }

  void trim(const Vec3& centre, double radius) {
    const auto inside = [&](std::int32_t c, double middle) {
      return c >= std::floor((middle - radius) * 8) && c <= std::floor((middle + radius) * 8);
    };
    std::erase_if(known_, [&](const Known& known) {
      const Cell& c = known.cell;
      return !inside(c.x, centre.x()) || !inside(c.y, centre.y()) || !inside(c.z, centre.z());
    });
  }

  void clear() {
    known_.clear();
    window_.clear();
  }

 private:
  struct Known {
    Cell cell;
    TimeNs counts_from = 0;
  };
  static std::optional<Cell> cell_at(const WorldPoint& point) {
    if (!point.p_W.allFinite() || point.p_W.cwiseAbs().maxCoeff() > 1e5) return std::nullopt;
    const auto axis = [](double c) { return static_cast<std::int32_t>(std::floor(c * 8)); };
    return Cell{axis(point.p_W.x()), axis(point.p_W.y()), axis(point.p_W.z())};
  }
  int layer_of(const Cell& cell, TimeNs horizon) const {
    int nearest = is_.layers + 1;
    for (const Known& known : known_) {
      if (known.counts_from > horizon) continue;
      nearest = std::min(nearest, is_.layer(known.cell.x - cell.x, known.cell.y - cell.y, known.cell.z - cell.z));
    }
    return nearest;
  }

  Settings is_;
  std::uint64_t seed_;
  std::vector<Known> known_;
  std::vector<std::pair<TimeNs, Cell>> window_;
  TimeNs extended_ = 0;
};

class Draw {
 public:
  explicit Draw(std::uint64_t seed) : engine_(seed) {}
  std::size_t below(std::size_t n) { return static_cast<std::size_t>(engine_() % n); }
  double within(double half) { return half * (2.0 * static_cast<double>(engine_() >> 11) * 0x1p-53 - 1.0); }
  Vec3 place(const Vec3& centre, double half) {
    const double x = within(half), y = within(half);
    return centre + Vec3(x, y, within(half));
  }
  /// Points of (begin, end] in walks of small steps, as along a scan line, with some that are no points at all.
  std::vector<WorldPoint> frame(const Vec3& centre, TimeNs begin, TimeNs end) {
    std::vector<WorldPoint> points(40 + below(160));
    Vec3 p = centre;
    for (std::size_t i = 0; i < points.size(); ++i) {
      p = below(8) == 0 ? place(centre, 0.6) : place(p, 0.05);
      points[i].p_W = below(30) == 0 ? Vec3(p.x(), std::numeric_limits<double>::quiet_NaN(), p.z()) : p;
      points[i].t = begin + 1 + (end - begin - 1) * static_cast<TimeNs>(i) / static_cast<TimeNs>(points.size());
      if (below(40) == 0) points[i].t -= static_cast<TimeNs>(below(30)) * kMs;  // out of order
    }
    return points;
  }

 private:
  std::mt19937_64 engine_;
};

void require_same(const OverlapScore& found, const OverlapScore& expected) {
  REQUIRE(found.points == expected.points);
  REQUIRE(found.layers == expected.layers);
  REQUIRE(found.value.has_value() == expected.value.has_value());
  if (expected.value) REQUIRE(*found.value == Approx(*expected.value).epsilon(1e-12));
}

/// Frames of 4 to 60 ms around a walk; asked ahead, learnt in part, trimmed and cleared now and then.
void live(OverlapMetric& metric, Reference reference, std::uint64_t seed) {
  Draw draw(seed);
  Vec3 centre = Vec3::Zero();
  TimeNs t = kSecond;
  for (int step = 0; step < 60; ++step) {
    CAPTURE(seed, step);
    const TimeNs begin = t;
    t += static_cast<TimeNs>(4 + draw.below(57)) * kMs;
    centre += draw.place(Vec3(0.03, 0, 0), 0.05);
    auto points = draw.frame(centre, begin, t);
    for (std::size_t asked = draw.below(3); asked > 0; --asked) {
      const TimeNs ahead = t + static_cast<TimeNs>(draw.below(200)) * kMs;
      const auto others = draw.below(2) == 0 ? points : draw.frame(centre, begin, t);
      require_same(metric.evaluate(others, ahead), reference.evaluate(others, ahead));
    }
    if (draw.below(3) != 0) metric.advance(t);
    if (draw.below(5) != 0) require_same(metric.evaluate(points, t), reference.evaluate(points, t));
    if (draw.below(12) == 0) points.resize(draw.below(points.size()));
    if (draw.below(6) == 0) {
      for (std::size_t i = 0; i < points.size(); i += 3) points[i].p_W.x() += 0.3;
    }
    const auto forget = [&] {
      if (draw.below(8) == 0) {
        const Vec3 middle = draw.place(centre, 0.5);
        const double radius = 0.3 + 0.01 * step;  // another each time: trimming twice by one radius may be put off
        metric.trim(middle, radius);
        reference.trim(middle, radius);
        const TimeNs ahead = t + static_cast<TimeNs>(draw.below(200)) * kMs;
        if (draw.below(2) == 0) require_same(metric.evaluate(points, ahead), reference.evaluate(points, ahead));
      }
      if (draw.below(60) == 0) {
        metric.clear();
        reference.clear();
      }
    };
    forget();
    metric.extend(points, t);
    reference.extend(points, t);
    forget();
  }
}

}  // namespace

TEST_CASE(
    "overlaps equal brute force over whole lives: delay, window, cap, looks ahead, trims") {  // eqs. SOD-1 to SOD-3
  plugin::Catalog catalog;
  plugins::register_all(catalog);
  test::BuildEnvironment environment;
  const auto context = environment.context();
  const auto hold = [&](const Settings& settings, std::uint64_t lives) {
    for (const std::string store : {"block_hash", "flat_hash", "nested_hash"}) {
      const std::string text = settings.text() + ", store: {type: " + store + "}}";
      INFO(text);
      for (std::uint64_t seed = 1; seed <= lives; ++seed) {
        const auto metric = test::make_stage<OverlapMetric>(catalog, text, context);
        live(*metric, Reference(settings, context.order_seed), seed);
      }
    }
  };
  for (const int layers : {0, 2, 5}) {
    for (const TimeNs delay : {TimeNs{0}, 100 * kMs}) {
      for (const TimeNs frame_length : {TimeNs{0}, 120 * kMs}) {
        for (const std::size_t max_points : {0, 60}) hold({layers, delay, frame_length, max_points}, 3);
      }
    }
  }
  for (const std::string metric : {"manhattan", "euclid"}) {
    for (const int layers : {1, 3}) {
      for (const TimeNs frame_length : {TimeNs{0}, 120 * kMs}) hold({layers, 100 * kMs, frame_length, 60, metric}, 2);
    }
  }
}
