#include "overlaps/soft_voxel.hpp"

#include <cmath>

namespace aslio::plugins {

namespace {

constexpr int kDeepest = static_cast<int>(kMaxLayers) - 1;

/// Half up, also where 0.3 / 0.2 is a little less than 1.5.
double whole_voxels(double margin, double voxel) { return std::floor(margin / voxel + 0.5 + 1e-9); }

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
  VoxelOverlap::describe(b, p);
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
  b.require(!(p.layers && p.margin_m), "margin_m", "excludes layers: give the one or the other");
  b.require(!p.layers || *p.layers == std::floor(*p.layers), "layers", "must be a whole number");
  b.require(!p.margin_m || whole_voxels(*p.margin_m, p.voxel) <= kDeepest, "margin_m", "must be at most 7 voxels");
  b.require(!p.margin_m || *p.margin_m == 0.0 || whole_voxels(*p.margin_m, p.voxel) >= 1.0, "margin_m",
            "is less than half a voxel, which is no margin: give half a voxel or more, or 0");
  const bool listed = p.beta == Beta::list;
  b.require(listed || p.beta_list.empty(), "beta_list", "is used with 'beta: list' only");
  b.require(!listed || p.beta_list.size() == static_cast<std::size_t>(depth(p)), "beta_list",
            "must have one weight per layer");
  b.require(falling_below_one(p.beta_list), "beta_list", "must not increase from layer to layer");
}

int SoftVoxel::depth(const Params& p) {
  if (p.margin_m) return static_cast<int>(whole_voxels(*p.margin_m, p.voxel));
  return p.layers ? static_cast<int>(*p.layers) : kDefaultLayers;
}

// The beta_i of eq. SOD-2.
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

SoftVoxel::SoftVoxel(const Params& p, const BuildContext& context) : VoxelOverlap(p, p.metric, weights(p), context) {}

}  // namespace aslio::plugins
