// Tests registration of a surface to a distance field that is known exactly.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "calibration/surface_solver.h"
#include "engine/base/error.h"
#include "engine/base/units.h"

namespace typodont::calibration {
namespace {

/// A box with faces at ±8, ±5 and ±4 mm; its field is exact near the faces and undefined farther away.
const dvec3 kHalf(8e-3, 5e-3, 4e-3);
FieldSample box_field(const dvec3& p) {
  const dvec3 out = glm::abs(p) - kHalf;
  const int axis = out.x > out.y && out.x > out.z ? 0 : out.y > out.z ? 1 : 2;
  FieldSample s{std::abs(out[axis]) < 3e-3, out[axis], dvec3(0)};
  s.gradient[axis] = p[axis] < 0 ? -1 : 1;
  return s;
}

/// Returns points on all faces except the lowest, in frame S, at a distance of `offset` (m) outside.
std::vector<SurfacePoint> box_points(const Pose& X_DS, double offset, double noise, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(-0.9, 0.9);
  std::normal_distribution<double> error(0, noise);
  std::vector<SurfacePoint> points;
  const Pose X_SD = inverse(X_DS);
  for (int i = 0; i < 3000; ++i) {
    const int face = i % 5, axis = face / 2;
    const double side = face % 2 == 0 ? 1 : -1;
    dvec3 p = dvec3(place(random), place(random), place(random)) * kHalf, n(0);
    p[axis] = side * (kHalf[axis] + offset + (noise > 0 ? error(random) : 0));
    n[axis] = side;
    points.push_back({X_SD * p, X_SD.rotate(n)});
  }
  return points;
}

const Pose kTruth{dvec3(0.03, -0.02, 0.01), glm::angleAxis(1.2, glm::normalize(dvec3(1, -2, 0.5)))};
const Pose kStart = Pose{dvec3(0.4e-3, -0.5e-3, 0.3e-3), glm::angleAxis(0.05, glm::normalize(dvec3(1, 1, 1)))} * kTruth;
SurfaceOptions options() {
  SurfaceOptions o;
  o.point_area = 0.1e-6;
  return o;
}

TEST(SurfaceRegistration, WithoutNoiseThePoseIsExact) {
  const SurfaceRegistration r = register_surface(box_points(kTruth, 0, 0, 1), box_field, kStart, options());
  EXPECT_EQ(r.distrust, "");
  EXPECT_TRUE(r.converged);
  EXPECT_LT(displacement_bound(r.X_DS, kTruth, 0.05), 1e-6);
  EXPECT_LT(r.most_of, 1e-6);
}

TEST(SurfaceRegistration, AConstantDistanceBetweenTheSurfacesIsFoundAndDoesNotMoveThePose) {
  const SurfaceRegistration r = register_surface(box_points(kTruth, 0.1e-3, 0, 1), box_field, kStart, options());
  EXPECT_EQ(r.distrust, "");
  EXPECT_NEAR(r.offset, 0.1e-3, 2e-6);
  EXPECT_LT(displacement_bound(r.X_DS, kTruth, 0.05), 5e-6);
}

TEST(SurfaceRegistration, AQuarterOfThePointsOnAnotherSurfaceDoesNotMoveThePose) {
  std::vector<SurfacePoint> points = box_points(kTruth, 0, 0.01e-3, 2);
  for (std::size_t i = 0; i < points.size(); i += 4) points[i].p_S += 0.8e-3 * points[i].n_S;  // as gingiva
  const SurfaceRegistration r = register_surface(points, box_field, kStart, options());
  EXPECT_EQ(r.distrust, "");
  EXPECT_NEAR(r.agreement, 0.75, 0.03);
  EXPECT_LT(displacement_bound(r.X_DS, kTruth, 0.0), 20e-6);
}

TEST(SurfaceRegistration, TheCovariancePredictsTheErrorOverSeeds) {
  constexpr unsigned kSeeds = 60;
  double squares = 0, predicted = 0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    const auto points = box_points(kTruth, 0, 0.05e-3, seed);
    const SurfaceRegistration r = register_surface(points, box_field, kStart, options());
    ASSERT_EQ(r.distrust, "") << seed;
    double mean = 0;
    for (const SurfacePoint& p : points) {
      const dvec3 error = r.X_DS * p.p_S - kTruth * p.p_S;
      mean += glm::dot(error, error) / static_cast<double>(points.size());
    }
    squares += mean / kSeeds;
    predicted += r.predicted_error * r.predicted_error / kSeeds;
  }
  EXPECT_NEAR(std::sqrt(squares / predicted), 1, 0.2);
}

TEST(SurfaceRegistration, APlaneDoesNotDetermineThePose) {
  std::vector<SurfacePoint> points = box_points(kTruth, 0, 0.01e-3, 3);
  std::erase_if(points, [&](const SurfacePoint& p) { return kTruth.rotate(p.n_S).x < 0.5; });
  EXPECT_EQ(register_surface(points, box_field, kStart, options()).distrust, "the surface does not determine the pose");
}

TEST(SurfaceRegistration, TooLittleAreaAndAStartTooFarAwayAreNotTrusted) {
  const auto points = box_points(kTruth, 0, 0, 4);
  SurfaceOptions small = options();
  small.point_area = 1e-9;
  EXPECT_NE(register_surface(points, box_field, kStart, small).distrust.find("expected at least 30 mm²"),
            std::string::npos);
  const Pose far = Pose{dvec3(0, 0.02, 0), dquat(1, 0, 0, 0)} * kTruth;
  EXPECT_NE(register_surface(points, box_field, far, options()).distrust, "");
  EXPECT_THROW(register_surface(std::span(points).first(99), box_field, kStart, options()), Error);
}

}  // namespace
}  // namespace typodont::calibration
