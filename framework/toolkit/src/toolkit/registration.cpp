#include "aslio/toolkit/registration.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <limits>

#include "aslio/core/cpu_clock.hpp"

namespace aslio {

void judge_view(Update& update, const Mat6& information, double degenerate_sigma, const WindowPlan& plan) {
  set_spectrum(update, information);
  update.unobservable = unobservable_direction(update.spectrum, degenerate_sigma, plan);
  if (update.status == UpdateStatus::ok && update.unobservable) update.status = UpdateStatus::degenerate;
}

void hand_over(Update& update, const DeskewedScan& frame, std::span<const MatchRecord> records, const NavState& state,
               std::span<const NavState> states, const TrajectoryModel& trajectory) {
  update.state = state;
  update.states = states;
  update.trajectory = &trajectory;
  update.matches = records;
  update.overlap_points = frame.world(PointUse::overlap);
  update.map_points = frame.world(PointUse::map);
  update.match_points = frame.world(PointUse::match);
}

Registration::Registration(const Rules& rules, std::unique_ptr<Residual> residual, const BuildContext& context)
    : rules_(rules), exec_(context.exec), residual_(std::move(residual)), frame_(context.sensor) {
  constexpr std::size_t kImuSamples = 256;  // of a window without a gap, at any usual rate
  trajectory_.reserve(kImuSamples);
}

void Registration::restart(const NavState& state) {
  state_ = state;
  P_.setZero();
  result_ = Update{};
}

Vec6 Registration::step(const Pose& prior, const Pose& at, const PoseInformation& all) const {
  (void)prior;
  (void)at;
  return -all.A.ldlt().solve(all.b);
}

void Registration::load(const Window& window, const HistorySelection& past, const StepContext& context) {
  frame_.load(window.fresh, trajectory_, context.samplers, result_.times);
  const CpuTimer timer(result_.times.sample);
  const std::size_t fresh = frame_.match_body().size(), old = past.points.size();
  fresh_.reserve(fresh, *residual_);
  history_.reserve(std::max(fresh, old), *residual_);
  if (records_.capacity() < fresh) records_.reserve(2 * fresh);
  fresh_.body.assign(frame_.match_body().begin(), frame_.match_body().end());
  fresh_.range.assign(frame_.match_range().begin(), frame_.match_range().end());
  history_.load(past, state_.pose());
  result_.history_points = static_cast<std::uint32_t>(old);
}

PoseInformation Registration::sum(PointMatches& matches, const Pose& at, double gate) {
  matches.evaluate(*residual_, sigma_);
  const auto rows = static_cast<std::size_t>(residual_->rows_per_match());
  const Mat3 Rt = at.R.transpose();
  const std::size_t n = matches.body.size();
  partials_.resize(exec::Executor::chunk_count(n, kGrain));
  return exec_.reduce(
      n, kGrain, PoseInformation{}, std::span<PoseInformation>(partials_),
      [&](std::size_t begin, std::size_t end) {
        PoseInformation out;
        for (std::size_t i = begin; i < end; ++i) {
          const auto match = std::span<const ResidualRow>(matches.rows).subspan(i * rows, rows);
          if (!within(match, gate * gate)) continue;
          const double weight = matches.weight.empty() ? 1.0 : matches.weight[i];
          for (const ResidualRow& z : match)
            if (z.takes_part()) out.add(matches.body[i], Rt, z.J, z.r, weight * z.information);
        }
        return out;
      },
      [](PoseInformation& total, const PoseInformation& part) { total += part; });
}

void Registration::iterate(const HistorySelection& past, const StepContext& context) {
  const Pose prior = state_.pose();
  const auto rows = static_cast<std::size_t>(residual_->rows_per_match());
  Pose end = prior;
  for (int j = 0; j < rules_.max_iterations; ++j) {
    {
      const CpuTimer timer(result_.times.associate);
      fresh_.place(end);
      history_.place(end);
      const Vec3 viewpoint = frame_.viewpoint(end);
      fresh_.associate(context.map, *residual_, viewpoint, 0xffffffff);
      if (!history_.body.empty()) history_.associate(context.map, *residual_, viewpoint, past.max_stamp);
    }
    const CpuTimer timer(result_.times.solve);
    const PoseInformation fresh = sum(fresh_, end, std::numeric_limits<double>::infinity());
    const double gate = context.histories.gate(sigma_);
    const PoseInformation old = sum(history_, end, gate);
    result_.iterations = j + 1;
    result_.fresh_matches = static_cast<std::uint32_t>(count_matches(fresh_.rows, rows, fresh.accepted));
    result_.history_matches = static_cast<std::uint32_t>(count_matches(history_.rows, rows, old.accepted, gate * gate));
    if (static_cast<std::int64_t>(result_.fresh_matches) < rules_.min_matches) {
      return refuse(UpdateStatus::few_matches);
    }
    const double share = context.histories.weight(fresh.accepted, old.accepted);
    PoseInformation all = fresh;
    all.A = fresh.A + share * old.A;
    all.b = fresh.b + share * old.b;
    const Vec6 delta = step(prior, end, all);
    if (!delta.allFinite()) return refuse(UpdateStatus::non_finite);
    end = end.moved(delta);
    end.R = orthonormalised(end.R);
    if (delta.norm() < rules_.converged || j + 1 == rules_.max_iterations) {
      result_.status = status_of_last_step(settled(delta.norm(), rules_.converged));
      return accept(end, fresh);
    }
  }
}

void Registration::accept(const Pose& end, const PoseInformation& fresh) {
  judge_view(result_, accept(end, fresh, state_, P_), rules_.degenerate_sigma, plan_);
  result_.accepted = true;
}

void Registration::refuse(UpdateStatus status) {
  result_.status = status;
  result_.accepted = false;
  // Unseen space can become known only by entering the map.
  result_.insert = status == UpdateStatus::few_matches && trusted(state_.t);
}

const Update& Registration::update(const Window& window, const HistorySelection& past, const StepContext& context) {
  result_ = Update{};
  plan_ = window.plan;
  sigma_ = sigma();
  {
    const CpuTimer timer(result_.times.predict);
    trajectory_.clear(state_);
    state_ = propagate(window, trajectory_);
  }
  result_.prior = state_;
  load(window, past, context);
  if (context.map.size() == 0) {
    result_.status = UpdateStatus::initialising;
    begin_map();
  } else {
    iterate(past, context);
  }
  finish();
  return result_;
}

void Registration::finish() {
  const CpuTimer timer(result_.times.solve);
  trajectory_.correct(state_.pose());
  frame_.place(trajectory_);
  records_.assign(fresh_.body.size(), MatchRecord{});
  if (result_.accepted) {
    fresh_.place(state_.pose());
    fresh_.evaluate(*residual_, sigma_);
    fresh_.record(static_cast<std::size_t>(residual_->rows_per_match()), records_, result_.residual_rms);
    if (!residual_->surfaces_from_map()) result_.neighbours = &fresh_.neighbours;
  }
  result_.P = P_;
  hand_over(result_, frame_, records_, state_, {&state_, 1}, trajectory_);
}

}  // namespace aslio
