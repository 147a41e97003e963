#pragma once
/// Least squares of rows that belong to clusters, with a covariance that holds where the errors of a cluster are alike.

#include <Eigen/Core>
#include <vector>

namespace aslio::evaluation {

/// One Gauss-Newton step: rows z = r + J x with their information; priors. The covariance is that of a jackknife which
/// leaves out one cluster at a time, by one linear step each, and of the priors. eq. FRM-3
class ClusteredFit {
 public:
  explicit ClusteredFit(int parameters);

  /// Parameter `index` is `off` from what is known beforehand to `sigma`.
  void hold(int index, double off, double sigma);
  /// Rows of cluster `cluster`; clusters come one after the other.
  void add(int cluster, const Eigen::MatrixXd& J, const Eigen::VectorXd& r, double information);
  /// The same of normal equations that somebody else has made.
  void add_normal(int cluster, const Eigen::MatrixXd& H, const Eigen::VectorXd& g);

  int clusters() const { return static_cast<int>(parts_.size()); }
  /// -H^-1 g.
  Eigen::VectorXd step() const;
  Eigen::MatrixXd covariance() const;

 private:
  struct Part {
    int cluster;
    Eigen::MatrixXd H;
    Eigen::VectorXd g;
  };
  Part& part(int cluster);
  Eigen::MatrixXd information() const;

  int parameters_;
  Eigen::VectorXd prior_information_, prior_gradient_;
  std::vector<Part> parts_;
};

/// Weight of a residual of length `r` where the usual one is `scale` (Geman and McClure).
inline double robust_weight(double r, double scale) {
  const double x = r / (3.0 * scale);
  return 1.0 / ((1.0 + x * x) * (1.0 + x * x));
}

/// The standard deviation per axis of vectors of three, by the median of their lengths; at least `least`.
double spread_of(std::vector<double> lengths, double least);

}  // namespace aslio::evaluation
