#pragma once
/// `none`: every update stands on its fresh points alone.

#include "aslio/config/binder.hpp"
#include "aslio/stages/build_context.hpp"
#include "aslio/stages/history.hpp"

namespace aslio::plugins {

class NoHistory final : public HistoryPolicy {
 public:
  struct Params {};
  static void describe(config::Binder&, Params&) {}

  NoHistory(const Params&, const BuildContext&) {}

  bool gives_points() const override { return false; }
  HistorySelection select(const Window&) override { return {}; }
  double weight(std::size_t, std::size_t) const override { return 0.0; }
  double gate(double) const override { return 0.0; }
  void commit(const Window&, const Update&) override {}
  void reset() override {}
};

}  // namespace aslio::plugins
