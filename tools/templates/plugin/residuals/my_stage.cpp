#include "my_stage.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "aslio/plugin/entry.hpp"

namespace my_plugin {

using namespace aslio;

namespace {
constexpr std::size_t kMatchesPerChunk = 256;
}

void MyStage::describe(config::Binder& b, Params& p) {
  b.integer("k", p.k, "", {.min = 3, .max = Neighbours::kMax}, "neighbours of a plane, all of which must be found");
  b.real("max_distance", p.max_distance, "m", {.above = 0.0, .max = 10.0},
         "neighbours farther than this are not looked at");
  b.real("thickness", p.thickness, "m", {.above = 0.0}, "RMS distance of the neighbours from their plane at most");
  b.real("gate", p.gate, "", {.above = 0.0}, "a row takes part while |r| < gate * sigma");
}

MyStage::MyStage(const Params& params, const BuildContext& context) : params_(params), exec_(context.exec) {}

MapQuery MyStage::query() const { return {.k = static_cast<int>(params_.k), .max_distance = params_.max_distance}; }

Surface MyStage::plane_of(const Vec3& query, const Neighbours& neighbours, std::size_t row) const {
  const auto k = static_cast<std::size_t>(params_.k);
  if (neighbours.k() < k || neighbours.count[row] < k) return {};
  Vec3 mean = Vec3::Zero();
  for (std::size_t j = 0; j < k; ++j) mean += neighbours.offset(row, j).cast<double>();
  mean /= static_cast<double>(k);
  Mat3 scatter = Mat3::Zero();
  for (std::size_t j = 0; j < k; ++j) {
    const Vec3 d = neighbours.offset(row, j).cast<double>() - mean;
    scatter += d * d.transpose() / static_cast<double>(k);
  }
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(scatter);
  const Vec3 variance = solver.eigenvalues();  // ascending
  if (!variance.allFinite() || variance[0] > params_.thickness * params_.thickness) return {};
  if (variance[1] < 0.01 * variance[2]) return {};  // a line spans no plane
  return {.normal = solver.eigenvectors().col(0), .anchor = query + mean, .quality = 1.0, .valid = true};
}

void MyStage::fit(std::span<const Vec3> queries, const Neighbours& neighbours, std::span<Surface> out) {
  exec_.for_ranges(queries.size(), kMatchesPerChunk, [&](std::size_t begin, std::size_t end, std::size_t) {
    for (std::size_t i = begin; i < end; ++i) out[i] = plane_of(queries[i], neighbours, i);
  });
}

void MyStage::evaluate(std::span<const Vec3> world, std::span<const float> range, std::span<const Surface> surfaces,
                       double sigma, std::span<ResidualRow> rows) {
  (void)range;
  for (std::size_t i = 0; i < world.size(); ++i) {
    rows[i] = {};
    if (!surfaces[i].valid) continue;
    const double r = surfaces[i].normal.dot(world[i] - surfaces[i].anchor);
    if (!std::isfinite(r)) continue;
    // What the gate leaves out is measured all the same: a history asks how far off it was.
    const bool inside = std::abs(r) < params_.gate * sigma;
    rows[i] = {.r = r, .J = surfaces[i].normal, .information = inside ? surfaces[i].quality / (sigma * sigma) : 0.0};
  }
}

namespace {

void register_types(plugin::Catalog& catalog) {
  plugin::Registry<Residual>(catalog).add<MyStage>("my_stage", "Distance from the plane through the nearest points.");
}

}  // namespace

}  // namespace my_plugin

ASLIO_PLUGIN(my_plugin::register_types)
