#include "my_stage.hpp"

#include "aslio/plugin/entry.hpp"

namespace my_plugin {

using namespace aslio;

void MyStage::describe(config::Binder& b, Params& p) {
  b.integer("keep_every", p.keep_every, "", {.min = 1, .max = 255}, "one in so many scan lines is kept");
  b.texts("uses", p.uses, {"overlap", "map", "match"}, "whose points are thinned");
}

MyStage::MyStage(const Params& params, const BuildContext& context)
    : keep_every_(static_cast<unsigned>(params.keep_every)) {
  (void)context;
  for (const std::string& use : params.uses) {
    uses_ |= mask(use == "overlap" ? PointUse::overlap : use == "map" ? PointUse::map : PointUse::match);
  }
}

void MyStage::sample(SampleBatch& batch) {
  for (std::size_t i = 0; i < batch.raw.size(); ++i) {
    // Bits are cleared, never set.
    if (batch.raw[i].line % keep_every_ != 0) batch.uses[i] = static_cast<PointUses>(batch.uses[i] & ~uses_);
  }
}

namespace {

void register_types(plugin::Catalog& catalog) {
  plugin::Registry<Sampler>(catalog).add<MyStage>("my_stage", "Keeps the points of every n-th scan line.");
}

}  // namespace

}  // namespace my_plugin

ASLIO_PLUGIN(my_plugin::register_types)
