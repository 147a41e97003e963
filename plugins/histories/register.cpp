#include "aslio/plugin/registry.hpp"
#include "histories/balanced.hpp"
#include "histories/full.hpp"
#include "histories/literal.hpp"
#include "histories/none.hpp"

namespace aslio::plugins {

void register_histories(plugin::Registry<HistoryPolicy>& registry);

void register_histories(plugin::Registry<HistoryPolicy>& registry) {
  registry.add<NoHistory>("none", "every update stands on its fresh points alone");
  registry.add<BalancedHistory>("balanced", "old points of the window weigh together a set share of the fresh ones");
  registry.add<LiteralHistory>("literal",
                               "every old point of the window at one constant weight, as in the text of the paper");
  registry.add<FullHistory>("full", "every old point of the window counts like a fresh one, as in SR-LIO");
}

}  // namespace aslio::plugins
