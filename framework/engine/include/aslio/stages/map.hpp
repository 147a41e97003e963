#pragma once
/// Maps: nearest neighbours or surfaces around world points, in batches.

#include <algorithm>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "aslio/config/nested.hpp"
#include "aslio/stages/points.hpp"
#include "aslio/stages/surface.hpp"

namespace aslio {

/// What to look for around each query.
struct MapQuery {
  int k = 5;                             ///< up to this many neighbours, 1..Neighbours::kMax
  double max_distance = 1.0;             ///< [m]
  std::uint32_t max_stamp = 0xffffffff;  ///< only points inserted at this update or before
  std::uint8_t feature = 0;              ///< feature_class; only maps that say so separate its kinds
  std::optional<Vec3> viewpoint = {};    ///< of the sensor, W [m]; for maps that separate the faces of a wall
};

/// Neighbours of a batch of queries. offset(i, j) = neighbour j of query i MINUS the query [m] (float is exact enough
/// there however far from the origin the map lies), ascending in distance; ties in order of insertion.
class Neighbours {
 public:
  static constexpr int kMax = 20;

  void resize(std::size_t queries, int k) {
    k_ = static_cast<std::size_t>(k);
    count.resize(queries);
    offsets.resize(queries * k_);
    squared.resize(queries * k_);
  }
  std::size_t k() const { return k_; }
  std::size_t size() const { return count.size(); }
  const Eigen::Vector3f& offset(std::size_t query, std::size_t j) const { return offsets[query * k_ + j]; }

  std::vector<std::uint8_t> count;       ///< neighbours found per query
  std::vector<Eigen::Vector3f> offsets;  ///< [query * k + j]
  std::vector<float> squared;            ///< squared distances [m^2], same layout

 private:
  std::size_t k_ = 0;
};

/// What insert() did.
struct InsertCount {
  std::size_t offered = 0;
  std::size_t inserted = 0;  ///< the rest was refused as too close to what is there, full, or not finite
};

/// What a map holds, and so which of its two questions it answers.
enum class MapContent : std::uint8_t { points, surfaces };

/// Contract. A map of points answers correspond(), a map of surfaces answers surfaces(); the other one finds nothing.
/// Both are const and may be called many times per update; they run their own loop over the batch with
/// the executor they were built with and allocate nothing beyond `out`'s growth. Exactness is stated by each map (voxel
/// maps see a fixed neighbourhood of cells). Same bits for any number of threads. insert() keeps the order given.
/// trim() forgets what lies farther than the map's own radius from `centre_W` (it may keep up to one coarse cell more),
/// so that memory is bounded by the radius; amortised.
class Map : public Stage {
 public:
  static constexpr std::string_view family = "maps";
  virtual MapContent content() const { return MapContent::points; }
  virtual void correspond(std::span<const Vec3> queries, const MapQuery& query, Neighbours& out) const = 0;
  /// The surface at each query, in W; not valid where there is none. Of the query, max_stamp and viewpoint count.
  virtual void surfaces(std::span<const Vec3> queries, const MapQuery& query, std::span<Surface> out) const {
    (void)queries, (void)query;
    std::fill(out.begin(), out.end(), Surface{});
  }
  virtual InsertCount insert(std::span<const WorldPoint> points, std::uint32_t stamp) = 0;
  /// Lengths that are about the noise of points (how thick a plane may be) count so many times what the parameters say
  /// from here on, for what was inserted before, too; not the last factor times this one. Between updates; > 0.
  virtual void set_noise_scale(double scale) { (void)scale; }
  virtual void trim(const Vec3& centre_W) = 0;
  virtual void clear() = 0;
  virtual std::size_t size() const = 0;
  virtual std::size_t memory_bytes() const = 0;
  /// Distance beyond which trim() forgets [m].
  virtual double radius() const = 0;
  /// Visits every point (world, metres) in a deterministic order.
  virtual void visit(const std::function<void(const Vec3&)>& visitor) const = 0;
};

}  // namespace aslio
