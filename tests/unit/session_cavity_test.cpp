// Tests the measurement of cavities whose depth, taper, widths and volumes are known from formulas.
#include <gtest/gtest.h>

#include "engine/base/units.h"
#include "engine/base/voxels.h"
#include "engine/session/cavity.h"
#include "tests/support/cavity_fixture.h"

namespace typodont::session {
namespace {

using namespace test;

constexpr double kMm3 = 1e-9;
constexpr double kUm = 1e-6;
constexpr double kDegree = kPi / 180;

template <class Removed>
CavityMeasures measure_hole(Removed removed) {
  Preparation in = a_block();
  in.after = without(removed);
  return measure_cavity(in);
}

TEST(Cavity, WithAFloorOfUnevenPassesUnderASlopeHasTheMeanDepthOfAllPasses) {
  // One half of the floor is flat; the other half consists of passes that differ in depth by 0.02 mm. The old surface
  // has a slope of 0.4. So the depth of the flat half alone differs from the mean depth: it is 0.3 mm less.
  const glm::dvec2 half(1.5e-3, 1e-3);
  Preparation in = a_block();
  const double cosine = std::cos(std::atan(0.4));
  const auto sloped = [&](const dvec3& p) { return cosine * (p.z - kTop + 0.8e-3 - 0.4 * (p.x - kMiddle.x)); };
  const auto cut_off = [&](DenseField field) {
    for_each_voxel(field.size, [&](int x, int y, int z) {
      float& d = field.distance[field.at(x, y, z)];
      d = std::max(d, static_cast<float>(sloped(in.frame.to_world(dvec3(x, y, z))) / in.frame.voxel));
    });
    return field;
  };
  in.before = cut_off(in.before);
  in.after = cut_off(without([&](const dvec3& p) {
    double removed = tapered_box(half, 2.3e-3, 0)(p);
    for (const double x : {0.25e-3, 0.75e-3, 1.25e-3})
      removed = std::min(removed, tapered_box({0.125e-3, half.y}, 2.32e-3, 0, kMiddle + dvec3(x, 0, 0))(p));
    return removed;
  }));
  EXPECT_NEAR(measure_cavity(in).floor_depth.value(), 1.5e-3 + 0.005e-3, 0.02e-3);
}

TEST(Cavity, OfATiltedFloorIsFlatAndTiltedAndADomedOneIsNot) {
  const double tilt = 10 * kDegree;
  const auto tilted = measure_hole([&](const dvec3& p) {
    const double floor = (p.z - (kTop - 1.5e-3)) * std::cos(tilt) - (p.x - kMiddle.x) * std::sin(tilt);
    return std::max({std::abs(p.x - kMiddle.x) - 1.5e-3, std::abs(p.y - kMiddle.y) - 1e-3, -floor});
  });
  EXPECT_LT(tilted.floor_flatness.value(), 3 * kUm);
  EXPECT_NEAR(tilted.floor_tilt.value(), tilt, 0.2 * kDegree);
  // The floor is cut with a ball of 3 mm radius. The rms distance of such a cap from its mean plane is sagitta/√12.
  // Without its edge it is slightly less.
  const double radius = 3e-3, half = 1.2e-3, sag = radius - std::sqrt(radius * radius - half * half);
  const auto domed = measure_hole([&](const dvec3& p) {
    return std::max(std::hypot(p.x - kMiddle.x, p.y - kMiddle.y) - half,
                    ball(kMiddle + dvec3(0, 0, 1.5e-3), radius)(p));
  });
  EXPECT_NEAR(domed.floor_flatness.value(), sag / std::sqrt(12.0), 14 * kUm);
}

TEST(Cavity, IsthmusIsTheNeckOfADumbbell) {
  const CavityMeasures m = measure_hole([](const dvec3& p) {
    const double neck = tapered_box({2e-3, 0.55e-3}, 1.5e-3, 0)(p);
    const double a = tapered_box({0.7e-3, 1.4e-3}, 1.5e-3, 0, kMiddle + dvec3(1.6e-3, 0, 0))(p);
    const double b = tapered_box({0.7e-3, 1.4e-3}, 1.5e-3, 0, kMiddle - dvec3(1.6e-3, 0, 0))(p);
    return std::min({neck, a, b});
  });
  EXPECT_NEAR(m.isthmus.value(), 1.1e-3, 10 * kUm);
}

TEST(Cavity, OverAndUnderCutAreDistinguishedWithDepthAndPosition) {
  Preparation in = a_block();
  in.ideal = without(tapered_box({1.5e-3, 1e-3}, 1.5e-3, 0));
  // The cavity is 0.3 mm too deep in one half, and a ledge of 0.4 mm remains along a wall of the other half.
  in.after = without([](const dvec3& p) {
    const double deep = std::max(tapered_box({1.5e-3, 1e-3}, 1.8e-3, 0)(p), p.x - kMiddle.x);
    const double rest = std::max(tapered_box({1.5e-3, 1e-3}, 1.5e-3, 0)(p), p.x - kMiddle.x - 1.1e-3);
    return std::min(deep, rest);
  });
  const CavityMeasures m = measure_cavity(in);
  EXPECT_NEAR(m.over_volume, 1.5 * 2 * 0.3 * kMm3, 0.02 * kMm3);
  EXPECT_NEAR(m.under_volume, 0.4 * 2 * 1.5 * kMm3, 0.03 * kMm3);
  EXPECT_NEAR(m.over.depth, 0.3e-3, 10 * kUm);
  EXPECT_NEAR(m.over.p_W.z, kTop - 1.8e-3, 0.1e-3);
  EXPECT_LT(m.over.p_W.x, kMiddle.x);
  EXPECT_NEAR(m.under.depth, 0.4e-3, 20 * kUm);
  EXPECT_GT(m.under.p_W.x, kMiddle.x + 1e-3);
  EXPECT_NEAR(m.wanted, 3 * 2 * 1.5 * kMm3, 0.05 * kMm3);
  EXPECT_NEAR(m.done, (3 * 2 * 1.5 - 0.4 * 2 * 1.5) * kMm3, 0.05 * kMm3);
}

TEST(Cavity, AFillingIsMeasuredAgainstTheIdealLikeACut) {
  Preparation in = a_block();
  in.ideal = in.before;
  in.before = without(tapered_box({1e-3, 1e-3}, 1.5e-3, 0));  // the work begins with a cavity …
  in.after = sampled(kBlock, [](const dvec3& p) {             // … filled, but for 0.2 mm at its top
    return std::max(block(p), -tapered_box({1e-3, 1e-3}, 0.2e-3, 0)(p));
  });
  const CavityMeasures m = measure_cavity(in);
  EXPECT_NEAR(m.wanted, 2 * 2 * 1.5 * kMm3, 0.03 * kMm3);
  EXPECT_NEAR(m.done, 2 * 2 * 1.3 * kMm3, 0.03 * kMm3);
  EXPECT_NEAR(m.over_volume, 2 * 2 * 0.2 * kMm3, 0.02 * kMm3);
  EXPECT_NEAR(m.over.depth, 0.2e-3, 10 * kUm);
  EXPECT_EQ(m.under_volume, 0);
}

TEST(Cavity, APoreInAFillingCountsInItsVolumeAndNotInItsSurface) {
  Preparation in = a_block();
  in.ideal = in.before;
  in.before = without(tapered_box({1e-3, 1e-3}, 1.5e-3, 0));
  // a pore 0.8 mm deep, and a channel from it to the top with the half width `mouth`
  const auto measure = [&](double mouth) {
    const dvec3 middle = kMiddle - dvec3(0, 0, 1e-3);
    const auto pore = ball(middle, 0.2e-3);
    in.after = without([&](const dvec3& p) {
      return std::min(pore(p), std::max(std::hypot(p.x - middle.x, p.y - middle.y) - mouth, middle.z - p.z));
    });
    return measure_cavity(in);
  };
  const CavityMeasures closed = measure(-1e-3), open = measure(0.1e-3);
  EXPECT_NEAR(closed.over_volume, 4 * kPi / 3 * std::pow(0.2, 3) * kMm3, 0.003 * kMm3);
  EXPECT_EQ(closed.over.depth, 0);
  EXPECT_LT(closed.contour.value_or(0), 1 * kUm);
  EXPECT_GT(open.over.depth, 1.1e-3);
  EXPECT_GT(open.contour.value(), 100 * kUm);
}

TEST(Cavity, TheRoughnessOfAMarginIsTheRmsOfItsWaves) {
  const auto wavy = [](double amplitude) {
    return measure_hole([=](const dvec3& p) {
             const double angle = std::atan2(p.y - kMiddle.y, p.x - kMiddle.x);
             const double r = 1.5e-3 + amplitude * std::cos(24 * angle);  // waves of 0.4 mm
             return std::max(std::hypot(p.x - kMiddle.x, p.y - kMiddle.y) - r, kTop - 1.5e-3 - p.z);
           })
        .margin_roughness.value();
  };
  const double smooth = wavy(0);
  EXPECT_LT(smooth, 25 * kUm);  // a circle of 1.5 mm against itself smoothed over 0.25 mm: σ²/2r
  double last = smooth;
  for (const double amplitude : {40 * kUm, 80 * kUm, 120 * kUm}) {
    const double rough = wavy(amplitude);
    EXPECT_GT(rough, last);
    EXPECT_NEAR(rough, std::hypot(smooth, amplitude / std::sqrt(2.0)), 0.25 * amplitude) << amplitude;
    last = rough;
  }
}

TEST(Cavity, DistanceToThePulpIsThatOfTheNearestPointAndZeroOnceExposed) {
  Preparation in = a_block();
  const auto pulp = ball(kMiddle - dvec3(0, 0, 2.4e-3), 0.5e-3);
  for_each_voxel(kBlock, [&](int x, int y, int z) {
    if (pulp(kVoxel * dvec3(x, y, z)) < 0) in.tissue[in.before.at(x, y, z)] = Tissue::kPulp;
  });
  in.after = without(tapered_hole(0.8e-3, 1.4e-3, 0));
  CavityMeasures m = measure_cavity(in);
  EXPECT_NEAR(m.pulp_distance.value(), 0.5e-3, 0.06e-3);
  EXPECT_EQ(m.pulp_exposed.value(), 0);
  in.after = without(tapered_hole(0.8e-3, 2.3e-3, 0));
  m = measure_cavity(in);
  EXPECT_LT(m.pulp_distance.value(), 0.06e-3);
  // The plane is 0.1 mm above the middle of a ball of 0.5 mm radius. They have a disc in common.
  EXPECT_NEAR(m.pulp_exposed.value(), kPi * (0.25 - 0.01) * 1e-6, 0.08e-6);
}

TEST(Cavity, WallThicknessIsTheTissueBehindTheWall) {
  Preparation in = a_block();
  // The block ends at x = 6 mm. The edge of the hole is 0.4 mm away from this end.
  const auto ending = [](const dvec3& p) { return std::max(block(p), p.x - 6e-3); };
  in.before = sampled(kBlock, ending);
  in.after = sampled(kBlock, [&](const dvec3& p) {
    return std::max(ending(p), -tapered_box({1.6e-3, 1e-3}, 1.5e-3, 0)(p));
  });
  EXPECT_NEAR(measure_cavity(in).wall_thickness.value(), 0.4e-3, 10 * kUm);
}

TEST(Cavity, ProtectedTissueIsCountedSeparately) {
  Preparation in = a_block();
  in.keep.assign(in.before.distance.size(), false);
  for_each_voxel(kBlock, [&](int x, int y, int z) { in.keep[in.before.at(x, y, z)] = x >= 50; });
  in.after = without(tapered_box({0.95e-3, 1e-3}, 1.5e-3, 0));
  EXPECT_NEAR(measure_cavity(in).kept_removed.value(), 0, 1e-3 * kMm3);
  in.after = without(tapered_box({1.95e-3, 1e-3}, 1.5e-3, 0));
  EXPECT_NEAR(measure_cavity(in).kept_removed.value(), 1 * 2 * 1.5 * kMm3, 0.02 * kMm3);
}

TEST(Cavity, MeasuresTurnWithTheAxis) {
  // The horizontal stump for a crown: its axis is along x, its walls lean by 6°, and one millimetre is removed all
  // around.
  Preparation in = a_block();
  const dvec3 middle(4e-3, 4e-3, 2e-3);
  const auto cylinder = [&](const dvec3& p) {
    return std::max(std::hypot(p.y - middle.y, p.z - middle.z) - 1.8e-3, std::abs(p.x - middle.x) - 3.5e-3);
  };
  in.axis_W = {1, 0, 0};
  in.before = sampled(kBlock, cylinder);
  in.after = sampled(kBlock, [&](const dvec3& p) {
    const double up = p.x - 3e-3;
    const double stump =
        (std::hypot(p.y - middle.y, p.z - middle.z) - 1e-3 + up * std::tan(6 * kDegree)) * std::cos(6 * kDegree);
    const double cut = std::max({-up, -stump});  // beside the stump, above the shoulder …
    const double top = -(p.x - 6e-3);            // … and off its top
    return std::max(cylinder(p), -std::min(cut, top));
  });
  const CavityMeasures m = measure_cavity(in);
  EXPECT_NEAR(m.taper.value() / kDegree, 12, 0.5);
  EXPECT_NEAR(m.wall_depth.value(), 0.94e-3, 0.05e-3);  // 0.8 mm at the shoulder, 1.1 mm at the top
  EXPECT_GT(m.floor_depth.value(), 1.5e-3);
}

}  // namespace
}  // namespace typodont::session
