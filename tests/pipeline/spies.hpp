#pragma once
/// Stages that watch the stages they wrap. A catalog of spies builds every pipeline file unchanged.

#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "aslio/plugin/registry.hpp"
#include "aslio/stages/insertion.hpp"
#include "aslio/stages/overlap.hpp"

namespace aslio::test {

/// What the spies tell, in the order of the calls.
class Observer {
 public:
  virtual ~Observer() = default;
  virtual void before(const std::string& call) = 0;
  virtual void after(const std::string& call) = 0;
  virtual void on_evaluate(std::span<const WorldPoint>) {}
  virtual void on_select(const HistorySelection&) {}
  virtual void on_insert(const Window&, const Update&) {}
};

/// Tells the begin and the end of a call.
class Call {
 public:
  Call(Observer& observer, const char* name) : observer_(observer), name_(name) { observer_.before(name_); }
  ~Call() { observer_.after(name_); }
  Call(const Call&) = delete;
  Call& operator=(const Call&) = delete;

 private:
  Observer& observer_;
  std::string name_;  // short: no allocation
};

class WindowSpy final : public WindowStrategy {
 public:
  WindowSpy(std::unique_ptr<WindowStrategy> inner, Observer& o) : inner_(std::move(inner)), observer_(o) {}
  std::optional<WindowPlan> next(const StreamView& stream, const Feedback& feedback, OverlapProbe& probe) override {
    const Call call(observer_, "next");
    return inner_->next(stream, feedback, probe);
  }
  TimeNs reach() const override { return inner_->reach(); }
  bool gives_cuts() const override { return inner_->gives_cuts(); }
  bool decides_by_imu() const override { return inner_->decides_by_imu(); }

 private:
  std::unique_ptr<WindowStrategy> inner_;
  Observer& observer_;
};

class OverlapSpy final : public OverlapMetric {
 public:
  OverlapSpy(std::unique_ptr<OverlapMetric> inner, Observer& o) : inner_(std::move(inner)), observer_(o) {}
  void advance(TimeNs t) override { inner_->advance(t); }
  OverlapScore evaluate(std::span<const WorldPoint> points, TimeNs t) override {
    const Call call(observer_, "evaluate");
    observer_.on_evaluate(points);
    return inner_->evaluate(points, t);
  }
  void extend(std::span<const WorldPoint> points, TimeNs t) override {
    const Call call(observer_, "extend");
    inner_->extend(points, t);
  }
  void trim(const Vec3& centre_W, double radius) override { inner_->trim(centre_W, radius); }
  bool frames_reach_back() const override { return inner_->frames_reach_back(); }
  void clear() override { inner_->clear(); }
  std::size_t memory_bytes() const override { return inner_->memory_bytes(); }

 private:
  std::unique_ptr<OverlapMetric> inner_;
  Observer& observer_;
};

class HistorySpy final : public HistoryPolicy {
 public:
  HistorySpy(std::unique_ptr<HistoryPolicy> inner, Observer& o) : inner_(std::move(inner)), observer_(o) {}
  bool gives_points() const override { return inner_->gives_points(); }
  HistorySelection select(const Window& window) override {
    const Call call(observer_, "select");
    const HistorySelection selection = inner_->select(window);
    observer_.on_select(selection);
    return selection;
  }
  double weight(std::size_t fresh, std::size_t history) const override { return inner_->weight(fresh, history); }
  double gate(double sigma) const override { return inner_->gate(sigma); }
  void commit(const Window& window, const Update& update) override {
    const Call call(observer_, "commit");
    inner_->commit(window, update);
  }
  void reset() override {
    const Call call(observer_, "reset");
    inner_->reset();
  }

 private:
  std::unique_ptr<HistoryPolicy> inner_;
  Observer& observer_;
};

class EstimatorSpy final : public Estimator {
 public:
  EstimatorSpy(std::unique_ptr<Estimator> inner, Observer& o) : inner_(std::move(inner)), observer_(o) {}
  MapContent map_content() const override { return inner_->map_content(); }
  bool uses_imu() const override { return inner_->uses_imu(); }
  bool uses_history() const override { return inner_->uses_history(); }
  bool uses_cuts() const override { return inner_->uses_cuts(); }
  bool uses_features() const override { return inner_->uses_features(); }
  void reset(const InitialState& initial) override { inner_->reset(initial); }
  void adopt(const InertialEstimate& better) override { inner_->adopt(better); }
  const Update& update(const Window& window, const HistorySelection& past, const StepContext& context) override {
    const Call call(observer_, "update");
    return inner_->update(window, past, context);
  }
  const NavState& state() const override { return inner_->state(); }
  NavState predict(std::span<const ImuSample> imu) const override { return inner_->predict(imu); }

 private:
  std::unique_ptr<Estimator> inner_;
  Observer& observer_;
};

class InsertionSpy final : public Insertion {
 public:
  InsertionSpy(std::unique_ptr<Insertion> inner, Observer& o) : inner_(std::move(inner)), observer_(o) {}
  bool needs_nearest_points() const override { return inner_->needs_nearest_points(); }
  InsertCount begin(const Window& window, Map& map) override { return inner_->begin(window, map); }
  void finish(Map& map) override { inner_->finish(map); }
  InsertCount apply(const Window& window, const Update& update, Map& map) override {
    observer_.on_insert(window, update);
    const Call call(observer_, "insert");
    return inner_->apply(window, update, map);
  }

 private:
  std::unique_ptr<Insertion> inner_;
  Observer& observer_;
};

/// The stages of `real`, those of five families wrapped. Both arguments must outlive what is built from the catalog.
plugin::Catalog spied(const plugin::Catalog& real, Observer& observer);

}  // namespace aslio::test
