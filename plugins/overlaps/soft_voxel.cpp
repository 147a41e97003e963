#include "overlaps/soft_voxel.hpp"

#include <cmath>

namespace aslio::plugins {

namespace {

constexpr int kDeepest = static_cast<int>(kMaxLayers) - 1;

bool falling_below_one(const std::vector<double>& beta) {
  double previous = 1.0;
  for (const double b : beta) {
    if (!(b < 1.0 && b <= previous)) return false;
    previous = b;
  }
  return true;
}

}  // namespace

void SoftVoxel::describe(config::Binder& b, Params& p) {
  b.real("voxel", p.voxel, "m", {.min = 0.001, .max = 100.0}, "edge of a voxel");
  b.optional_real("layers", p.layers, "", {.min = 0, .max = kDeepest}, "= 3, unless margin_m says otherwise",
                  "layers of the margin, a whole number of voxels");
  b.optional_real("margin_m", p.margin_m, "m", {.min = 0.0, .max = 700.0}, "= layers * voxel",
                  "reach of the margin, instead of layers; rounded to whole voxels");
  b.choice("metric", p.metric,
           {{"chebyshev", LayerMetric::chebyshev},
            {"manhattan", LayerMetric::manhattan},
            {"euclid", LayerMetric::euclid_rounded}},
           "distance between voxels that defines a layer");
  b.choice("beta", p.beta, {{"linear", Beta::linear}, {"geometric", Beta::geometric}, {"list", Beta::list}},
           "weights of the layers: 1 - i / (d + 1), gamma^i, or beta_list");
  b.real("gamma", p.gamma, "", {.min = 0.0, .below = 1.0}, "base of the geometric weights");
  b.reals("beta_list", p.beta_list, 0, "", {.min = 0.0, .below = 1.0}, "weights of layer 1, 2, .. d, not increasing");
  b.real("delay", p.delay, "s", {.min = 0.0, .max = 100.0},
         "points count as known this long after they were merged (0: at once, which makes the score rise by itself)");
  b.integer("max_points", p.max_points, "", {.min = 0}, "points of a frame that are scored, spread evenly (0: all)");
  b.integer("min_points", p.min_points, "", {.min = 1}, "below this many points the score is undefined");
  b.stage("store", p.store, "what holds the occupied voxels");
  b.require(!(p.layers && p.margin_m), "margin_m", "excludes layers: give the one or the other");
  b.require(!p.layers || *p.layers == std::floor(*p.layers), "layers", "must be a whole number");
  b.require(!p.margin_m || std::round(*p.margin_m / p.voxel) <= kDeepest, "margin_m", "must be at most 7 voxels");
  const bool listed = p.beta == Beta::list;
  b.require(listed || p.beta_list.empty(), "beta_list", "is used with 'beta: list' only");
  b.require(!listed || p.beta_list.size() == static_cast<std::size_t>(depth(p)), "beta_list",
            "must have one weight per layer");
  b.require(falling_below_one(p.beta_list), "beta_list", "must not increase from layer to layer");
}

int SoftVoxel::depth(const Params& p) {
  if (p.margin_m) return static_cast<int>(std::lround(*p.margin_m / p.voxel));
  return p.layers ? static_cast<int>(*p.layers) : kDefaultLayers;
}

std::vector<double> SoftVoxel::weights(const Params& p) {
  const int d = depth(p);
  std::vector<double> beta{1.0};
  for (int i = 1; i <= d; ++i) {
    switch (p.beta) {
      case Beta::linear:
        beta.push_back(1.0 - i / (d + 1.0));
        break;
      case Beta::geometric:
        beta.push_back(beta.back() * p.gamma);
        break;
      case Beta::list:
        beta.push_back(p.beta_list[static_cast<std::size_t>(i - 1)]);
        break;
    }
  }
  return beta;
}

SoftVoxel::SoftVoxel(const Params& p, const BuildContext& context)
    : VoxelOverlap({.voxel = p.voxel,
                    .metric = p.metric,
                    .beta = weights(p),
                    .delay = to_ns(p.delay),
                    .max_points = static_cast<std::size_t>(p.max_points),
                    .min_points = static_cast<std::size_t>(p.min_points),
                    .order_seed = context.order_seed},
                   p.store.make(context), p.store.make(context)) {}

}  // namespace aslio::plugins
