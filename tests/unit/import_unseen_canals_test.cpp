// Tests of the estimate of the pulp in canals that a scan does not show, on teeth whose canals are known.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "engine/base/units.h"
#include "engine/base/voxels.h"
#include "haptics/import/unseen_canals.h"

namespace typodont::haptics::importing {
namespace {

constexpr double kVoxel = 0.2;   // mm
constexpr double kNarrow = 0.3;  // mm, diameter of the canals that are not seen

// Returns the tissue of a function of the position in mm, in a box of 8 x 8 x 16 mm. Air is outside the tissue.
DenseTissue tooth(const std::function<Tissue(const dvec3&)>& tissue_at) {
  DenseTissue t;
  t.frame = {dvec3(0), kVoxel * kMillimetre};
  t.size = glm::ivec3(40, 40, 80);
  for_each_voxel(t.size, [&](int x, int y, int z) {
    const Tissue tissue = tissue_at(kVoxel * dvec3(x, y, z));
    t.tissue.push_back(tissue);
    t.distance.push_back(tissue == Tissue::kAir ? 1e-3F : -1e-3F);
  });
  return t;
}

double radius(const dvec3& p, double x) {
  return std::hypot(p.x - x, p.y - 4);
}

double unseen(const DenseTissue& t) {
  return unseen_canal_volume(t, kNarrow * kMillimetre) / kCubicMillimetre;
}

// Crown above z = 10 with enamel around it; a root of the radius 1.5 from z = 2 to 10; pulp above z = `lowest_pulp`.
Tissue one_root(const dvec3& p, double lowest_pulp) {
  if (p.z > 10) {
    const double r = radius(p, 4);
    return r > 3 || p.z > 14 ? Tissue::kAir : r > 2 ? Tissue::kEnamel : r < 0.6 ? Tissue::kPulp : Tissue::kDentin;
  }
  if (p.z < 2 || radius(p, 4) > 1.5) return Tissue::kAir;
  return radius(p, 4) < 0.4 && p.z > lowest_pulp ? Tissue::kPulp : Tissue::kDentin;
}

constexpr double kCrossSection = M_PI / 4 * kNarrow * kNarrow;

TEST(UnseenCanals, ARootWithoutPulpCanContainACanalAlongItsWholeLengthBelowTheLastPulp) {
  EXPECT_NEAR(unseen(tooth([](const dvec3& p) { return one_root(p, 6); })), kCrossSection * 4, kCrossSection * kVoxel);
}

TEST(UnseenCanals, AToothWhoseCanalReachesTheEndOfItsRootHidesNone) {
  EXPECT_EQ(unseen(tooth([](const dvec3& p) { return one_root(p, 1); })), 0);
}

TEST(UnseenCanals, EachOfTwoRootsCountsForItself) {
  const DenseTissue t = tooth([](const dvec3& p) {
    if (p.z > 10) return one_root(p, 6);
    const double r = std::min(radius(p, 2.3), radius(p, 5.7));
    if (p.z < 2 || r > 1.2) return Tissue::kAir;
    return p.x < 4 && r < 0.4 ? Tissue::kPulp : Tissue::kDentin;  // only the first root shows its canal
  });
  EXPECT_NEAR(unseen(t), kCrossSection * 8, 2 * kCrossSection * kVoxel);
}

TEST(UnseenCanals, ATipThatIsTooNarrowForTheCanalHidesNone) {
  const DenseTissue t = tooth([](const dvec3& p) {
    if (p.z > 6) return one_root(p, 1);
    return p.z > 2 && std::max(std::abs(p.x - 4), std::abs(p.y - 4)) < 0.1 ? Tissue::kDentin : Tissue::kAir;
  });
  EXPECT_EQ(unseen(t), 0);
}

TEST(UnseenCanals, ThePositionOfTheToothDoesNotMatter) {
  const DenseTissue upright = tooth([](const dvec3& p) { return one_root(p, 6); });
  DenseTissue lying = upright;
  lying.size = glm::ivec3(upright.size.z, upright.size.x, upright.size.y);
  for_each_voxel(upright.size, [&](int x, int y, int z) {
    lying.tissue[lying.at(z, x, y)] = upright.tissue[upright.at(x, y, z)];
    lying.distance[lying.at(z, x, y)] = upright.distance[upright.at(x, y, z)];
  });
  EXPECT_NEAR(unseen(lying), unseen(upright), 1e-12);
}

}  // namespace
}  // namespace typodont::haptics::importing
