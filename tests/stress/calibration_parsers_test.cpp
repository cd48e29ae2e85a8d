// Tests that registration accepts any numbers.
#include <gtest/gtest.h>

#include <cmath>

#include "calibration/registration_solver.h"
#include "calibration/statistics.h"

namespace typodont::calibration {
namespace {

TEST(CalibrationStress, RegistrationSurvivesAnyNumbers) {
  Noise random(2);
  for (int trial = 0; trial < 2000; ++trial) {
    const std::size_t count = 1 + random.index(12);
    std::vector<dvec3> h, d;
    for (std::size_t i = 0; i < count; ++i) {
      const auto wild = [&] {
        return random.normal() * std::pow(10.0, random.uniform(-30, 30)) * (random.index(5) ? 1 : 0);
      };
      h.emplace_back(wild(), wild(), wild()), d.emplace_back(wild(), wild(), wild());
      if (i > 0 && random.index(4) == 0) h.back() = h[random.index(i)];
      if (i > 0 && random.index(4) == 0) d.back() = h.back();
    }
    const RegistrationResult result = register_points(h, d);
    ASSERT_EQ(result.inliers.size() + result.outliers.size(), count);
    ASSERT_TRUE(is_finite(result.X_DH.p));
    ASSERT_NEAR(glm::length(result.X_DH.R), 1, 1e-9);
    for (const double c : result.covariance) ASSERT_TRUE(std::isfinite(c)) << trial;
  }
}

}  // namespace
}  // namespace typodont::calibration
