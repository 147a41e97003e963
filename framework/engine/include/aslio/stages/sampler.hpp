#pragma once
/// Samplers: which points take part? A chain; each member thins the points of the uses it names.

#include <algorithm>
#include <span>
#include <string_view>
#include <vector>

#include "aslio/config/nested.hpp"
#include "aslio/stages/points.hpp"
#include "aslio/stages/window.hpp"

namespace aslio {

/// Points of one update as the chain sees them. `uses[i]` says who still wants point i; a sampler clears bits, never
/// sets them. `body` is empty before de-skew; afterwards body[i] is p_I at the end of the window, and only points with
/// a bit left are there: `raw` and `uses` are compacted with it. A body sampler may move a point that it keeps, to the
/// mean of those that it stands for; estimators that take points as measured do not see that.
struct SampleBatch {
  std::span<const TimedPoint> raw;
  std::span<Eigen::Vector3f> body;
  std::span<PointUses> uses;
  /// feature_class of every point, which a body sampler may set. Empty before de-skew, and where nobody keeps them.
  std::span<std::uint8_t> features = {};
};

/// Contract. `acts_on` = raw samplers run before de-skew and must not read `body`; body samplers run after it. A raw
/// sampler decides by a point's own data (its index counts over the stream, so a decision does not depend on where
/// windows were cut) and by the result of the last update. Deterministic; not thread-safe; no allocation after warm-up;
/// O(n).
class Sampler : public Stage {
 public:
  static constexpr std::string_view family = "samplers";
  enum class ActsOn : std::uint8_t { raw, body };
  virtual ActsOn acts_on() const = 0;
  /// Whether it may change `body` of points that it keeps.
  virtual bool moves_points() const { return false; }
  /// Whether it sets the feature_class of points.
  virtual bool gives_features() const { return false; }
  /// Whether it decides by the feature_class of points. If so, one before it has to give it.
  virtual bool takes_features() const { return false; }
  /// Result of the update before, once before every update; after a new start, as before the first.
  virtual void observe(const Feedback&) {}
  virtual void sample(SampleBatch& batch) = 0;
};

/// The chain of a pipeline, in the order of its file within each phase.
class SamplerChain {
 public:
  SamplerChain() = default;
  explicit SamplerChain(std::vector<std::unique_ptr<Sampler>> members) : members_(std::move(members)) {}
  void sample(Sampler::ActsOn phase, SampleBatch& batch) {
    for (auto& member : members_) {
      if (member->acts_on() == phase) member->sample(batch);
    }
  }
  void observe(const Feedback& feedback) {
    for (auto& member : members_) member->observe(feedback);
  }
  bool moves_points() const {
    return std::any_of(members_.begin(), members_.end(), [](const auto& member) { return member->moves_points(); });
  }
  bool gives_features() const {
    return std::any_of(members_.begin(), members_.end(), [](const auto& member) { return member->gives_features(); });
  }
  /// Place of the first that takes features where none before it gives any; size() if there is none such.
  std::size_t first_without_features() const {
    std::size_t i = 0;
    while (i < members_.size() && !members_[i]->takes_features() && !members_[i]->gives_features()) ++i;
    return i < members_.size() && members_[i]->takes_features() ? i : members_.size();
  }
  std::size_t size() const { return members_.size(); }

 private:
  std::vector<std::unique_ptr<Sampler>> members_;
};

}  // namespace aslio
