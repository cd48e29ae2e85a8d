// Tests of laws of sphere packings, with solids whose distances are known exactly.
#include "haptics/packing.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "engine/base/error.h"
#include "engine/base/units.h"
#include "haptics/solid.h"

namespace typodont::haptics {
namespace {

using namespace literals;

const char* const kSolids[] = {
    R"({"sphere": {"center_mm": [0.3, -0.2, 0.1], "radius_mm": 2.5}})",
    R"({"box": {"center_mm": [0, 0, 0], "size_mm": [3, 4, 5]}})",
    R"({"torus": {"center_mm": [0, 0, 0], "axis": [0.3, 0.1, 1], "major_mm": 2.5, "minor_mm": 0.9}})",
    R"({"difference": [{"box": {"center_mm": [0, 0, 0], "size_mm": [4, 4, 4]}},
                       {"sphere": {"center_mm": [0.5, 0.5, 1], "radius_mm": 1.3}}]})",
    R"({"cone": {"center_mm": [0, 0, 0], "axis": [0, 0, 1], "radius_mm": 2, "top_radius_mm": 0.7, "height_mm": 4}})"};

constexpr double kVoxel = 0.1_mm;

DenseTissue sampled(const std::string& solid) {
  return read_solids(Json::parse(
      fmt::format(R"({{"voxel_mm": 0.1, "band_mm": 0.6, "solids": [{{"tissue": "dentin", "solid": {}}}]}})", solid),
      "t"));
}
SpherePacking packed(const DenseTissue& tissue, std::size_t spheres, std::uint64_t seed = 1) {
  PackOptions options;
  options.spheres = spheres;
  options.seed = seed;
  return pack_spheres(tissue, options);
}

TEST(Packing, NoTwoSpheresOverlapByMoreThanAMillionthOfTheirRadius) {
  for (const char* solid : kSolids) {
    const SpherePacking p = packed(sampled(solid), 3000);
    ASSERT_EQ(p.size(), 3000u);
    for (std::size_t i = 0; i < p.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        const double overlap = p.radius[i] + p.radius[j] - glm::distance(p.center[i], p.center[j]);
        ASSERT_LE(overlap, 1e-6 * std::min(p.radius[i], p.radius[j])) << solid << " " << i << " " << j;
      }
    }
  }
}

TEST(Packing, NoSphereSticksOutOfTheSolidByMoreThanATwentiethOfAVoxel) {
  for (const char* solid : kSolids) {
    const auto exact = read_solid(Json::parse(solid, "solid"));
    for (const std::size_t n : {300u, 5000u}) {
      const SpherePacking p = packed(sampled(solid), n);
      for (std::size_t i = 0; i < p.size(); ++i) {
        ASSERT_LE(exact->distance(p.center[i]) + p.radius[i], 0.05 * kVoxel) << solid << " " << n << " " << i;
      }
    }
  }
}

TEST(Packing, ASphereOfOneTissueReachesLessThanAVoxelIntoAnother) {
  const DenseTissue layers = read_solids(Json::parse(R"({"voxel_mm": 0.1, "solids": [
      {"tissue": "enamel", "solid": {"box": {"center_mm": [0, 0, 0], "size_mm": [4, 4, 4]}}},
      {"tissue": "dentin", "solid": {"sphere": {"center_mm": [0, 0, 0], "radius_mm": 1.4}}}]})",
                                                     "t"));
  const SpherePacking p = packed(layers, 5000);
  int inner = 0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const double from_middle = glm::length(p.center[i]);
    if (p.tissue[i] == Tissue::kDentin) {
      ++inner;
      ASSERT_LE(from_middle + p.radius[i], 1.4_mm + kVoxel) << i;
    } else {
      ASSERT_EQ(p.tissue[i], Tissue::kEnamel);
      ASSERT_GE(from_middle - p.radius[i], 1.4_mm - kVoxel) << i;
    }
  }
  EXPECT_GT(inner, 500);
}

TEST(Packing, EqualSeedsGiveEqualBitsAndOtherSeedsOtherSpheres) {
  const DenseTissue tissue = sampled(kSolids[3]);
  const SpherePacking a = packed(tissue, 2000, 7), b = packed(tissue, 2000, 7), c = packed(tissue, 2000, 8);
  EXPECT_EQ(a.center, b.center);
  EXPECT_EQ(a.radius, b.radius);
  EXPECT_EQ(a.tissue, b.tissue);
  EXPECT_EQ(a.max_hole, b.max_hole);
  EXPECT_NE(a.center, c.center);
  EXPECT_NEAR(a.coverage(), c.coverage(), 0.02);  // another packing with the same properties
}

TEST(Packing, NoSphereIsMoreThanTwiceAsLargeAsAnEarlierOne) {
  for (const char* solid : kSolids) {
    const SpherePacking p = packed(sampled(solid), 5000);
    double least = p.radius.front();
    for (const double r : p.radius) {
      ASSERT_LE(r, p.max_radius);
      ASSERT_LT(r, 2 * least) << solid;
      least = std::min(least, r);
    }
  }
}

TEST(Packing, WithoutALimitTheFirstSphereIsTheSolidsLargestWithinAVoxel) {
  for (const auto& [solid, largest] : {std::pair{kSolids[0], 2.5_mm}, {kSolids[1], 1.5_mm}, {kSolids[2], 0.9_mm}}) {
    PackOptions options;
    options.spheres = 200;
    options.max_radius = 1;
    EXPECT_NEAR(pack_spheres(sampled(solid), options).radius.front(), largest, kVoxel) << solid;
  }
}

TEST(Packing, NoHoleIsLargerThanTheReportedLargestHole) {
  std::mt19937_64 random(11);
  const DenseTissue tissue = sampled(kSolids[1]);
  const auto exact = read_solid(Json::parse(kSolids[1], "solid"));
  const SpherePacking p = packed(tissue, 2000);
  std::uniform_real_distribution<double> x(-1.5_mm, 1.5_mm), y(-2.0_mm, 2.0_mm), z(-2.5_mm, 2.5_mm);
  double most = 0;
  for (int i = 0; i < 40000; ++i) {
    const dvec3 q(x(random), y(random), z(random));
    double room = -exact->distance(q);
    for (std::size_t j = 0; j < p.size() && room > most; ++j) {
      room = std::min(room, glm::distance(q, p.center[j]) - p.radius[j]);
    }
    most = std::max(most, room);
  }
  EXPECT_LE(most, p.max_hole + 0.05 * kVoxel);
  EXPECT_GE(most, 0.6 * p.max_hole);
}

TEST(Packing, MoreSpheresUnderTheSameLimitFillMoreAndLeaveSmallerHoles) {
  const DenseTissue tissue = sampled(kSolids[0]);
  double coverage = 0, hole = 1;
  for (const std::size_t n : {500u, 2000u, 8000u}) {
    PackOptions options;
    options.spheres = n;
    options.max_radius = 0.4_mm;
    const SpherePacking p = pack_spheres(tissue, options);
    EXPECT_GT(p.coverage(), coverage);
    EXPECT_LT(p.max_hole, hole);
    coverage = p.coverage(), hole = p.max_hole;
  }
  EXPECT_GT(coverage, 0.75);
  EXPECT_LT(coverage, 1.0);
}

TEST(Packing, TheProgressCallbackCanCancelPacking) {
  PackOptions options;
  int calls = 0;
  options.progress = [&](double fraction) {
    EXPECT_GE(fraction, 0);
    EXPECT_LE(fraction, 1);
    if (++calls == 2) throw RunFailure("enough");
  };
  EXPECT_THROW(pack_spheres(sampled(kSolids[0]), options), RunFailure);
  EXPECT_EQ(calls, 2);
}

TEST(Packing, NumbersAndTissuesThatCannotBePackedAreRefused) {
  const DenseTissue tissue = sampled(kSolids[0]);
  EXPECT_THROW(packed(tissue, 0), Error);
  EXPECT_THROW(packed(tissue, 1'000'000'000), Error);
  PackOptions options;
  options.max_radius = -1;
  EXPECT_THROW(pack_spheres(tissue, options), Error);
  DenseTissue air = tissue;
  std::fill(air.distance.begin(), air.distance.end(), 1e-3f);
  EXPECT_THROW(packed(air, 10), Error);
}

}  // namespace
}  // namespace typodont::haptics
