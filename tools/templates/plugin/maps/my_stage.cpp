#include "my_stage.hpp"

#include <algorithm>
#include <cmath>

#include "aslio/plugin/entry.hpp"

namespace my_plugin {

using namespace aslio;

namespace {

constexpr std::size_t kQueriesPerChunk = 64;

/// The nearest so far, in ascending order; of equal ones, the first inserted comes first.
struct Nearest {
  struct Found {
    double squared;
    std::uint64_t order;
    Vec3 offset;
  };
  void offer(const Found& found, std::size_t k) {
    std::size_t place = count;
    while (place > 0 && (found.squared < best[place - 1].squared ||
                         (found.squared == best[place - 1].squared && found.order < best[place - 1].order))) {
      --place;
    }
    if (place >= k) return;
    count = std::min(count + 1, k);
    for (std::size_t j = count - 1; j > place; --j) best[j] = best[j - 1];
    best[place] = found;
  }
  std::array<Found, Neighbours::kMax> best;
  std::size_t count = 0;
};

}  // namespace

void MyStage::describe(config::Binder& b, Params& p) {
  b.real("cube", p.cube, "m", {.min = 0.1, .max = 100.0}, "edge of a cube; about the distance that is searched");
  b.real("min_spacing", p.min_spacing, "m", {.min = 0.0, .max = 10.0},
         "points nearer than this to one of their cube stay out (0: none does)");
  b.real("radius", p.radius, "m", {.min = 1.0, .max = 10000.0}, "points farther than this are forgotten");
}

MyStage::MyStage(const Params& params, const BuildContext& context) : params_(params), exec_(context.exec) {}

bool MyStage::cube_of(const Vec3& p, Cube& cube) const {
  const Vec3 scaled = p / params_.cube;
  if (!scaled.allFinite() || scaled.cwiseAbs().maxCoeff() > 1e9) return false;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    cube[axis] = static_cast<std::int32_t>(std::floor(scaled[static_cast<Eigen::Index>(axis)]));
  }
  return true;
}

void MyStage::correspond(std::span<const Vec3> queries, const MapQuery& query, Neighbours& out) const {
  out.resize(queries.size(), query.k);
  // Chunks depend on the number of queries alone, and so do the results, whatever the number of threads.
  exec_.for_ranges(queries.size(), kQueriesPerChunk, [&](std::size_t begin, std::size_t end, std::size_t) {
    for (std::size_t i = begin; i < end; ++i) nearest(queries[i], query, i, out);
  });
}

void MyStage::nearest(const Vec3& query, const MapQuery& ask, std::size_t row, Neighbours& out) const {
  out.count[row] = 0;
  Cube low, high;
  const Vec3 reach = Vec3::Constant(ask.max_distance);
  if (!cube_of(query - reach, low) || !cube_of(query + reach, high)) return;
  Nearest nearest;
  for (std::int32_t x = low[0]; x <= high[0]; ++x) {
    for (std::int32_t y = low[1]; y <= high[1]; ++y) {
      // Cubes above each other are neighbours in the sorted map.
      const auto last = cubes_.upper_bound({x, y, high[2]});
      for (auto cube = cubes_.lower_bound({x, y, low[2]}); cube != last; ++cube) {
        for (const Stored& stored : cube->second) {
          const Vec3 offset = stored.p_W - query;
          const double squared = offset.squaredNorm();
          if (stored.stamp > ask.max_stamp || squared > ask.max_distance * ask.max_distance) continue;
          nearest.offer({squared, stored.order, offset}, static_cast<std::size_t>(ask.k));
        }
      }
    }
  }
  out.count[row] = static_cast<std::uint8_t>(nearest.count);
  for (std::size_t j = 0; j < nearest.count; ++j) {
    out.offsets[row * out.k() + j] = nearest.best[j].offset.cast<float>();
    out.squared[row * out.k() + j] = static_cast<float>(nearest.best[j].squared);
  }
}

InsertCount MyStage::insert(std::span<const WorldPoint> points, std::uint32_t stamp) {
  InsertCount count{.offered = points.size(), .inserted = 0};
  Cube cube;
  for (const WorldPoint& point : points) {
    if (!cube_of(point.p_W, cube)) continue;
    std::vector<Stored>& members = cubes_[cube];
    const auto too_near = [&](const Stored& stored) { return (stored.p_W - point.p_W).norm() < params_.min_spacing; };
    if (std::any_of(members.begin(), members.end(), too_near)) continue;
    members.push_back({point.p_W, inserted_++, stamp});
    ++count.inserted;
  }
  size_ += count.inserted;
  return count;
}

void MyStage::trim(const Vec3& centre_W) {
  if (!centre_W.allFinite()) return;
  std::erase_if(cubes_, [&](const auto& entry) {
    const auto& [x, y, z] = entry.first;
    const Vec3 centre = params_.cube * Vec3(x + 0.5, y + 0.5, z + 0.5);
    if ((centre - centre_W).norm() <= params_.radius + params_.cube) return false;
    size_ -= entry.second.size();
    return true;
  });
}

void MyStage::clear() {
  cubes_.clear();
  size_ = 0;
}

std::size_t MyStage::memory_bytes() const {
  constexpr std::size_t links = 4 * sizeof(void*);
  std::size_t bytes = 0;
  for (const auto& [cube, members] : cubes_) {
    bytes += sizeof(cube) + sizeof(members) + links + members.capacity() * sizeof(Stored);
  }
  return bytes;
}

void MyStage::visit(const std::function<void(const Vec3&)>& visitor) const {
  for (const auto& [cube, members] : cubes_) {
    for (const Stored& stored : members) visitor(stored.p_W);
  }
}

namespace {

void register_types(plugin::Catalog& catalog) {
  plugin::Registry<Map>(catalog).add<MyStage>("my_stage", "Cubes of points, searched exactly.");
}

}  // namespace

}  // namespace my_plugin

ASLIO_PLUGIN(my_plugin::register_types)
