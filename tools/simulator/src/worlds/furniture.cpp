#include "worlds/furniture.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "purposes.hpp"

namespace aslio::simulator::indoor {
namespace {

namespace m = material;

/// Boards and drawers in front of a body, so that it is not one flat face.
void add_cupboard(MeshBuilder& builder, double width, double depth, double height) {
  builder.box({0, 0, 0.06}, {width, depth - 0.02, height}, m::kWood);
  const int leaves = std::max(1, static_cast<int>(std::lround(width / 0.45)));
  for (int k = 0; k < leaves; ++k) {
    const double x0 = width * k / leaves + 0.01, x1 = width * (k + 1) / leaves - 0.01;
    builder.box({x0, depth - 0.02, 0.08}, {x1, depth, height - 0.02}, m::kWood);
    builder.box({x1 - 0.05, depth, 0.5 * height}, {x1 - 0.03, depth + 0.03, 0.5 * height + 0.15}, m::kMetal);
  }
}

void add_open_shelf(MeshBuilder& builder, RandomStream& random, double width, double depth, double height) {
  builder.box({0, 0, 0}, {width, 0.02, height}, m::kWood);
  builder.box({0, 0, 0}, {0.02, depth, height}, m::kWood);
  builder.box({width - 0.02, 0, 0}, {width, depth, height}, m::kWood);
  const int levels = std::max(2, static_cast<int>(height / 0.4));
  for (int k = 0; k < levels; ++k) {
    const double z = 0.05 + (height - 0.07) * k / (levels - 1);
    builder.box({0, 0, z}, {width, depth, z + 0.02}, m::kWood);
    if (k + 1 == levels) break;
    for (double x = 0.04; x < width - 0.15;) {
      const double w = std::min(random.uniform(0.05, 0.3), width - 0.04 - x);
      const auto paper = static_cast<std::uint8_t>(random.uniform(40, 200));
      if (random.uniform() < 0.75)
        builder.box({x, 0.02, z + 0.02}, {x + w, random.uniform(0.6, 0.95) * depth, z + random.uniform(0.2, 0.32)},
                    paper);
      x += w + (random.uniform() < 0.3 ? 0.1 : 0.01);
    }
  }
}

void add_radiator(MeshBuilder& builder, double width) {
  builder.box({0, 0.03, 0.15}, {width, 0.07, 0.7}, m::kWhitePaint);
  for (double x = 0.02; x + 0.04 < width; x += 0.12)
    builder.box({x, 0.07, 0.17}, {x + 0.05, 0.1, 0.68}, m::kWhitePaint);
}

void add_extinguisher(MeshBuilder& builder) {
  builder.frustum({0.1, 0.1, 0.7}, 0.075, 0.075, 0.42, 10, m::kMetal);
  builder.frustum({0.1, 0.1, 1.12}, 0.06, 0.02, 0.1, 10, m::kBlackPaint);
  builder.box({0, 0, 1.4}, {0.2, 0.01, 1.6}, m::kWhitePaint);
}

void add_notice_board(MeshBuilder& builder, RandomStream& random, double width) {
  builder.box({0, 0, 1.0}, {width, 0.03, 1.9}, m::kWood);
  for (double x = 0.06; x + 0.25 < width; x += 0.28) {
    const double z = random.uniform(1.1, 1.5);
    builder.box({x, 0.03, z}, {x + 0.21, 0.034, z + 0.3}, m::kPaper);
  }
}

void add_pipe(MeshBuilder& builder, double height) {
  builder.frustum({0.08, 0.08, 0}, 0.045, 0.045, height, 10, m::kMetal);
  builder.frustum({0.08, 0.08, 0.02}, 0.07, 0.07, 0.05, 10, m::kMetal);
}

void add_bench(MeshBuilder& builder, double width) {
  builder.box({0, 0.02, 0.42}, {width, 0.34, 0.47}, m::kWood);
  for (const double x : {0.08, width - 0.14}) builder.box({x, 0.05, 0}, {x + 0.06, 0.3, 0.42}, m::kMetal);
}

/// What hangs or stands at a wall: how wide and deep, and how often.
enum class Item { board, radiator, pipe, extinguisher, cupboard, shelf, pillar, plant, bench, panel };
struct ItemSize {
  Item item;
  double least, most, depth, share;
};
constexpr std::array kItems{
    ItemSize{Item::board, 0.8, 1.8, 0.04, 0.2},     ItemSize{Item::radiator, 0.7, 1.4, 0.1, 0.15},
    ItemSize{Item::pipe, 0.16, 0.16, 0.16, 0.1},    ItemSize{Item::extinguisher, 0.2, 0.2, 0.2, 0.1},
    ItemSize{Item::cupboard, 0.8, 1.6, 0.36, 0.14}, ItemSize{Item::shelf, 0.7, 1.2, 0.3, 0.07},
    ItemSize{Item::pillar, 0.3, 0.5, 0.15, 0.08},   ItemSize{Item::plant, 0.36, 0.36, 0.36, 0.05},
    ItemSize{Item::bench, 1.0, 1.6, 0.36, 0.05},    ItemSize{Item::panel, 0.4, 0.7, 0.14, 0.06}};

void add_item(MeshBuilder& builder, RandomStream& random, Item item, double width, double depth, double ceiling) {
  switch (item) {
    case Item::board:
      return add_notice_board(builder, random, width);
    case Item::radiator:
      return add_radiator(builder, width);
    case Item::pipe:
      return add_pipe(builder, ceiling);
    case Item::extinguisher:
      return add_extinguisher(builder);
    case Item::cupboard:
      return add_cupboard(builder, width, depth - 0.03, random.uniform() < 0.6 ? 1.95 : 1.0);
    case Item::shelf:
      return add_open_shelf(builder, random, width, depth, random.uniform(1.2, 2.0));
    case Item::pillar:
      return builder.box({0, 0, 0}, {width, depth, ceiling}, m::kPlaster);
    case Item::plant:
      return add_plant(builder, random, {0.18, 0.18}, 0.17, random.uniform(0.9, 1.6));
    case Item::bench:
      return add_bench(builder, width);
    case Item::panel:
      builder.box({0, 0, 1.1}, {width, depth, 1.9}, m::kMetal);
      return builder.box({0.05, 0, 1.9}, {0.1, 0.05, ceiling}, m::kMetal);
  }
}

ItemSize drawn(RandomStream& random) {
  double u = random.uniform();
  for (const ItemSize& size : kItems) {
    if (u < size.share) return size;
    u -= size.share;
  }
  return kItems.front();
}

/// Frame on one of the four sides of a room, `along` from the end where its x begins.
Placement side_of(const Rect& area, int side, double along) {
  const Vec2 &low = area.low, &high = area.high;
  switch (side) {
    case 0:
      return at_wall(Vec2(low.x() + along, low.y()), Vec2(0, 1));
    case 1:
      return at_wall(Vec2(high.x() - along, high.y()), Vec2(0, -1));
    case 2:
      return at_wall(Vec2(low.x(), high.y() - along), Vec2(1, 0));
    default:
      return at_wall(Vec2(high.x(), low.y() + along), Vec2(-1, 0));
  }
}

/// Two desks face to face with their chairs, free in the room.
void add_island(MeshBuilder& builder, Site& site, RandomStream& random, const Rect& area) {
  const Vec2 margin = 0.5 * area.size() - Vec2(1.2, 1.6);
  if (margin.minCoeff() < 0) return;
  const Vec2 at = area.centre() + Vec2(random.uniform(-1, 1) * margin.x(), random.uniform(-1, 1) * margin.y());
  const Placement centre{Vec3(at.x(), at.y(), 0), random.uniform() < 0.5 ? 0 : 0.5 * std::numbers::pi};
  if (!site.claim(centre, {-0.8, -1.5}, {0.8, 1.5})) return;
  const auto island = builder.place(centre);
  for (const double yaw : {0.0, std::numbers::pi}) {
    const auto half = builder.place({Vec3::Zero(), yaw});
    const auto desk = builder.place({Vec3(-0.75, 0.02, 0), 0});
    add_desk(builder, random, 1.5, 0.75);
    add_chair(builder, {random.uniform(0.5, 1.0), random.uniform(0.95, 1.1)}, random.uniform(-2, 2));
  }
}

}  // namespace

void add_desk(MeshBuilder& builder, RandomStream& random, double width, double depth) {
  builder.box({0, 0, 0.72}, {width, depth, 0.75}, m::kWood);
  for (const double x : {0.03, width - 0.08}) {
    for (const double y : {0.03, depth - 0.08}) builder.box({x, y, 0}, {x + 0.05, y + 0.05, 0.72}, m::kMetal);
  }
  builder.box({0.1, 0.08, 0.1}, {0.5, depth - 0.1, 0.6}, m::kWood);  // drawers
  const double screen = random.uniform(0.3, width - 0.9);
  builder.box({screen, 0.16, 0.86}, {screen + 0.55, 0.19, 1.2}, m::kBlackPaint);
  builder.box({screen + 0.24, 0.17, 0.75}, {screen + 0.31, 0.21, 0.9}, m::kMetal);
  builder.box({screen + 0.05, 0.4, 0.75}, {screen + 0.5, 0.55, 0.77}, m::kBlackPaint);
  const double papers = random.uniform(0.05, width - 0.3);
  builder.box({papers, depth - 0.4, 0.75}, {papers + 0.21, depth - 0.1, random.uniform(0.76, 0.95)}, m::kPaper);
}

void add_chair(MeshBuilder& builder, const Vec2& at, double yaw) {
  const auto chair = builder.place({Vec3(at.x(), at.y(), 0), yaw});
  builder.box({-0.22, -0.22, 0.44}, {0.22, 0.22, 0.5}, m::kCloth);
  builder.box({-0.2, 0.2, 0.55}, {0.2, 0.25, 1.0}, m::kCloth);
  builder.frustum({0, 0, 0.08}, 0.03, 0.03, 0.36, 6, m::kMetal);
  builder.box({-0.24, -0.03, 0.04}, {0.24, 0.03, 0.09}, m::kBlackPaint);
  builder.box({-0.03, -0.24, 0.04}, {0.03, 0.24, 0.09}, m::kBlackPaint);
}

void add_plant(MeshBuilder& builder, RandomStream& random, const Vec2& at, double radius, double height) {
  builder.frustum({at.x(), at.y(), 0}, 0.65 * radius, 0.85 * radius, 0.35, 8, m::kBrick);
  builder.frustum({at.x(), at.y(), 0.35}, 0.02, 0.02, height - 0.6, 5, m::kWood);
  // Leaves: small ellipsoids round the stem, within the radius.
  for (int k = 0; k < 7; ++k) {
    const double angle = random.uniform(0, 2 * std::numbers::pi), out = random.uniform(0.2, 0.5) * radius;
    const double z = random.uniform(0.55, 1.0) * height;
    builder.ellipsoid({at.x() + out * std::cos(angle), at.y() + out * std::sin(angle), z},
                      {0.45 * radius, 0.45 * radius, random.uniform(0.08, 0.16)}, 4, m::kFoliage);
  }
}

void furnish(MeshBuilder& builder, Site& site, RandomStream& random, const Rect& area) {
  add_island(builder, site, random, area);
  const int tries = static_cast<int>(std::min(30.0, 0.6 * area.size().prod())) + 3;
  for (int k = 0; k < tries; ++k) {
    const int side = static_cast<int>(random.uniform(0, 4));
    const double length = side < 2 ? area.size().x() : area.size().y();
    const double u = random.uniform(), v = random.uniform();
    const double width = u < 0.4 ? 1.4 : (u < 0.75 ? random.uniform(0.8, 1.4) : 0.4);
    const double depth = u < 0.4 ? 1.5 : (u < 0.75 ? random.uniform(0.35, 0.5) : 0.4);
    if (length < width + 0.1) continue;
    const Placement place = side_of(area, side, v * (length - width));
    if (!site.claim(place, {0, 0}, {width, depth})) continue;
    const auto here = builder.place(place);
    if (u < 0.4) {
      add_desk(builder, random, width, 0.7);
      add_chair(builder, {random.uniform(0.5, 0.9), random.uniform(0.95, 1.15)}, random.uniform(-1.5, 1.5));
    } else if (u < 0.6) {
      add_cupboard(builder, width, depth - 0.03, random.uniform(0.8, 2.0));
    } else if (u < 0.75) {
      add_open_shelf(builder, random, width, depth, random.uniform(1.2, 2.1));
    } else if (u < 0.9) {
      add_plant(builder, random, {0.2, 0.2}, 0.19, random.uniform(0.9, 1.7));
    } else {
      builder.frustum({0.2, 0.2, 0}, 0.12, 0.15, 0.35, 10, m::kBlackPaint);  // bin
    }
  }
}

void dress_wall(MeshBuilder& builder, Site& site, RandomStream& random, const WallFace& face, double density) {
  const double length = face.length();
  if (density <= 0 || face.high < 2) return;
  const Placement place = at_wall(face);
  const auto here = builder.place(place);
  if (length > 0.25) builder.box({0, 0, 0}, {length, 0.012, 0.08}, m::kWood);
  for (double x = random.uniform(0.1, 1.2) / density; x < length - 0.2;) {
    const ItemSize size = drawn(random);
    const double width = random.uniform(size.least, size.most);
    if (x + width < length && site.claim(place, {x, 0}, {x + width, size.depth})) {
      const auto item = builder.place({Vec3(x, 0, 0), 0});
      add_item(builder, random, size.item, width, size.depth, face.high);
      x += width;
    }
    x += random.uniform(0.2, 1.6) / density;
  }
}

void dress_walls(MeshBuilder& builder, Site& site, std::uint64_t seed, double density) {
  const std::vector<WallFace> faces = site.grid().walls();
  for (std::size_t k = 0; k < faces.size(); ++k) {
    if (faces[k].low != 0) continue;
    RandomStream random(seed, purpose::kLayout, 100'000 + k);
    dress_wall(builder, site, random, faces[k], density);
  }
}

void dress_ceiling(MeshBuilder& builder, const PlanGrid& grid, RandomStream& random, const Run& run, double half_width,
                   double height) {
  const double depth = std::min(0.25, height - 2.3);
  const auto box = [&](const Rect& area, double low, std::uint8_t reflectivity) {
    if (grid.free(area, low, height))
      builder.box({area.low.x(), area.low.y(), low}, {area.high.x(), area.high.y(), height}, reflectivity);
  };
  for (double s = run.lo + random.uniform(0.3, 1.2); s < run.hi; s += random.uniform(2.2, 3.0)) {
    box(run.rect(s, s + 1.2, -0.15, 0.15), height - 0.07, m::kWhitePaint);
    if (depth > 0.05 && random.uniform() < 0.5)
      box(run.rect(s + 1.5, s + 1.75, -half_width, half_width), height - depth, m::kPlaster);
  }
  const double tray = (random.uniform() < 0.5 ? -1 : 1) * (half_width - 0.2);  // of cables, along a wall
  const double top = height - 0.06, low = std::max(2.25, top - 0.1);
  for (double s = run.lo; s < run.hi && low < top; s += 1) {
    const Rect area = run.rect(s, std::min(s + 1, run.hi), tray - 0.12, tray + 0.12);
    if (grid.free(area, low, top))
      builder.box({area.low.x(), area.low.y(), low}, {area.high.x(), area.high.y(), top}, m::kMetal);
  }
}

void hang_lamps(MeshBuilder& builder, const PlanGrid& grid, const Rect& area, double height) {
  const Vec2 size = area.size();
  const int nx = static_cast<int>(size.x() / 2.4), ny = static_cast<int>(size.y() / 2.4);
  for (int j = 0; j < ny; ++j) {
    for (int i = 0; i < nx; ++i) {
      const Vec2 at = area.low + Vec2(size.x() * (i + 0.5) / nx, size.y() * (j + 0.5) / ny);
      const Rect lamp{at - Vec2(0.6, 0.12), at + Vec2(0.6, 0.12)};
      if (!grid.free(lamp, height - 0.08, height)) continue;
      builder.box({lamp.low.x(), lamp.low.y(), height - 0.08}, {lamp.high.x(), lamp.high.y(), height}, m::kWhitePaint);
    }
  }
}

}  // namespace aslio::simulator::indoor
