#pragma once
/// `full`: every old point of the window counts like a fresh one, as in SR-LIO, where they are points of one
/// reconstructed sweep. (HIS-4)

#include "aslio/stages/build_context.hpp"
#include "histories/window_history.hpp"

namespace aslio::plugins {

class FullHistory final : public WindowHistory {
 public:
  using Params = Reuse;
  static void describe(config::Binder& b, Params& p) { Reuse::describe(b, p); }

  FullHistory(const Params& params, const BuildContext&) : WindowHistory(params) {}

  double weight(std::size_t, std::size_t history_residuals) const override {
    return history_residuals == 0 ? 0.0 : 1.0;
  }
};

}  // namespace aslio::plugins
