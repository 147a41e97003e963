#include "aslio/simulator/worlds/library.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "aslio/config/binder.hpp"
#include "purposes.hpp"
#include "worlds/floor_plan.hpp"
#include "worlds/furniture.hpp"

namespace aslio::simulator {
namespace {

using namespace indoor;
namespace m = material;

constexpr double kBay = 0.9;      // width between two uprights [m]
constexpr double kDepth = 0.3;    // of one side of a double shelf [m]
constexpr double kBack = 0.01;    // half the board between the sides [m]
constexpr double kBoard = 0.025;  // [m]
constexpr double kFoot = 0.1;     // height of the lowest board [m]
constexpr double kMargin = 4.5;   // of the hall round the route [m]
constexpr double kHalf = kDepth + kBack;

/// Bays side by side on a line parallel to a run.
struct Range {
  Run run;
  double across = 0;  ///< of its middle from the run [m]
  double begin = 0;   ///< along the run [m]
  int bays = 0;
  int row = 0;  ///< 0 stands at the route
};

double distance(const Vec2& p, const Run& run) {
  const double along = p[run.axis], beyond = std::max({run.lo - along, along - run.hi, 0.0});
  return std::hypot(p[1 - run.axis] - run.at, beyond);
}

/// What is seen of a book that stands on a board: its back is in the shelf.
void add_book(MeshBuilder& builder, double x0, double x1, double depth, double z0, double z1, std::uint8_t paper) {
  builder.wall({x0, depth}, {x1, depth}, z0, z1, paper);
  builder.wall({x0, kBack}, {x0, depth}, z0, z1, paper);
  builder.wall({x1, kBack}, {x1, depth}, z0, z1, paper);
  builder.slab({x0, kBack}, {x1, depth}, z1, m::kPaper);
}

/// Books of one board, in series of like ones, from x = 0 to `width`; `room` is up to the next board. Far ones are
/// drawn as series.
void add_books(MeshBuilder& builder, RandomStream& random, double width, double z, double room, double share,
               bool near) {
  const double end = width - 0.02;
  for (double x = 0.02; x < end - 0.02;) {
    const double length = random.uniform(0.08, 0.35), tall = random.uniform(0.6, 0.92) * room;
    const double depth = random.uniform(0.14, 0.27), paper = random.uniform(30, 200);
    const bool taken = random.uniform() < share;
    const double stop = std::min(end, x + length);
    while (x < stop - 0.005) {
      const double thick = near ? random.uniform(0.02, 0.06) : length, x1 = std::min(stop, x + thick);
      const double h = std::min(tall + random.uniform(-0.03, 0.03), room - 0.01),
                   d = depth + random.uniform(-0.02, 0.02);
      const auto tone = static_cast<std::uint8_t>(std::clamp(paper + random.uniform(-25, 25), 15.0, 225.0));
      if (taken) add_book(builder, x, x1 - 0.001, d, z, z + h, tone);
      x = x1;
    }
    x = stop;
  }
}

/// The side of a range that its frame looks out of: x along it from 0 to `length`, y from the middle board.
void add_side(MeshBuilder& builder, RandomStream& random, const LibraryParams& params, double length, bool near) {
  const int bays = static_cast<int>(std::lround(length / kBay));
  const int levels = std::max(3, static_cast<int>(params.shelf_height / 0.38));
  const double step = (params.shelf_height - kFoot - kBoard) / levels;
  builder.box({0, kBack, 0}, {length, kHalf - 0.03, kFoot}, m::kWood);
  for (int k = 0; k <= levels; ++k) {
    const double z = kFoot + step * k;
    builder.box({0, kBack, z}, {length, kHalf, z + kBoard}, m::kWood);
  }
  for (int k = 1; k < bays; ++k)
    builder.box({k * kBay - 0.015, kBack, 0}, {k * kBay + 0.015, kHalf, params.shelf_height}, m::kWood);
  for (int k = 0; k < bays; ++k) {
    const auto bay = builder.place({Vec3(k * kBay + 0.015, 0, 0), 0});
    for (int level = 0; level < levels; ++level) {
      const double z = kFoot + step * level + kBoard;
      add_books(builder, random, kBay - 0.03, z, step - kBoard, params.books, near);
    }
  }
}

/// Back to back, with end caps that carry a sign.
void add_range(MeshBuilder& builder, RandomStream& random, const LibraryParams& params, const Range& range) {
  const double length = kBay * range.bays, end = range.begin + length;
  for (const double side : {-1.0, 1.0}) {
    WallFace face;
    face.a = range.run.point(range.begin, range.across);
    face.b = range.run.point(end, range.across);
    face.normal = range.run.axis == 0 ? Vec2(0, side) : Vec2(side, 0);
    const auto here = builder.place(at_wall(face));
    add_side(builder, random, params, length, range.row == 0 && side * range.across < 0);
    if (side < 0) continue;
    builder.box({0, -kBack, 0}, {length, kBack, params.shelf_height}, m::kWood);
    for (const double x : {0.0, length - 0.04})
      builder.box({x, -kHalf - 0.01, 0}, {x + 0.04, kHalf + 0.01, params.shelf_height + 0.04}, m::kWood);
    for (const double x : {-0.012, length}) builder.box({x, -0.12, 1.35}, {x + 0.012, 0.12, 1.65}, m::kWhitePaint);
  }
}

/// A table for four; x and y from the middle of its top.
void add_table(MeshBuilder& builder, RandomStream& random) {
  builder.box({-0.8, -0.45, 0.71}, {0.8, 0.45, 0.74}, m::kWood);
  for (const double x : {-0.74, 0.68})
    for (const double y : {-0.4, 0.34}) builder.box({x, y, 0}, {x + 0.06, y + 0.06, 0.71}, m::kWood);
  builder.box({-0.06, -0.06, 0.74}, {0.06, 0.06, 0.76}, m::kMetal);
  builder.box({-0.01, -0.01, 0.76}, {0.01, 0.01, 1.1}, m::kMetal);
  builder.frustum({0, 0, 1.05}, 0.14, 0.06, 0.12, 10, m::kBlackPaint);
  for (const double x : {-0.4, 0.4}) {
    for (const double y : {-0.75, 0.75}) {
      if (random.uniform() < 0.8)
        add_chair(builder, {x + random.uniform(-0.1, 0.1), y},
                  random.uniform(-0.3, 0.3) + (y < 0 ? std::numbers::pi : 0));
      const double high = random.uniform(0.02, 0.12);
      if (random.uniform() < 0.6)
        builder.box({x - 0.1, 0.4 * y - 0.1, 0.74}, {x + 0.1, 0.4 * y + 0.1, 0.74 + high}, m::kPaper);
    }
  }
}

/// The hall while it is furnished.
class Library {
 public:
  Library(const LibraryParams& params, const Route& route)
      : params_(params),
        seed_(static_cast<std::uint64_t>(params.seed)),
        runs_(runs_of(route, "library")),
        hall_{Vec2(route.low().array() - kMargin), Vec2(route.high().array() + kMargin)},
        keep_clear_(clear_zones(route, 0.61)) {}
  World build() const;

 private:
  std::vector<Range> ranges(Site& site) const;
  void add_row(Site& site, std::size_t run, double half_aisle, int row, double side, std::vector<Range>& ranges) const;
  bool belongs(const Vec2& p, std::size_t run) const;
  std::vector<Rect> pillars(Site& site) const;
  void add_tables(MeshBuilder& builder, Site& site) const;
  void dress_hall(MeshBuilder& builder, const PlanGrid& grid) const;

  LibraryParams params_;
  std::uint64_t seed_;
  std::vector<Run> runs_;
  Rect hall_;
  std::vector<Rect> keep_clear_;
};

/// Whether a run is clearly the nearest: rows of different runs do not mix, and one can walk between them.
bool Library::belongs(const Vec2& p, std::size_t run) const {
  const double own = distance(p, runs_[run]);
  for (std::size_t k = 0; k < runs_.size(); ++k)
    if (k != run && distance(p, runs_[k]) < own + 0.5) return false;
  return true;
}

void Library::add_row(Site& site, std::size_t index, double half_aisle, int row, double side,
                      std::vector<Range>& ranges) const {
  const Run& run = runs_[index];
  const double across = side * (half_aisle + kHalf + row * 2 * (half_aisle + kHalf));
  RandomStream random(seed_, purpose::kLayout,
                      1000 + 100 * index + 2 * static_cast<std::size_t>(row) + (side > 0 ? 1 : 0));
  Range range{run, across, 0, 0, row};
  int most = 0;
  const auto finish = [&] {
    if (range.bays > 0) ranges.push_back(range);
    range.bays = 0;
  };
  for (double s = run.lo - kMargin + 1; s + kBay < run.hi + kMargin - 1;) {
    const Rect bay = run.rect(s, s + kBay, across - kHalf, across + kHalf);
    if (!belongs(bay.centre(), index) || !site.claim(bay, params_.shelf_height)) {
      finish();
      s += 0.15;
      continue;
    }
    if (range.bays == 0) {
      range.begin = s;
      most = static_cast<int>(random.uniform(5, 9));
    }
    ++range.bays;
    s += kBay;
    if (range.bays < most) continue;
    finish();
    s += random.uniform(1.1, 1.5);
  }
  finish();
}

std::vector<Range> Library::ranges(Site& site) const {
  std::vector<Range> ranges;
  for (int row = 0; row < static_cast<int>(params_.rows); ++row) {
    for (std::size_t k = 0; k < runs_.size(); ++k) {
      const double aisle = RandomStream(seed_, purpose::kLayout, k).uniform(params_.aisle_min, params_.aisle_max);
      for (const double side : {-1.0, 1.0}) add_row(site, k, 0.5 * aisle, row, side, ranges);
    }
  }
  return ranges;
}

/// On a grid over the hall; shelves stand between them.
std::vector<Rect> Library::pillars(Site& site) const {
  std::vector<Rect> pillars;
  const Vec2 size = hall_.size();
  const int nx = std::max(1, static_cast<int>(size.x() / 6.5)), ny = std::max(1, static_cast<int>(size.y() / 6.5));
  for (int j = 1; j < ny; ++j) {
    for (int i = 1; i < nx; ++i) {
      const Vec2 at = hall_.low + Vec2(size.x() * i / nx, size.y() * j / ny);
      const Rect pillar{at.array() - 0.2, at.array() + 0.2};
      if (site.claim(pillar, params_.height)) pillars.push_back(pillar);
    }
  }
  return pillars;
}

void Library::add_tables(MeshBuilder& builder, Site& site) const {
  RandomStream random(seed_, purpose::kLayout, 5000);
  const int tries = static_cast<int>(std::min(4000.0, 2 * hall_.size().prod()));
  for (int k = 0; k < tries; ++k) {
    const Vec2 at = hall_.low + Vec2(random.uniform() * hall_.size().x(), random.uniform() * hall_.size().y());
    const Placement place{Vec3(at.x(), at.y(), 0), random.uniform() < 0.5 ? 0 : 0.5 * std::numbers::pi};
    if (!site.claim(place, {-1.3, -1.5}, {1.3, 1.5})) continue;
    const auto here = builder.place(place);
    add_table(builder, random);
  }
}

/// Beams across the hall and lamps between them.
void Library::dress_hall(MeshBuilder& builder, const PlanGrid& grid) const {
  const double depth = std::min(0.3, params_.height - params_.shelf_height - 0.1);
  const int beams = std::max(1, static_cast<int>(hall_.size().x() / 4.5));
  for (int k = 0; k < beams && depth > 0.05; ++k) {
    const double x = hall_.low.x() + hall_.size().x() * (k + 0.5) / beams;
    builder.box({x - 0.12, hall_.low.y(), params_.height - depth}, {x + 0.12, hall_.high.y(), params_.height},
                m::kPlaster);
  }
  hang_lamps(builder, grid, hall_, params_.height);
}

World Library::build() const {
  FloorPlan plan;
  plan.add({hall_, 0, params_.height});
  const PlanGrid grid(plan);
  MeshBuilder builder;
  grid.build(builder, {.wall = m::kPlaster, .floor = m::kCloth, .ceiling = m::kWhitePaint});
  Site site(grid, keep_clear_);
  for (const Rect& p : pillars(site))
    builder.box({p.low.x(), p.low.y(), 0}, {p.high.x(), p.high.y(), params_.height}, m::kConcrete);
  const std::vector<Range> all = ranges(site);
  for (std::size_t k = 0; k < all.size(); ++k) {
    RandomStream random(seed_, purpose::kLayout, 10'000 + k);
    add_range(builder, random, params_, all[k]);
  }
  add_tables(builder, site);
  dress_walls(builder, site, seed_, 1);
  dress_hall(builder, grid);
  return {builder.take(), Ground{}};
}

}  // namespace

void LibraryParams::describe(config::Binder& b, LibraryParams& params) {
  b.integer("seed", params.seed, "1", {.min = 0.0}, "of the layout and the clutter");
  b.real("aisle_min", params.aisle_min, "m", {.min = 1.25, .max = 5.0},
         "least width between the shelves; drawn for each aisle");
  b.real("aisle_max", params.aisle_max, "m", {.min = 1.25, .max = 5.0}, "largest width between the shelves");
  b.real("height", params.height, "m", {.min = 2.4, .max = 8.0}, "of the ceiling");
  b.real("shelf_height", params.shelf_height, "m", {.min = 1.0, .max = 7.0}, "of the shelves");
  b.integer("rows", params.rows, "1", {.min = 0.0, .max = 6.0}, "of double shelves on each side of the route");
  b.real("books", params.books, "1", {.min = 0.0, .max = 1.0}, "share of the shelves that is taken");
  b.require(params.aisle_max >= params.aisle_min, "aisle_max", "must be at least aisle_min");
  b.require(params.height >= params.shelf_height + 0.1, "height", "must exceed shelf_height by 0.1 m");
}

World build_library(const LibraryParams& params, const Route& route, double) { return Library(params, route).build(); }

}  // namespace aslio::simulator
