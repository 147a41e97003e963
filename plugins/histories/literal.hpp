#pragma once
/// `literal`: every old point of the window at one constant weight, as AS-LIO words it ("appropriate weight
/// adjustment"): matched like a fresh point, itself included, and counted as evidence each time. (HIS-4)

#include "aslio/stages/build_context.hpp"
#include "histories/window_history.hpp"

namespace aslio::plugins {

class LiteralHistory final : public WindowHistory {
 public:
  struct Params {
    double weight = 0.5;
    Reuse reuse;
  };
  static void describe(config::Binder& b, Params& p) {
    b.real("weight", p.weight, "", {.above = 0.0, .max = 1000.0}, "of a history residual, relative to a fresh one");
    Reuse::describe(b, p.reuse);
  }

  LiteralHistory(const Params& params, const BuildContext&) : WindowHistory(params.reuse), weight_(params.weight) {}

  double weight(std::size_t, std::size_t history_residuals) const override {
    return history_residuals == 0 ? 0.0 : weight_;
  }

 private:
  double weight_;
};

}  // namespace aslio::plugins
