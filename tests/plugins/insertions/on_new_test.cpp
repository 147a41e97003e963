#include "insertions/on_new.hpp"

#include <catch2/catch.hpp>
#include <map>

#include "plugins/build_environment.hpp"

namespace aslio {
namespace {

/// Remembers what it was given.
class RecordingMap final : public Map {
 public:
  void correspond(std::span<const Vec3>, const MapQuery&, Neighbours&) const override {}
  InsertCount insert(std::span<const WorldPoint> points, std::uint32_t stamp) override {
    for (const WorldPoint& p : points) stamps.emplace(p.t, stamp);
    return {.offered = points.size(), .inserted = points.size() / 2};
  }
  void trim(const Vec3&) override {}
  void clear() override { stamps.clear(); }
  std::size_t size() const override { return stamps.size(); }
  std::size_t memory_bytes() const override { return 0; }
  double radius() const override { return 0; }
  void visit(const std::function<void(const Vec3&)>&) const override {}

  std::multimap<TimeNs, std::uint32_t> stamps;
};

}  // namespace

TEST_CASE("on_new inserts each fresh point of the map tap once, under the number of its update") {
  test::BuildEnvironment environment;
  plugins::InsertOnNew insertion({}, environment.context());
  RecordingMap map;
  std::size_t offered = 0;
  TimeNs t = 0;
  for (std::uint32_t k = 1; k <= 20; ++k) {
    std::vector<WorldPoint> map_points(10 * k % 37), match_points(50), overlap_points(70);
    for (WorldPoint& p : map_points) p.t = ++t;
    for (WorldPoint& p : match_points) p.t = -1;
    for (WorldPoint& p : overlap_points) p.t = -2;
    Update update;
    update.map_points = map_points;
    update.match_points = match_points;
    update.overlap_points = overlap_points;
    Window window;
    window.sequence = k;
    const InsertCount count = insertion.apply(window, update, map);
    CHECK(count.offered == map_points.size());
    CHECK(count.inserted == map_points.size() / 2);  // what the map says, not what it was offered
    offered += count.offered;
    for (const WorldPoint& p : map_points) {
      REQUIRE(map.stamps.count(p.t) == 1);
      CHECK(map.stamps.find(p.t)->second == k);
    }
  }
  CHECK(map.size() == offered);
  CHECK(map.size() == static_cast<std::size_t>(t));
}

}  // namespace aslio
