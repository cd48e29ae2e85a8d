// The calibration functions of the C interface.
#include <algorithm>
#include <span>
#include <vector>

#include "calibration/delay_solver.h"
#include "calibration/registration_solver.h"
#include "engine/bindings/c/call.h"
#include "engine/bindings/c/typodont_calibration.h"

using namespace typodont;
using namespace typodont::bindings;

namespace {

std::vector<dvec3> to_points(const double* p, std::size_t count) {
  require(p || count == 0, "NULL for the points");
  std::vector<dvec3> points;
  points.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    points.push_back(to_vec(p + 3 * i));
    require(is_finite(points.back()), "a point that is not finite");
  }
  return points;
}

calibration::Stream to_stream(const double* t, const double* p, std::size_t count) {
  require(t || count == 0, "NULL for the times");
  for (std::size_t i = 0; i < count; ++i) require(std::isfinite(t[i]), "a time that is not finite");
  return {std::vector<double>(t, t + count), to_points(p, count)};
}

}  // namespace

typodont_result typodont_register(const double* p_H, const double* p_D, size_t count, double known_sigma,
                                  typodont_registration* out, uint8_t* inlier) {
  return guarded([&] {
    require(out && sized(out->struct_size, sizeof *out), kBadSize);
    require(known_sigma >= 0 && std::isfinite(known_sigma), "known_sigma: expected m, 0 or more");
    calibration::RegistrationOptions options;
    options.known_sigma = known_sigma;
    const calibration::RegistrationResult result =
        calibration::register_points(to_points(p_H, count), to_points(p_D, count), options);
    out->trusted = result.trusted();
    put(result.X_DH, out->X_DH);
    out->fre_rms = result.fre_rms;
    out->sigma = result.sigma;
    std::copy(result.covariance.begin(), result.covariance.end(), out->covariance);
    out->predicted_tre = result.predicted_tre_rms;
    out->outliers = result.outliers.size();
    if (inlier) {
      std::fill_n(inlier, count, std::uint8_t{0});
      for (const std::size_t i : result.inliers) inlier[i] = 1;
    }
    if (!result.trusted()) {
      fail_with_copy(TYPODONT_OK, result.degeneracy.reason.empty() ? "the pairs agree on more than one motion"
                                                                   : result.degeneracy.reason.c_str());
    }
  });
}

typodont_result typodont_estimate_delay(const double* t_a, const double* p_a, size_t count_a, const double* t_b,
                                        const double* p_b, size_t count_b, double max_delay, typodont_delay* out) {
  return guarded([&] {
    require(out && sized(out->struct_size, sizeof *out), kBadSize);
    require(max_delay > 0 && std::isfinite(max_delay), "max_delay: expected s, above 0");
    calibration::DelayOptions options;
    options.max_delay = max_delay;
    const calibration::DelayResult result =
        calibration::estimate_delay(to_stream(t_a, p_a, count_a), to_stream(t_b, p_b, count_b), options);
    out->ambiguous = result.ambiguous;
    out->delay = result.delay;
    out->sigma = result.sigma;
    if (result.ambiguous) fail_with_copy(TYPODONT_OK, result.reason.c_str());
  });
}
