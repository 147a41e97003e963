#include "my_stage.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "aslio/plugin/entry.hpp"

namespace my_plugin {

using namespace aslio;

double Between::share(TimeNs t) const {
  return static_cast<double>(t - begin_t) / static_cast<double>(end_t - begin_t);
}

Pose Between::pose(TimeNs t) const {
  const double s = share(t);
  if (s == 1.0) return end;
  const Vec3 turn = log_so3(begin.R.transpose() * end.R);
  return {begin.R * exp_so3(s * turn), begin.p + s * (end.p - begin.p)};
}

Pose Between::moved(TimeNs t, const Eigen::VectorXd& xi) const {
  Between other = *this;
  other.end = end.moved(xi.head<6>());
  return other.pose(t);
}

void Between::jacobian(TimeNs t, Eigen::MatrixXd& out) const {
  const double s = share(t);
  const Vec3 turn = log_so3(begin.R.transpose() * end.R);
  out.setZero(6, 6);
  out.topLeftCorner<3, 3>() = s * right_jacobian_so3(s * turn) * right_jacobian_inverse_so3(turn);
  out.bottomRightCorner<3, 3>() = s * Mat3::Identity();
}

void MyStage::describe(config::Binder& b, Params& p) {
  b.integer("max_iterations", p.max_iterations, "", {.min = 1, .max = 1000}, "iterations at most");
  b.real("converged", p.converged, "", {.above = 0.0, .max = 1.0}, "length of the last step, rad and m alike");
  b.integer("min_matches", p.min_matches, "", {.min = 3, .max = 1e6}, "fewer accepted rows: the step is refused");
  b.real("sigma", p.sigma, "m", {.above = 0.0, .max = 10.0}, "standard deviation of a residual");
  b.real("sigma_rotation", p.sigma_rotation, "rad", {.above = 0.0, .max = 1.0}, "of the prediction over a window");
  b.real("sigma_position", p.sigma_position, "m", {.above = 0.0, .max = 10.0}, "of the prediction over a window");
  b.stage("residual", p.residual, "what a match measures");
}

MyStage::MyStage(const Params& params, const BuildContext& context)
    : params_(params), T_imu_lidar_(context.sensor.T_imu_lidar), residual_(params.residual.make(context)) {
  prior_information_.diagonal() << Vec3::Constant(1.0 / (params.sigma_rotation * params.sigma_rotation)),
      Vec3::Constant(1.0 / (params.sigma_position * params.sigma_position));
}

MapContent MyStage::map_content() const {
  return residual_->surfaces_from_map() ? MapContent::surfaces : MapContent::points;
}

void MyStage::reset(const InitialState& initial) {
  state_ = initial.state;
  result_ = Update{};
}

void MyStage::adopt(const InertialEstimate& better) { better.put(state_); }

NavState MyStage::predict(std::span<const ImuSample> imu) const {
  NavState out = state_;
  if (imu.empty()) return out;
  for (std::size_t i = 1; i < imu.size(); ++i) {
    const Vec3 rate = 0.5 * (imu[i - 1].gyro + imu[i].gyro) - state_.b_w;
    out.R = orthonormalised(out.R * exp_so3(to_seconds(imu[i].t - imu[i - 1].t) * rate));
  }
  out.t = imu.back().t;
  out.p += to_seconds(out.t - state_.t) * state_.v;
  return out;
}

/// Samples, and places the points in I at the end of the window, by the motion that is predicted.
void MyStage::load(const Window& window, SamplerChain& samplers) {
  raw_.assign(window.fresh.begin(), window.fresh.end());
  taps_.assign(raw_.size(), kAllTaps);
  SampleBatch batch{.raw = raw_, .body = {}, .taps = taps_};
  samplers.sample(Sampler::ActsOn::raw, batch);
  body_.clear();
  index_.clear();
  const Pose to_end = trajectory_.end.inverse();
  for (std::size_t i = 0; i < raw_.size(); ++i) {
    if (taps_[i] == 0) continue;
    const std::size_t n = body_.size();
    const Vec3 p_I = T_imu_lidar_.R * Vec3(raw_[i].x, raw_[i].y, raw_[i].z) + T_imu_lidar_.p;
    const Pose motion = to_end * trajectory_.pose(raw_[i].t);
    body_.push_back((motion.R * p_I + motion.p).cast<float>());
    index_.push_back(static_cast<std::uint32_t>(i));
    raw_[n] = raw_[i];
    taps_[n] = taps_[i];
  }
  raw_.resize(body_.size());
  taps_.resize(body_.size());
  batch = {.raw = raw_, .body = body_, .taps = taps_};
  samplers.sample(Sampler::ActsOn::body, batch);
  match_body_.clear();
  match_range_.clear();
  for (std::size_t i = 0; i < body_.size(); ++i) {
    if ((taps_[i] & mask(Tap::match)) == 0) continue;
    match_body_.push_back(body_[i].cast<double>());
    match_range_.push_back(std::hypot(raw_[i].x, raw_[i].y, raw_[i].z));
  }
}

void MyStage::associate(const Map& map, const Pose& end) {
  queries_.clear();
  for (const Vec3& p : match_body_) queries_.push_back(end.R * p + end.p);
  surfaces_.assign(queries_.size(), {});
  MapQuery query = residual_->query();
  query.viewpoint = end * T_imu_lidar_.p;
  if (residual_->surfaces_from_map()) {
    map.surfaces(queries_, query, surfaces_);
  } else {
    map.correspond(queries_, query, neighbours_);
    residual_->fit(queries_, neighbours_, surfaces_);
  }
}

MyStage::Normal MyStage::evaluate(const Pose& end) {
  queries_.clear();
  for (const Vec3& p : match_body_) queries_.push_back(end.R * p + end.p);
  const auto per_match = static_cast<std::size_t>(residual_->rows_per_match());
  rows_.resize(queries_.size() * per_match);
  residual_->evaluate(queries_, match_range_, surfaces_, params_.sigma, rows_);
  Normal normal;
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const ResidualRow& row = rows_[i];
    if (!row.takes_part()) continue;
    // p_W = R p + t with R <- R Exp(theta): d p_W / d theta = -R hat(p).
    Vec6 J;
    J << match_body_[i / per_match].cross(end.R.transpose() * row.J), row.J;
    normal.A += row.information * J * J.transpose();
    normal.b += row.information * row.r * J;
    normal.squared += row.r * row.r;
    ++normal.rows;
  }
  return normal;
}

void MyStage::solve(const Map& map) {
  Pose end = trajectory_.end;
  for (int iteration = 1; iteration <= params_.max_iterations; ++iteration) {
    associate(map, end);
    const Normal normal = evaluate(end);
    result_.iterations = iteration;
    result_.fresh_matches = normal.rows / static_cast<std::uint32_t>(residual_->rows_per_match());
    if (static_cast<std::int64_t>(normal.rows) < params_.min_matches) {
      // Unseen space can become known only by entering the map.
      result_.status = UpdateStatus::few_matches;
      return;
    }
    Vec6 off;  // from the prediction, which holds the directions that nothing was seen of
    off << log_so3(trajectory_.end.R.transpose() * end.R), end.p - trajectory_.end.p;
    const Mat6 A = normal.A + prior_information_;
    const Vec6 step = -A.ldlt().solve(normal.b + prior_information_ * off);
    if (!step.allFinite()) {
      result_.status = UpdateStatus::non_finite;
      result_.insert = false;
      return;
    }
    end = end.moved(step);
    end.R = orthonormalised(end.R);
    const bool small = step.norm() < params_.converged;
    if (small || iteration == params_.max_iterations) {
      // A last step ten times too long is noise of the association.
      result_.status = step.norm() < 10 * params_.converged ? UpdateStatus::ok : UpdateStatus::not_converged;
      return accept(end, normal);
    }
  }
}

void MyStage::accept(const Pose& end, const Normal& normal) {
  const double dt = to_seconds(trajectory_.end_t - trajectory_.begin_t);
  state_.v = (end.p - trajectory_.begin.p) / dt;
  state_.R = end.R;
  state_.p = end.p;
  trajectory_.end = end;
  result_.accepted = true;
  result_.residual_rms = std::sqrt(normal.squared / normal.rows);
  result_.P.topLeftCorner<6, 6>() = (normal.A + prior_information_).ldlt().solve(Mat6::Identity());
  Mat6 scaled = normal.A;
  constexpr double lever = 5.0;  // [m], at which rotation counts as position
  scaled.topRows<3>() /= lever;
  scaled.leftCols<3>() /= lever;
  const Eigen::SelfAdjointEigenSolver<Mat6> solver(scaled);
  for (std::size_t i = 0; i < 6; ++i) result_.spectrum[i] = solver.eigenvalues()[static_cast<Eigen::Index>(i)];
  result_.weakest = solver.eigenvectors().col(0);
}

namespace {

/// Of all rows of a match, of which a gate leaves out all or none.
MatchRecord record_of(std::span<const ResidualRow> rows) {
  MatchRecord out;
  double squares = 0;
  for (const ResidualRow& row : rows) {
    out.accepted = out.accepted || row.takes_part();
    out.matched = out.matched || row.measures();
    squares += row.r * row.r;
  }
  out.residual = static_cast<float>(rows.size() == 1 ? rows.front().r : std::sqrt(squares));
  return out;
}

}  // namespace

/// Places the points of all consumers at the posterior.
void MyStage::finish() {
  overlap_points_.clear();
  map_points_.clear();
  match_points_.clear();
  const Vec3 viewpoint = state_.pose() * T_imu_lidar_.p;
  for (std::size_t i = 0; i < body_.size(); ++i) {
    WorldPoint point{.p_W = state_.R * body_[i].cast<double>() + state_.p, .t = raw_[i].t};
    point.range = std::hypot(raw_[i].x, raw_[i].y, raw_[i].z);
    point.intensity = raw_[i].intensity;
    point.index = index_[i];
    point.line = raw_[i].line;
    point.view = PackedDirection((point.p_W - viewpoint).cast<float>());
    if ((taps_[i] & mask(Tap::overlap)) != 0) overlap_points_.push_back(point);
    if ((taps_[i] & mask(Tap::map)) != 0) map_points_.push_back(point);
    if ((taps_[i] & mask(Tap::match)) != 0) match_points_.push_back(point);
  }
  records_.assign(match_points_.size(), {});
  if (result_.accepted) {
    evaluate(state_.pose());
    const auto per_match = static_cast<std::size_t>(residual_->rows_per_match());
    for (std::size_t i = 0; i < records_.size(); ++i) {
      records_[i] = record_of(std::span<const ResidualRow>(rows_).subspan(i * per_match, per_match));
    }
    if (!residual_->surfaces_from_map()) result_.neighbours = &neighbours_;
  }
  result_.state = state_;
  result_.states = {&state_, 1};
  result_.trajectory = &trajectory_;
  result_.overlap_points = overlap_points_;
  result_.map_points = map_points_;
  result_.match_points = match_points_;
  result_.matches = records_;
}

const Update& MyStage::update(const Window& window, const HistorySelection& past, const StepContext& context) {
  (void)past;
  result_ = Update{};
  trajectory_.begin_t = state_.t;
  trajectory_.begin = state_.pose();
  state_ = predict(window.imu);
  state_.t = window.plan.end;  // also of a window without IMU data
  trajectory_.end_t = state_.t;
  trajectory_.end = state_.pose();
  result_.prior = state_;
  load(window, context.samplers);
  if (context.map.size() > 0) solve(context.map);  // else there is nothing to match: UpdateStatus::initialising
  finish();
  return result_;
}

namespace {

void register_types(plugin::Catalog& catalog) {
  plugin::Registry<Estimator>(catalog).add<MyStage>(
      "my_stage", "Registration by Gauss-Newton steps from a prediction of gyro and velocity.");
}

}  // namespace

}  // namespace my_plugin

ASLIO_PLUGIN(my_plugin::register_types)
