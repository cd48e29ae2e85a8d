// Gauss–Newton solver with numeric Jacobian, scaling, outlier rejection and covariance; finds combinations of unknowns
// that are not determined. Used only by .cpp files of this module.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "calibration/solver/eigen_math.h"

namespace typodont::calibration {

struct LeastSquares {
  Eigen::VectorXd x;
  Eigen::MatrixXd covariance;  // covariance of the unknowns x
  double sigma = 0;            // standard deviation of each component of the residuals
  int degrees_of_freedom = 0;
  std::vector<bool> used;
  std::vector<double> residuals;  // norm of the residual of each block (touch)
  // Combinations of the scaled unknowns that the data do not determine, one per column.
  Eigen::MatrixXd open_axes;
};

/// `residual(x, block, r)` writes `size` values. `scale`: plausible errors of the unknowns. A combination of unknowns
/// is determined if its standard deviation is below a third of its plausible error.
LeastSquares solve_least_squares(Eigen::VectorXd x, const Eigen::VectorXd& scale, std::size_t blocks, int size,
                                 const std::function<void(const Eigen::VectorXd&, std::size_t, double*)>& residual);

/// Copies noise, residuals, and the rms of the residuals that were used to the result of a calibration step.
template <class Result>
void store_residuals(Result& result, const LeastSquares& solved) {
  result.sigma = solved.sigma;
  result.residuals = solved.residuals;
  double sum = 0;
  for (std::size_t i = 0; i < solved.used.size(); ++i) {
    if (solved.used[i])
      sum += solved.residuals[i] * solved.residuals[i];
    else
      result.rejected.push_back(i);
  }
  result.rms = std::sqrt(sum / std::max<double>(1, static_cast<double>(solved.used.size() - result.rejected.size())));
}

}  // namespace typodont::calibration
