#include "clustered_fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

namespace aslio::evaluation {

ClusteredFit::ClusteredFit(int parameters)
    : parameters_(parameters),
      prior_information_(Eigen::VectorXd::Zero(parameters)),
      prior_gradient_(Eigen::VectorXd::Zero(parameters)) {}

void ClusteredFit::hold(int index, double off, double sigma) {
  prior_information_[index] += 1.0 / (sigma * sigma);
  prior_gradient_[index] += off / (sigma * sigma);
}

ClusteredFit::Part& ClusteredFit::part(int cluster) {
  if (parts_.empty() || parts_.back().cluster != cluster) {
    parts_.push_back({cluster, Eigen::MatrixXd::Zero(parameters_, parameters_), Eigen::VectorXd::Zero(parameters_)});
  }
  return parts_.back();
}

void ClusteredFit::add(int cluster, const Eigen::MatrixXd& J, const Eigen::VectorXd& r, double information) {
  Part& p = part(cluster);
  p.H.noalias() += information * J.transpose() * J;
  p.g.noalias() += information * J.transpose() * r;
}

void ClusteredFit::add_normal(int cluster, const Eigen::MatrixXd& H, const Eigen::VectorXd& g) {
  Part& p = part(cluster);
  p.H += H;
  p.g += g;
}

Eigen::MatrixXd ClusteredFit::information() const {
  Eigen::MatrixXd H = prior_information_.asDiagonal();
  for (const Part& p : parts_) H += p.H;
  return H;
}

Eigen::VectorXd ClusteredFit::step() const {
  Eigen::VectorXd g = prior_gradient_;
  for (const Part& p : parts_) g += p.g;
  return -information().ldlt().solve(g);
}

Eigen::MatrixXd ClusteredFit::covariance() const {
  const Eigen::MatrixXd H = information();
  const Eigen::MatrixXd inverse = H.ldlt().solve(Eigen::MatrixXd::Identity(parameters_, parameters_));
  const auto n = static_cast<double>(parts_.size());
  if (parts_.size() < 2) return inverse;
  Eigen::MatrixXd scatter = Eigen::MatrixXd::Zero(parameters_, parameters_);
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(parameters_);
  std::vector<Eigen::VectorXd> moved;
  for (const Part& p : parts_) {
    moved.emplace_back((H - p.H).ldlt().solve(p.g));
    mean += moved.back() / n;
  }
  for (const Eigen::VectorXd& x : moved) scatter += (x - mean) * (x - mean).transpose();
  // Of few clusters the scatter is known badly, and differences in three directions are larger than it says
  // (Hotelling).
  const double few = (n - 1.0) / std::max(n - 5.0, 1.0);
  return few * (n - 1.0) / n * scatter + inverse * prior_information_.asDiagonal() * inverse;
}

double spread_of(std::vector<double> lengths, double least) {
  if (lengths.empty()) return least;
  const auto middle = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
  std::nth_element(lengths.begin(), middle, lengths.end());
  constexpr double kMedianOfThree = 1.5382;  // of the length of a vector of three unit normals
  return std::max(least, *middle / kMedianOfThree);
}

}  // namespace aslio::evaluation
