// Tests the ideal of a crown preparation on a tooth with a simple shape, and in the shipped exercise.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "engine/app/assets.h"
#include "engine/app/recording/resume.h"
#include "engine/app/task/crown_ideal.h"
#include "engine/app/task/task.h"
#include "engine/base/units.h"
#include "engine/base/voxels.h"

namespace typodont {
namespace {

using namespace literals;

constexpr CrownReduction kCrown{2.0_mm, 0.5_mm, 1.0_mm, 12 * kDegree, 1.0_mm, 0.3_mm};
constexpr int kSize = 107;
constexpr double kVoxel = 0.15_mm, kRadius = 4.0_mm, kTop = 8.0_mm;

/// Returns a cylinder on the z axis, from z = 0 to z = 8 mm, in a grid that is turned so that its axis is `axis`.
DenseCopy cylinder(const dvec3& axis) {
  DenseCopy copy;
  copy.frame = {dvec3(-6.0_mm), kVoxel};
  copy.field.size = glm::ivec3(kSize);
  copy.field.distance.resize(static_cast<std::size_t>(kSize) * kSize * kSize);
  copy.tissue.assign(copy.field.distance.size(), Tissue::kEnamel);
  for_each_voxel(glm::ivec3(kSize), [&](int x, int y, int z) {
    const dvec3 p = copy.frame.to_world(dvec3(x, y, z));
    const double height = glm::dot(p, axis), aside = glm::length(p - height * axis) - kRadius,
                 above = std::max(height - kTop, -height);
    const double d = std::min(std::max(aside, above), 0.0) + std::hypot(std::max(aside, 0.0), std::max(above, 0.0));
    copy.field.distance[copy.field.at(x, y, z)] = static_cast<float>(d / kVoxel);
  });
  return copy;
}

/// Returns the largest distance from the axis, along `u`, at which tissue remains at this height. 0 if there is none.
double radius_at(const DenseCopy& copy, const dvec3& axis, const dvec3& u, double height) {
  for (double r = kRadius + 1.0_mm; r > 0; r -= 0.005_mm)
    if (copy.field.sample(copy.frame.to_voxels(height * axis + r * u)) < 0) return r;
  return 0;
}

TEST(CrownIdeal, OfACylinderHasTheChamferTheWallsAndTheHeightThatAreStatedAlongEveryAxis) {
  for (const auto& [axis, u] :
       {std::pair(dvec3(0, 0, 1), dvec3(0.6, 0.8, 0)), std::pair(dvec3(1, 0, 0), dvec3(0, 1, 0)),
        std::pair(dvec3(0, 0.6, 0.8), dvec3(0, 0.8, -0.6))}) {
    DenseCopy copy = cylinder(axis);
    reduce_for_crown(kCrown, axis, copy);
    const auto radius = [&, &axis = axis, &u = u](double height) { return radius_at(copy, axis, u, height); };
    EXPECT_NEAR(radius(1.9_mm), kRadius, 0.04_mm) << "below the margin, nothing is removed";
    const double lean = std::tan(6 * kDegree);
    for (const double height : {3.2_mm, 4.0_mm, 5.0_mm, 6.0_mm})
      EXPECT_NEAR(radius(height), kRadius - 0.5_mm - (height - 2.0_mm) * lean, 0.04_mm) << height;
    // The chamfer is a part of a circle that touches the wall and the height of the margin.
    const double center = kRadius - 0.5_mm - 1.0_mm * lean + 1.0_mm / std::cos(6 * kDegree);
    for (const double height : {2.3_mm, 2.6_mm})
      EXPECT_NEAR(radius(height), center - std::sqrt(1.0e-6 - std::pow(3.0_mm - height, 2)), 0.04_mm) << height;
    double top = 9.0_mm;
    while (copy.field.sample(copy.frame.to_voxels(top * axis + 1.0_mm * u)) >= 0) top -= 0.005_mm;
    EXPECT_NEAR(top, kTop - 1.0_mm, 0.04_mm);
    // The edge between top and wall is rounded.
    const double wall = kRadius - 0.5_mm - 4.9_mm * lean;
    EXPECT_LT(radius(6.95_mm), wall - 0.05_mm);
  }
}

TEST(CrownIdeal, OfTheExerciseReducesTheOcclusalSurfaceEvenlyAndKeepsItsCusps) {
  const Scene scene = read_scene(assets_folder() / "scenes/crown-preparation.json");
  const haptics::TissueVolume start = load_tissue(scene);
  const TaskEvaluator judge(scene, start);
  const session::Preparation in = judge.preparation(start);
  const session::DenseField before = session::redistanced(in.before);
  std::vector<double> depths;  // m, below the old surface, of the new surface that faces the occlusal side
  double lowest = 1e9, highest = -1e9;
  const double h = in.frame.voxel;
  for_each_voxel(before.size, [&](int x, int y, int z) {
    const std::size_t i = before.at(x, y, z);
    if (std::abs(in.ideal.distance[i]) > 0.5f || in.before.distance[i] > -1.5f) return;
    const dvec3 p = in.frame.to_world(dvec3(x, y, z));
    if (p.z < 18.0_mm || glm::normalize(in.ideal.gradient(dvec3(x, y, z), 2)).z < 0.7) return;
    depths.push_back(-static_cast<double>(before.distance[i]) * h);
    lowest = std::min(lowest, p.z), highest = std::max(highest, p.z);
  });
  ASSERT_GT(depths.size(), 1000u);
  std::sort(depths.begin(), depths.end());
  const auto quantile = [&](double q) {
    return depths[static_cast<std::size_t>(q * static_cast<double>(depths.size() - 1))];
  };
  fmt::print(
      "occlusal reduction: {:.2f} mm (5 %), {:.2f} mm (median), {:.2f} mm (95 %); cusps {:.2f} mm above fossae\n",
      quantile(0.05) * 1e3, quantile(0.5) * 1e3, quantile(0.95) * 1e3, (highest - lowest) * 1e3);
  EXPECT_GT(quantile(0.05), 0.7_mm);  // at the rim, where the top meets the walls
  EXPECT_NEAR(quantile(0.5), 1.0_mm, 0.05_mm);
  EXPECT_LT(quantile(0.95), 1.3_mm);
  EXPECT_GT(highest - lowest, 1.5_mm);
}

}  // namespace
}  // namespace typodont
