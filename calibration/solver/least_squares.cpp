#include "calibration/solver/least_squares.h"

namespace typodont::calibration {

LeastSquares solve_least_squares(Eigen::VectorXd x, const Eigen::VectorXd& scale, std::size_t blocks, int size,
                                 const std::function<void(const Eigen::VectorXd&, std::size_t, double*)>& residual) {
  LeastSquares result;
  result.used.assign(blocks, true);
  result.residuals.assign(blocks, 0);
  const Eigen::Index n = x.size();
  double sigma = 2e-4;
  for (int round = 0; round < 80; ++round) {
    Eigen::MatrixXd JJ = Eigen::MatrixXd::Zero(n, n);
    Eigen::VectorXd Jr = Eigen::VectorXd::Zero(n);
    Eigen::VectorXd r(size), plus(size), minus(size);
    Eigen::MatrixXd J(size, n);
    int rows = 0;
    double squares = 0;
    for (std::size_t b = 0; b < blocks; ++b) {
      residual(x, b, r.data());
      result.residuals[b] = r.norm();
      if (!result.used[b]) continue;
      for (Eigen::Index p = 0; p < n; ++p) {
        const double h = 1e-3 * scale[p];
        Eigen::VectorXd moved = x;
        moved[p] += h, residual(moved, b, plus.data());
        moved[p] -= 2 * h, residual(moved, b, minus.data());
        J.col(p) = (plus - minus) * (scale[p] / (2 * h));
      }
      JJ += J.transpose().lazyProduct(J), Jr += J.transpose() * r;
      squares += r.squaredNorm(), rows += size;
    }
    const auto eigen = eigen_of(JJ);
    Eigen::Index open = 0;
    while (open < n && sigma > 0.33 * std::sqrt(std::max(0.0, eigen.eigenvalues()[open]))) ++open;
    const Eigen::MatrixXd axes = eigen.eigenvectors().rightCols(n - open);
    const Eigen::VectorXd information = eigen.eigenvalues().tail(n - open);
    result.open_axes = eigen.eigenvectors().leftCols(open);
    const Eigen::VectorXd step = -axes * (axes.transpose() * Jr).cwiseQuotient(information);
    const Eigen::MatrixXd scaled = scale.asDiagonal() * axes;
    result.covariance = (scaled * information.cwiseInverse().asDiagonal()).lazyProduct(scaled.transpose());
    x += scale.cwiseProduct(step);
    result.degrees_of_freedom = rows - static_cast<int>(n - open);
    const double previous = sigma;
    if (result.degrees_of_freedom > 0) sigma = std::max(1e-13, std::sqrt(squares / result.degrees_of_freedom));
    if (round > 2 && step.norm() < 1e-8 && std::abs(sigma - previous) <= 1e-5 * sigma + 1e-13) {
      // After convergence, excludes outliers (detected by the median) and continues.
      const double limit = std::max(1e-9, 5.5 * sigma_of_lengths(result.residuals, size));
      bool changed = false;
      for (std::size_t b = 0; b < blocks; ++b) {
        const bool keep = result.residuals[b] <= limit;
        changed = changed || keep != result.used[b];
        result.used[b] = keep;
      }
      if (!changed) break;
    }
  }
  result.x = x;
  result.sigma = sigma;
  result.covariance *= sigma * sigma;
  return result;
}

}  // namespace typodont::calibration
