#include "aslio/simulator/worlds/escalator_hall.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "aslio/config/binder.hpp"
#include "aslio/core/errors.hpp"
#include "aslio/simulator/random.hpp"
#include "purposes.hpp"
#include "worlds/curved.hpp"
#include "worlds/flight.hpp"
#include "worlds/plot.hpp"

namespace aslio::simulator {
namespace {

using namespace outdoor;
namespace m = material;

constexpr double kPi = std::numbers::pi;
constexpr double kRise = 0.2;      // of a step [m]
constexpr double kTread = 0.3464;  // for a slope of 30 deg [m]
constexpr double kHalf = 0.64;     // half the width of the steps [m]
constexpr double kGlass = 0.68;    // of the balustrades from the middle of an escalator [m]
constexpr double kLevel = 1.2;     // level part at both ends of an escalator [m]
constexpr double kPitch = 1.8;     // between two escalators beside each other [m]
constexpr double kBeside = 1.2;    // what stands about keeps this from the route [m]
constexpr double kSag = 0.55;      // of the vault over its springing, share of its half width
constexpr double kParallel = 5;    // escalators beside each other differ by less than this [deg]

/// x up the escalators, y to their left, origin at the foot of the first.
struct Frame {
  Vec2 origin = Vec2::Zero();
  double yaw = 0;
  Vec2 local(const Vec2& p) const {
    const Vec2 d = p - origin;
    const double c = std::cos(yaw), s = std::sin(yaw);
    return {c * d.x() + s * d.y(), c * d.y() - s * d.x()};
  }
};

struct Layout {
  Frame frame;
  Flight flight;
  std::vector<Vec2> route;                       ///< in the frame [m]
  std::vector<double> crossings;                 ///< y of the edges that change floors [m]
  Vec2 low = Vec2::Zero(), high = Vec2::Zero();  ///< corners between the walls, in the frame [m]

  double run() const { return flight.length(); }
};

/// Where an edge climbs it must lie along the escalators.
void find_crossings(Layout& layout, const Route& route) {
  for (std::size_t k = 0; k < layout.route.size(); ++k) {
    const Vec2 &a = layout.route[k], &b = layout.route[(k + 1) % layout.route.size()];
    const double least = std::min(a.x(), b.x()), most = std::max(a.x(), b.x());
    if (most <= -kLevel || least >= layout.run() + kLevel) continue;
    const double off = std::atan2(std::abs(b.y() - a.y()), most - least) * 180 / kPi;
    if (off > kParallel || least > -kLevel || most < layout.run() + kLevel) {
      const std::vector<Vec2>& points = route.points();
      const Vec2 &p = points[k], &q = points[(k + 1) % points.size()];
      throw ConfigError(
          fmt::format("route: edge {} from ({:.2f}, {:.2f}) to ({:.2f}, {:.2f}) [m] meets the escalators and does not "
                      "lead over them: it must be parallel to edge world.up_edge within {} deg and reach {} m beyond "
                      "both ends, or keep off. Move its points or make world.height smaller",
                      k + 1, p.x(), p.y(), q.x(), q.y(), kParallel, kLevel));
    }
    layout.crossings.push_back(0.5 * (a.y() + b.y()));
  }
}

Layout layout_of(const EscalatorHallParams& params, const Route& route, double scale) {
  const std::vector<Vec2>& points = route.points();
  const auto edge = static_cast<std::size_t>(params.up_edge - 1);
  if (edge >= points.size())
    throw ConfigError(fmt::format("world.up_edge is {}, but the route has {} edges: give one of 1 to {}",
                                  params.up_edge, points.size(), points.size()));
  const Vec2 &a = points[edge], &b = points[(edge + 1) % points.size()];
  Layout layout;
  layout.flight = {.steps = std::max(1, static_cast<int>(std::lround(scale * params.height / kRise))),
                   .tread = kTread,
                   .rise = kRise,
                   .right = -kHalf,
                   .left = kHalf,
                   .thickness = 0.9};
  const double length = (b - a).norm(), spare = 0.5 * (length - layout.run());
  if (spare < kLevel)
    throw ConfigError(
        fmt::format("route: edge {} is {:.2f} m long, but the escalators on it need {:.2f} m: make it longer or "
                    "world.height smaller",
                    params.up_edge, length, layout.run() + 2 * kLevel));
  const Vec2 along = (b - a) / length;
  layout.frame = {a + spare * along, std::atan2(along.y(), along.x())};
  for (const Vec2& p : points) layout.route.push_back(layout.frame.local(p));
  find_crossings(layout, route);
  layout.low = layout.high = layout.route.front();
  for (const Vec2& p : layout.route) {
    layout.low = layout.low.cwiseMin(p);
    layout.high = layout.high.cwiseMax(p);
  }
  layout.low.array() -= params.margin;
  layout.high.array() += params.margin;
  return layout;
}

class Hall {
 public:
  Hall(const EscalatorHallParams& params, const Layout& layout)
      : params_(params),
        layout_(layout),
        route_(layout.route),
        plot_(route_),
        seed_(static_cast<std::uint64_t>(params.seed)),
        low_(layout.low),
        high_(layout.high),
        run_(layout.run()),
        upper_(layout.flight.height()),
        spring_(params.spring + upper_ * 0.3) {}

  Mesh build() {
    const auto here = builder_.place({Vec3(layout_.frame.origin.x(), layout_.frame.origin.y(), 0), layout_.frame.yaw});
    add_floors();
    add_walls();
    add_vault();
    for (const double y : layout_.crossings) add_escalators(y);
    add_balustrade();
    add_columns();
    add_things();
    return builder_.take();
  }

 private:
  double half_width() const { return 0.5 * (high_.y() - low_.y()); }
  double middle() const { return 0.5 * (high_.y() + low_.y()); }
  double floor_at(double x) const { return x < run_ ? 0 : upper_; }
  /// The arc of the vault, from its right springing to the left one.
  std::vector<Vec2> vault(double inset) const {
    const double w = half_width(), sag = kSag * w, r = (w * w + sag * sag) / (2 * sag);
    const double half = std::asin(std::min(1.0, w / r));
    std::vector<Vec2> arc = curved::arc({0, spring_ + sag - r}, r - inset, 0.5 * kPi - half, 0.5 * kPi + half);
    for (Vec2& p : arc) p.x() = -p.x();
    std::reverse(arc.begin(), arc.end());
    return arc;
  }
  double vault_at(double y) const {
    const double w = half_width(), sag = kSag * w, r = (w * w + sag * sag) / (2 * sag), d = y - middle();
    return spring_ + sag - r + std::sqrt(std::max(0.0, r * r - d * d));
  }
  void add_floors();
  void add_walls();
  void add_vault();
  void add_escalators(double y);
  void add_escalator(double y);
  void add_balustrade();
  void add_columns();
  void add_things();
  bool free_of_escalators(const Vec2& p, double radius) const;

  const EscalatorHallParams& params_;
  const Layout& layout_;
  Route route_;
  Plot plot_;
  std::uint64_t seed_;
  Vec2 low_, high_;
  double run_, upper_, spring_;
  MeshBuilder builder_;
};

void Hall::add_floors() {
  builder_.slab(low_, {run_, high_.y()}, 0, m::kConcrete);
  builder_.slab({run_, low_.y()}, high_, upper_, m::kConcrete);
  builder_.wall({run_, low_.y()}, {run_, high_.y()}, 0, upper_ - 0.002, m::kPlaster);
}

/// Side walls with half-round pilasters; the end walls reach into the vault.
void Hall::add_walls() {
  const std::vector<Vec2> arc = vault(0);
  for (const double y : {low_.y(), high_.y()}) {
    builder_.wall({low_.x(), y}, {high_.x(), y}, 0, spring_, m::kBrick);
    builder_.box({low_.x(), y - 0.15, spring_ - 0.4}, {high_.x(), y + 0.15, spring_ - 0.1}, m::kConcrete);
    for (double x = low_.x() + 3; x < high_.x() - 1; x += 6)
      curved::add_column(builder_, {x, y, 0}, 0.4, 0.36, spring_ - 0.4, m::kConcrete);
  }
  for (const double x : {low_.x(), high_.x()}) {
    builder_.wall({x, low_.y()}, {x, high_.y()}, 0, spring_, m::kPlaster);
    for (std::size_t k = 1; k < arc.size(); ++k) {
      const double a = middle() + arc[k - 1].x(), b = middle() + arc[k].x();
      builder_.quad({x, a, spring_}, {x, b, spring_}, {x, b, arc[k].y()}, {x, a, arc[k - 1].y()}, m::kGlass);
    }
    // A portal with round columns, and mullions in the window above it.
    const double z = floor_at(x), in = x == low_.x() ? 0.25 : -0.25;
    for (double y = low_.y() + 2; y < high_.y() - 1; y += 3)
      curved::add_column(builder_, {x + in, y, z}, 0.22, 0.2, spring_ - z, m::kConcrete);
    for (double y = low_.y() + 1; y < high_.y(); y += 2)
      builder_.box({x - 0.08, y - 0.06, spring_}, {x + 0.08, y + 0.06, vault_at(y)}, m::kMetal);
  }
}

/// A barrel with an arch every 6 m.
void Hall::add_vault() {
  const std::vector<Vec2> arc = vault(0), rib = vault(0.35);
  const auto station = [&](double x) { return curved::Station{Vec3(x, middle(), 0), Vec2::UnitX()}; };
  curved::sweep(builder_, arc, std::array{station(low_.x()), station(high_.x())}, m::kPlaster);
  for (double x = low_.x() + 3; x < high_.x() - 1; x += 6) {
    curved::sweep(builder_, rib, std::array{station(x - 0.25), station(x + 0.25)}, m::kConcrete);
    for (const double side : {x - 0.25, x + 0.25})
      for (std::size_t k = 1; k < rib.size(); ++k) {
        const auto at = [&](const Vec2& p) { return Vec3(side, middle() + p.x(), p.y()); };
        const double share = static_cast<double>(k - 1) / static_cast<double>(rib.size() - 1),
                     next = static_cast<double>(k) / static_cast<double>(rib.size() - 1);
        const auto outer = [&](double u) {
          return arc[static_cast<std::size_t>(u * static_cast<double>(arc.size() - 1))];
        };
        builder_.quad(at(rib[k - 1]), at(rib[k]), at(outer(next)), at(outer(share)), m::kConcrete);
      }
  }
}

/// One on the route, and one beside it for the other direction, where there is room.
void Hall::add_escalators(double y) {
  add_escalator(y);
  const bool first = y == layout_.crossings.front();
  for (const double side : {kPitch, -kPitch}) {
    const bool taken = std::any_of(layout_.crossings.begin(), layout_.crossings.end(), [&](double other) {
      return std::abs(other - (y + side)) < 1.9 * kPitch - 0.3 && other != y;
    });
    if (!first || taken || y + side < low_.y() + 2 || y + side > high_.y() - 2) continue;
    add_escalator(y + side);
    break;
  }
}

/// Steps, glass balustrades with handrails, and the truss below.
void Hall::add_escalator(double y) {
  const auto here = builder_.place({Vec3(0, y, 0), 0});
  const Flight& flight = layout_.flight;
  add_steps(builder_, flight, m::kMetal);
  const double slope = flight.rise / flight.tread, end = run_;
  const auto line = [&](double x) { return std::clamp(slope * x, 0.0, slope * end) + 0.5 * flight.rise; };
  const std::array<double, 4> xs{-kLevel + 0.3, 0, end, end + kLevel - 0.3};
  for (const double side : {-kGlass, kGlass}) {
    for (std::size_t k = 1; k < xs.size(); ++k) {
      const double a = xs[k - 1], b = xs[k];
      const auto band = [&](double from, double to, std::uint8_t reflectivity) {
        builder_.quad({a, side, line(a) + from}, {b, side, line(b) + from}, {b, side, line(b) + to},
                      {a, side, line(a) + to}, reflectivity);
      };
      band(-0.35, 0.15, m::kMetal);
      band(0.15, 0.86, m::kGlass);
      curved::add_bar(builder_, {a, side, line(a) + 0.9}, {b, side, line(b) + 0.9}, 0.04, m::kRubber);
    }
    // The truss is closed at the side down to the soffit.
    builder_.quad({0, side, line(0) - 1}, {end, side, line(end) - 1}, {end, side, line(end) - 0.35},
                  {0, side, line(0) - 0.35}, m::kMetal);
    // The handrail turns down round the ends of the balustrade.
    for (const double x : {xs.front(), xs.back()})
      curved::add_bar(builder_, {x, side, line(x) - 0.1}, {x, side, line(x) + 0.9}, 0.04, m::kRubber);
  }
}

/// Glass along the edge of the upper floor, open at the escalators.
void Hall::add_balustrade() {
  const double x = run_ + 0.1;
  double from = low_.y();
  // Wide enough for the escalator on the route, and for the one beside it.
  std::vector<double> opens = layout_.crossings;
  std::sort(opens.begin(), opens.end());
  opens.push_back(high_.y() + kPitch + kGlass);
  for (const double y : opens) {
    const double to = y - kPitch - kGlass;
    if (to > from + 0.2) {
      builder_.box({x - 0.01, from, upper_ + 0.08}, {x + 0.01, to, upper_ + 1.0}, m::kGlass);
      curved::add_bar(builder_, {x, from, upper_ + 1.05}, {x, to, upper_ + 1.05}, 0.025, m::kMetal);
      const int posts = std::max(1, static_cast<int>((to - from) / 1.4));
      for (int k = 0; k <= posts; ++k)
        curved::add_bar(builder_, {x, from + (to - from) * k / posts, upper_},
                        {x, from + (to - from) * k / posts, upper_ + 1.05}, 0.02, m::kMetal);
    }
    from = y + kPitch + kGlass;
  }
}

bool Hall::free_of_escalators(const Vec2& p, double radius) const {
  if (p.x() < -kLevel - 1 - radius || p.x() > run_ + kLevel + 1 + radius) return true;
  return std::none_of(layout_.crossings.begin(), layout_.crossings.end(),
                      [&](double y) { return std::abs(p.y() - y) < kPitch + kGlass + 0.2 + radius; }) &&
         std::abs(p.x() - run_) > radius + 0.3;
}

/// Rows along the hall, from the floor into the vault, with a base and a wider head.
void Hall::add_columns() {
  if (params_.columns <= 0) return;
  constexpr double kRadius = 0.45;
  const double inner = std::min(0.55 * half_width(), half_width() - 3);
  for (const double y : {middle() - inner, middle() + inner}) {
    for (double x = low_.x() + 0.6 * params_.columns; x < high_.x() - 2; x += params_.columns) {
      const Vec2 p(x, y);
      if (!free_of_escalators(p, kRadius + 0.2) || !plot_.claim({p, Vec2(0.6, 0.6), 0}, kBeside)) continue;
      const double z = floor_at(x), top = vault_at(y);
      curved::add_column(builder_, {x, y, z}, kRadius + 0.15, kRadius + 0.1, 0.3, m::kConcrete);
      curved::add_column(builder_, {x, y, z}, kRadius, kRadius - 0.05, top - z, m::kConcrete);
      curved::add_column(builder_, {x, y, top - 1.3}, kRadius, kRadius + 0.45, 1.0, m::kConcrete);
    }
  }
}

/// Ticket machines, benches, round bins, planters and signs on posts.
void Hall::add_things() {
  RandomStream random(seed_, purpose::kLayout, 1);
  const int attempts = static_cast<int>((high_ - low_).prod() * 0.12 * params_.clutter);
  for (int k = 0; k < attempts; ++k) {
    const Vec2 p{random.uniform(low_.x() + 1.2, high_.x() - 1.2), random.uniform(low_.y() + 1.2, high_.y() - 1.2)};
    const double kind = random.uniform(), yaw = random.uniform(0, 2 * kPi), size = random.uniform();
    const Vec2 half = kind < 0.3 ? Vec2(1.0, 0.35) : kind < 0.6 ? Vec2(0.5, 0.4) : Vec2(0.45, 0.45);
    if (!free_of_escalators(p, 1) || !plot_.claim({p, half, yaw}, kBeside)) continue;
    const auto here = builder_.place({Vec3(p.x(), p.y(), floor_at(p.x())), yaw});
    if (kind < 0.3) {
      builder_.box({-0.9, -0.25, 0.38}, {0.9, 0.25, 0.45}, m::kWood);
      for (const double x : {-0.7, 0.65}) builder_.box({x, -0.2, 0}, {x + 0.06, 0.2, 0.38}, m::kMetal);
    } else if (kind < 0.6) {
      builder_.box({-0.45, -0.3, 0}, {0.45, 0.3, 1.3 + 0.7 * size}, m::kMetal);
      builder_.box({-0.3, 0.3, 0.9}, {0.3, 0.33, 1.25}, m::kBlackPaint);
    } else if (kind < 0.8) {
      const double r = 0.25 + 0.15 * size;
      curved::add_column(builder_, {0, 0, 0}, r, 1.1 * r, 0.9, m::kMetal);
    } else {
      curved::add_column(builder_, {0, 0, 0}, 0.05, 0.05, 2.9, m::kMetal, 12);
      builder_.box({-0.4, -0.05, 2.4}, {0.4, 0.05, 2.9}, m::kWhitePaint);
    }
  }
}

}  // namespace

void EscalatorHallParams::describe(config::Binder& b, EscalatorHallParams& params) {
  b.integer("seed", params.seed, "1", {.min = 0.0}, "of what stands about");
  b.integer("up_edge", params.up_edge, "1", {.min = 1.0, .max = 1000.0},
            "edge of the route, from 1, that the escalators up stand on");
  b.real("height", params.height, "m", {.min = 1.0, .max = 20.0}, "of the upper floor above the concourse; scales");
  b.real("margin", params.margin, "m", {.min = 3.0, .max = 50.0}, "from the route to the walls");
  b.real("spring", params.spring, "m", {.min = 6.0, .max = 40.0},
         "where the vault begins above the concourse, besides 0.3 of the height of the upper floor");
  b.real("columns", params.columns, "m", {.min = 0.0, .max = 100.0}, "between columns; 0: none");
  b.real("clutter", params.clutter, "1", {.min = 0.0, .max = 3.0}, "machines, benches, signs: 0 none, 1 usual");
  b.require(params.columns == 0 || params.columns >= 2, "columns", "must be 0 or at least 2 m");
  b.require(params.spring >= 0.7 * params.height + 4, "spring",
            "must be at least 0.7 times height and 4 m more, or the vault is too low over the upper floor");
}

World build_escalator_hall(const EscalatorHallParams& params, const Route& route, double scale) {
  const Layout layout = layout_of(params, route, scale);
  constexpr double kHeadroom = 4;  // [m]
  if (const double height = layout.flight.height(); params.spring + 0.3 * height < height + kHeadroom)
    throw ConfigError(fmt::format("world.spring is {:g} m: over an upper floor at {:.3g} m it must be {:.3g} m or more",
                                  params.spring, height, 0.7 * height + kHeadroom));
  Ground ground;
  const double c = std::cos(layout.frame.yaw), s = std::sin(layout.frame.yaw);
  add_ramps(ground, layout.flight, layout.frame.yaw, c * layout.frame.origin.x() + s * layout.frame.origin.y());
  return {Hall(params, layout).build(), ground};
}

}  // namespace aslio::simulator
