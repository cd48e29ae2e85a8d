#include "calibration/statistics.h"

#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>

namespace typodont::calibration {

namespace {

// Results beyond the range of double are infinite; numbers are not promoted to long double.
using Policy = boost::math::policies::policy<boost::math::policies::overflow_error<boost::math::policies::ignore_error>,
                                             boost::math::policies::promote_double<false>>;
using ChiSquared = boost::math::chi_squared_distribution<double, Policy>;
using FisherF = boost::math::fisher_f_distribution<double, Policy>;

}  // namespace

double chi_squared_cdf(double x, double dof) {
  return cdf(ChiSquared(dof), x);
}

double chi_squared_quantile(double p, double dof) {
  return quantile(ChiSquared(dof), p);
}

double f_quantile(double p, double d1, double d2) {
  return quantile(complement(FisherF(d1, d2), 1 - p));
}

dvec3 Noise::normal3(double sigma) {
  const double x = normal(sigma), y = normal(sigma), z = normal(sigma);
  return {x, y, z};
}

dvec3 Noise::in_box(const dvec3& low, const dvec3& high) {
  const double x = uniform(low.x, high.x), y = uniform(low.y, high.y), z = uniform(low.z, high.z);
  return {x, y, z};
}

dquat Noise::rotation() {
  const double w = normal(), x = normal(), y = normal(), z = normal();
  return glm::normalize(dquat(w, x, y, z));
}

}  // namespace typodont::calibration
