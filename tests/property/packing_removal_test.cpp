// Tests of removal from packings (S2, eq. 2 to 6), compared with exact volumes, and of tools that consist of spheres.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>
#include <random>
#include <span>
#include <vector>

#include "engine/base/error.h"
#include "engine/base/nearest.h"
#include "engine/base/units.h"
#include "haptics/contact/packing/sphere_tissue.h"
#include "haptics/contact/packing/surface_estimate.h"
#include "haptics/contact/packing/tool_spheres.h"
#include "haptics/import/mesh_solid.h"
#include "haptics/packing.h"
#include "tests/support/every_sphere.h"
#include "tests/support/sphere_cut.h"

namespace typodont::haptics::packing {
namespace {

using namespace literals;

SpherePacking one_sphere(double r) {
  SpherePacking p;
  p.center = {dvec3(0)}, p.radius = {r}, p.tissue = {Tissue::kDentin};
  p.solid_volume[static_cast<std::size_t>(Tissue::kDentin)] = 4.0 / 3 * kPi * r * r * r;
  return p;
}
constexpr double kBall = 5.0_mm;
/// Returns a packing of a ball of dentin with a core of pulp.
SpherePacking ball(std::size_t spheres) {
  const DenseTissue tissue = read_solids(Json::parse(R"({"voxel_mm": 0.125, "solids": [
      {"tissue": "dentin", "solid": {"sphere": {"radius_mm": 5}}},
      {"tissue": "pulp", "solid": {"sphere": {"radius_mm": 2}}}]})",
                                                     "t"));
  PackOptions options;
  options.spheres = spheres;
  return pack_spheres(tissue, options);
}

TEST(Removal, ThePublishedFormulaRemoves9967PercentTooMuchAndTheCorrectedOneTheExactVolume) {
  // A sphere of radius 0.5 below a plane (a tool without curvature). They overlap by 0.01.
  const double plane = 1e5, cap = kPi * 0.01 * 0.01 * (3 * 0.5 - 0.01) / 3;
  for (const Removal removal : {Removal::kAsPrinted, Removal::kMended}) {
    SphereTissue tissue(one_sphere(0.5), removal);
    std::array<Place, 4> changed;
    Removed removed;
    const dvec3 at(0, 0, plane + 0.5 - 0.01);
    ASSERT_EQ(cut_with_ball(tissue, at, at, plane, changed, {}, removed), 1u);
    if (removal == Removal::kAsPrinted) {
      EXPECT_NEAR(total(removed.volume) / cap, 99.67, 0.01);
    } else {
      EXPECT_NEAR(total(removed.volume) / cap, 1, 1e-3);
    }
    EXPECT_NEAR(tissue.tree().radius(0), 0.495, 1e-9);     // eq. 6: the radius decreases by half of the overlap …
    EXPECT_NEAR(tissue.tree().center(0).z, -0.005, 1e-9);  // … and the centre moves away by the other half
  }
}

TEST(Removal, AfterACutNoSphereOverlapsTheToolAndEachIsInsideItsFormerSelf) {
  std::mt19937_64 random(1);
  const SpherePacking p = ball(4000);
  for (const Removal removal : {Removal::kMended, Removal::kAsPrinted}) {
    SphereTissue tissue(p, removal);
    std::vector<Place> changed(4000);
    std::uniform_real_distribution<double> u(-5.0_mm, 5.0_mm);
    for (int i = 0; i < 200; ++i) {
      const double x = u(random), y = u(random), z = u(random);
      const dvec3 a(x, y, z), b = a + dvec3(0.2_mm, -0.1_mm, 0.3_mm);
      Removed removed;
      cut_with_ball(tissue, a, b, 0.6_mm, changed, {}, removed);
      for (int k = 0; k < 4000; ++k) {
        const auto j = static_cast<std::size_t>(k);
        const double r = tissue.tree().radius(k);
        if (r == 0) continue;
        const dvec3 c = tissue.tree().center(k);
        ASSERT_GE(glm::distance(c, nearest_on_segment(a, b, c)), r + 0.6_mm - 1e-12) << k;
        ASSERT_LE(glm::distance(c, p.center[j]) + r, p.radius[j] + 1e-12) << k;
      }
    }
  }
}

TEST(Removal, RemovedAndRemainingVolumeAddUpForEachTissue) {
  std::mt19937_64 random(2);
  const SpherePacking p = ball(4000);
  SphereTissue tissue(p, Removal::kMended);
  std::vector<Place> changed(4000);
  Removed removed;
  std::uniform_real_distribution<double> u(-5.0_mm, 5.0_mm);
  for (int i = 0; i < 300; ++i) {
    const double x = u(random), y = u(random), z = u(random);
    const dvec3 a(x, y, z);
    cut_with_ball(tissue, a, a + dvec3(u(random), u(random), u(random)) * 0.2, 0.5_mm, changed, {}, removed);
  }
  PerTissue left{};
  for (int i = 0; i < 4000; ++i) left[static_cast<std::size_t>(tissue.tissue(i))] += tissue.volume(i);
  for (std::size_t t = 0; t < kTissueCount; ++t) {
    ASSERT_NEAR(left[t] + removed.volume[t], p.solid_volume[t], 1e-12 * total(p.solid_volume)) << t;
  }
  EXPECT_GT(removed.volume[static_cast<std::size_t>(Tissue::kPulp)], 0);
  EXPECT_GT(removed.volume[static_cast<std::size_t>(Tissue::kDentin)], 0);
}

TEST(Removal, FourTimesAsManyStepsRemoveTheSameVolumeWithinTwoPercent) {
  const SpherePacking p = ball(10000);
  std::vector<Place> changed(10000);
  const dvec3 a(-2.0_mm, 0.3_mm, 4.9_mm), b(2.0_mm, -0.4_mm, 4.4_mm);
  double taken[2];
  for (const int steps : {100, 400}) {
    SphereTissue tissue(p, Removal::kMended);
    Removed removed;
    for (int k = 0; k < steps; ++k) {
      cut_with_ball(tissue, glm::mix(a, b, static_cast<double>(k) / steps),
                    glm::mix(a, b, static_cast<double>(k + 1) / steps), 0.6_mm, changed, {}, removed);
    }
    taken[steps == 400] = total(removed.volume);
  }
  EXPECT_NEAR(taken[1] / taken[0], 1, 0.02);
}

TEST(Surface, OnABallTheErrorOfTheNormalFallsWithTheNumberOfSpheres) {
  PerTissue density{};
  density.fill(1);
  double before = 1;
  for (const std::size_t n : {2000u, 20000u}) {
    const SphereTissue tissue(ball(n), Removal::kMended);
    SphereProxy proxy(ToolSpheres({dvec3(0)}, {1.0_mm}), {});
    std::vector<Place> scratch(n);
    std::mt19937_64 random(4);
    std::uniform_real_distribution<double> u(-1, 1);
    double squares = 0;
    for (int i = 0; i < 200; ++i) {
      const dvec3 out = glm::normalize(dvec3(u(random), u(random), u(random)));
      proxy.place({6.0_mm * out, {1, 0, 0, 0}});
      const SurfaceEstimate e = estimate_surface(tissue, proxy, 5.0_mm * out, 0.2_mm, density, scratch);
      squares += std::pow(glm::length(glm::cross(e.n_W, out)), 2) / 200;
    }
    EXPECT_LT(std::sqrt(squares), 0.5 * before) << n;
    before = std::sqrt(squares);
  }
  EXPECT_LT(before, 5.0_deg);
}

TEST(Surface, TheDensityIsTheMeanOfTheOverlappedSpheres) {
  SpherePacking p;
  p.center = {dvec3(-1.0_mm, 0, 0), dvec3(1.0_mm, 0, 0)};
  p.radius = {0.5_mm, 0.5_mm};
  p.tissue = {Tissue::kEnamel, Tissue::kDentin};
  const SphereTissue tissue(p, Removal::kMended);
  SphereProxy proxy(ToolSpheres({dvec3(0)}, {0.5_mm}), {});
  PerTissue density{};
  density[static_cast<std::size_t>(Tissue::kEnamel)] = 1.5, density[static_cast<std::size_t>(Tissue::kDentin)] = 1;
  std::array<Place, 4> scratch;
  const SurfaceEstimate both = estimate_surface(tissue, proxy, dvec3(0), 0.6_mm, density, scratch);
  EXPECT_NEAR(both.normalised, 1.25, 1e-12);
  EXPECT_NEAR(both.fraction[static_cast<std::size_t>(Tissue::kEnamel)], 0.5, 1e-12);
  EXPECT_NEAR(both.density, 1.25 * 2 * lens_volume(1.1_mm, 0.5_mm, 1.0_mm) / 1.0_mm3, 1e-9);
  EXPECT_NEAR(both.n_W.x, 1, 1e-12);  // the normal points away from the denser side
}

TEST(Surface, SpeedTimesDensityIsTheBaseSpeedAndZeroDensityGivesNoResistance) {
  for (const double rho : {0.6, 0.8, 1.0, 1.5}) EXPECT_NEAR(cutting_speed(2e-3, rho, 0.1) * rho, 2e-3, 1e-15);
  EXPECT_EQ(cutting_speed(2e-3, 0, 0.1), 0.1);
  EXPECT_EQ(cutting_step(2e-3, 1e-3, 1), 2e-6);
  EXPECT_EQ(cutting_step(2e-3, 1e-3, 1e-6), 1e-6);  // the step never passes the hand
}

TEST(ToolSpheres, ABallIsOneSphereAndOtherHeadsLieInsideTheirShape) {
  Tool tool;
  EXPECT_EQ(tool_spheres(tool, 50).radius, std::vector<double>{tool.radius()});
  for (const HeadShape shape : {HeadShape::kCylinder, HeadShape::kCone, HeadShape::kRoundEndCylinder}) {
    tool.shape = shape, tool.diameter = 1.0_mm, tool.length = 4.0_mm;
    const ToolSpheres s = tool_spheres(tool, 120);
    EXPECT_LE(s.radius.size(), 120u);
    EXPECT_GE(s.radius.size(), 20u);
    for (std::size_t i = 0; i < s.radius.size(); ++i)
      EXPECT_LE(tool.distance(s.center_T[i]) + s.radius[i], 0.01_mm) << i;
    EXPECT_LE(s.reach, tool.reach() + 0.01_mm);
  }
}

TEST(ToolSpheres, SixtySpheresLieWithin30MicrometresOfTheHeadsSurfaceInTheMean) {
  for (const HeadShape shape : {HeadShape::kCylinder, HeadShape::kCone, HeadShape::kRoundEndCylinder, HeadShape::kPear,
                                HeadShape::kFlame, HeadShape::kInvertedCone}) {
    Tool tool;
    tool.shape = shape, tool.diameter = 1.0_mm, tool.length = 4.0_mm;
    const ToolSpheres s = tool_spheres(tool, 60);
    double sum = 0;  // m, of the distances from points of the head's surface to the nearest sphere
    const std::vector<HeadSample> samples = sample_head(tool, 2000);
    for (const HeadSample& sample : samples) {
      double nearest = 1;
      for (std::size_t i = 0; i < s.head; ++i)
        nearest = std::min(nearest, glm::distance(sample.p_TQ, s.center_T[i]) - s.radius[i]);
      sum += std::max(0.0, nearest);
    }
    EXPECT_LT(sum / static_cast<double>(samples.size()), 0.03_mm) << name_of(shape);
  }
}

TEST(Removal, ACutByOverlappingBallsCostsExactlyWhatItRemoves) {
  SphereTissue tissue(ball(2000), Removal::kMended);
  PerTissue one;
  one.fill(1);
  std::vector<Place> near(tissue.size());
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> place(-kBall, kBall), radius(0.3_mm, 1.0_mm);
  TriedCut tried(tissue.size());
  for (int cut = 0; cut < 40; ++cut) {
    std::array<dvec3, 6> center;
    std::array<double, 6> r;
    for (std::size_t t = 0; t < center.size(); ++t) {
      center[t] = t == 0 ? dvec3(place(random), place(random), place(random)) : center[t - 1] + dvec3(0, 0, 0.2_mm);
      r[t] = radius(random);
    }
    const dvec3 way(0.3_mm, 0, 0);
    double cost = 0;
    tried.begin(center.size());
    for (std::size_t t = 0; t < center.size(); ++t) {
      const std::size_t found = tissue.tree().near_segment(center[t], center[t] + way, r[t], near);
      const auto list = std::span<const Place>(near).first(found);
      cost += tried.add(tissue, list, center[t], center[t] + way, r[t], r[t], one);
    }
    Removed removed;
    for (std::size_t t = 0; t < center.size(); ++t)
      cut_with_ball(tissue, center[t], center[t] + way, r[t], near, {}, removed);
    EXPECT_NEAR(cost, total(removed.volume), 1e-12 * 4.0 / 3 * kPi * kBall * kBall * kBall) << cut;
  }
}

// The servo computes the cost of a cut for eight spheres at once and then makes this cut; the carver cuts sphere by
// sphere. Both must leave the same bits. Small steps continue the cuts of many spheres, jumps begin new cuts.
TEST(Removal, TheTriedCutLeavesTheSameBitsAsTheCutSphereBySphere) {
  PerTissue one;
  one.fill(1);
  for (const Removal removal : {Removal::kMended, Removal::kAsPrinted}) {
    for (const std::size_t balls : {1u, 4u}) {
      SphereTissue tried_tissue(ball(2000), removal), tissue(ball(2000), removal);
      std::vector<Place> near(tissue.size()), changed(tissue.size());
      TriedCut tried(tissue.size());
      std::mt19937_64 random(7);
      std::uniform_real_distribution<double> u(-1, 1);
      dvec3 from(0);
      std::size_t made = 0;
      for (int cut = 0; cut < 400; ++cut) {
        if (cut % 50 == 0) from = glm::normalize(dvec3(u(random), u(random), u(random))) * 5.2_mm;
        const dvec3 way = 0.02_mm * dvec3(u(random), u(random), u(random)) - 0.02 * from;
        const double r = cut % 100 < 60 ? 1.0_mm : 0.7_mm;
        tried.begin(balls);
        Removed of_tried, removed;
        for (std::size_t t = 0; t < balls; ++t) {
          const dvec3 a = from + static_cast<double>(t) * dvec3(0.4_mm, 0, 0);
          const std::size_t found = tried_tissue.tree().near_segment(a, a + way, r, near);
          tried.add(tried_tissue, std::span<const Place>(near).first(found), a, a + way, r, r, one);
          cut_with_ball(tissue, a, a + way, r, changed, {}, removed);
        }
        tried_tissue.make(
            tried, of_tried, [&](Place, double) { ++made; }, [] {});
        ASSERT_EQ(of_tried.volume, removed.volume) << cut;
        from += way;
      }
      EXPECT_GT(made, 3000u);
      for (int i = 0; i < static_cast<int>(tissue.size()); ++i) {
        ASSERT_EQ(tried_tissue.sphere(i), tissue.sphere(i)) << i;
        ASSERT_EQ(tried_tissue.tree().center(i), tissue.tree().center(i)) << i;
      }
      // make() leaves boxes that may be larger than needed. This must not change the result of a search.
      for (int k = 0; k < 500; ++k) {
        const dvec3 p = 6.0_mm * dvec3(u(random), u(random), u(random)), m = 5.0_mm * dvec3(u(random), u(random), 1);
        const auto hit = tried_tissue.tree().first_hit(p, 0.3_mm, m), exact = brute_force(tissue.tree(), p, 0.3_mm, m);
        ASSERT_EQ(hit.t, exact.t) << k;
        ASSERT_EQ(hit.sphere, exact.sphere) << k;
      }
    }
  }
}

}  // namespace
}  // namespace typodont::haptics::packing
