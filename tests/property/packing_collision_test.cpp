// Tests of collisions between spheres: the closed formulas, and the tree compared with a search over all spheres.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "engine/base/nearest.h"
#include "haptics/contact/packing/sphere_pair.h"
#include "haptics/contact/packing/sphere_tree.h"
#include "tests/support/every_sphere.h"

namespace typodont::haptics::packing {
namespace {

dvec3 random_in(std::mt19937_64& random, double half) {
  std::uniform_real_distribution<double> u(-half, half);
  const double x = u(random), y = u(random), z = u(random);
  return {x, y, z};
}

/// Solves eq. 1 of S2 (the fraction of the motion m at which two spheres touch) in extended precision, by the usual
/// formula for quadratic equations.
long double exact_root(const dvec3& D, const dvec3& m, double R) {
  const long double mm =
      static_cast<long double>(m.x) * m.x + static_cast<long double>(m.y) * m.y + static_cast<long double>(m.z) * m.z;
  const long double mD =
      static_cast<long double>(m.x) * D.x + static_cast<long double>(m.y) * D.y + static_cast<long double>(m.z) * D.z;
  const long double DD =
      static_cast<long double>(D.x) * D.x + static_cast<long double>(D.y) * D.y + static_cast<long double>(D.z) * D.z;
  const long double RR = static_cast<long double>(R) * R;
  const long double disc = mD * mD - mm * (DD - RR);
  if (disc < 0 || !(mD > 0)) return kNever;
  if (DD <= RR) return 0;
  const long double t = (DD - RR) / (mD + std::sqrt(disc));
  return t <= 1 ? t : static_cast<long double>(kNever);
}

TEST(SpherePair, TheContactTimeOfRandomPairsIsAccurateToATrillionth) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> size(1e-5, 1e-3);
  int hits = 0;
  for (int i = 0; i < 200'000; ++i) {
    const dvec3 D = random_in(random, 3e-3), m = random_in(random, 4e-3);
    const double R = size(random) + size(random), t = contact_time(D, m, R);
    const long double exact = exact_root(D, m, R);
    if (std::isinf(exact) || std::isinf(t)) {
      // Both must find no contact, except for spheres that only graze or barely reach each other. There rounding
      // decides.
      if (std::isinf(exact) == std::isinf(t)) continue;
      const double grazing = std::abs(glm::length(glm::cross(m, D)) - glm::length(m) * R) / (glm::length(m) * R);
      const double reaching = std::isinf(t) ? std::abs(static_cast<double>(exact) - 1) : std::abs(t - 1);
      ASSERT_LT(std::min(grazing, reaching), 1e-12) << i;
      continue;
    }
    ++hits;
    // Where spheres graze, a small change of their positions changes the root by any amount. The root is as accurate as
    // the discriminant.
    const double half_chord =
        std::sqrt(std::max(0.0, glm::dot(m, m) * R * R - glm::dot(glm::cross(m, D), glm::cross(m, D)))) /
        glm::dot(m, m);
    ASSERT_LE(std::abs(static_cast<double>(t - exact)), 1e-12 * std::max(1.0, 1e-3 / half_chord)) << i;
  }
  EXPECT_GT(hits, 10'000);
}

TEST(SpherePair, OverlappingSpheresTouchImmediatelyWhenApproachingAndNeverWhenSeparating) {
  const dvec3 D(1e-3, 0, 0);
  EXPECT_EQ(contact_time(D, {1e-4, 0, 0}, 1.1e-3), 0);
  EXPECT_EQ(contact_time(D, {-1e-4, 0, 0}, 1.1e-3), kNever);
  EXPECT_EQ(contact_time(D, {0, 1e-4, 0}, 1.1e-3), kNever);
  EXPECT_EQ(contact_time(D, {0, 0, 0}, 1.1e-3), kNever);
  EXPECT_EQ(contact_time({0, 0, 0}, {1e-4, 0, 0}, 1.1e-3), kNever);
}

TEST(SpherePair, TheIntersectionHasTheVolumeOfThePapersFormula) {
  EXPECT_NEAR(lens_volume(1, 0.5, 1.2), 0.0842339530, 5e-11);
  EXPECT_EQ(lens_volume(1, 0.5, 1.5), 0);
  EXPECT_EQ(lens_volume(1, 0.5, 2), 0);
  EXPECT_DOUBLE_EQ(lens_volume(1, 0.5, 0.2), 4.0 / 3 * kPi * 0.125);
  EXPECT_DOUBLE_EQ(lens_volume(1, 0.5, 0.2), lens_volume(0.5, 1, 0.2));
  // the volume has no step at the distance where one sphere begins to lie inside the other
  EXPECT_NEAR(lens_volume(1, 0.5, 0.5000001), 4.0 / 3 * kPi * 0.125, 1e-9);
}

struct Cloud {
  std::vector<dvec3> center;
  std::vector<double> radius;
};
Cloud cloud(std::mt19937_64& random, std::size_t n) {
  Cloud c;
  std::uniform_real_distribution<double> size(1e-5, 4e-4);
  for (std::size_t i = 0; i < n; ++i) {
    c.center.push_back(random_in(random, 5e-3) + dvec3(0.1, -0.2, 0.05));
    c.radius.push_back(size(random));
  }
  return c;
}

TEST(SphereTree, FindsTheSameFirstContactAsBruteForceBitForBit) {
  std::mt19937_64 random(4);
  for (const std::size_t n : {1u, 7u, 8u, 9u, 64u, 65u, 500u, 5000u}) {
    const Cloud c = cloud(random, n);
    const SphereTree tree(c.center, c.radius);
    int hits = 0;
    for (int i = 0; i < 3000; ++i) {
      const dvec3 p = random_in(random, 7e-3) + dvec3(0.1, -0.2, 0.05);
      dvec3 m = random_in(random, i % 3 == 0 ? 2e-2 : i % 3 == 1 ? 1e-4 : 1e-8);
      for (int a = 0; a < 3; ++a) m[a] = random() % 4 == 0 ? 0 : m[a];
      const double r = i % 2 ? 5e-4 : 2e-5;
      const auto hit = tree.first_hit(p, r, m), exact = brute_force(tree, p, r, m);
      ASSERT_EQ(hit.t, exact.t) << n << " " << i;
      ASSERT_EQ(hit.sphere, exact.sphere) << n << " " << i;
      hits += static_cast<bool>(hit);
    }
    EXPECT_GE(hits, n >= 500 ? 300 : 0);
  }
}

TEST(SphereTree, AgreesWithBruteForceWhileSpheresShrinkMoveVanishAndReturn) {
  std::mt19937_64 random(5);
  const Cloud c = cloud(random, 3000);
  SphereTree tree(c.center, c.radius);
  std::uniform_real_distribution<double> u(0, 1);
  for (int i = 0; i < 4000; ++i) {
    for (int k = 0; k < 10; ++k) {
      const auto s = static_cast<int>(random() % 3000);
      const auto j = static_cast<std::size_t>(s);
      const double fraction = u(random);
      if (fraction < 0.2) {
        tree.set(s, tree.center(s), 0);
      } else if (fraction < 0.4) {
        tree.set(s, c.center[j], c.radius[j]);
      } else {
        const double r = tree.radius(s) * u(random);
        tree.set(s, tree.center(s) + (tree.radius(s) - r) * dvec3(0.6, 0, 0.8), r);
      }
    }
    const dvec3 p = random_in(random, 6e-3) + dvec3(0.1, -0.2, 0.05), m = random_in(random, 5e-3);
    const auto hit = tree.first_hit(p, 3e-4, m), exact = brute_force(tree, p, 3e-4, m);
    ASSERT_EQ(hit.t, exact.t) << i;
    ASSERT_EQ(hit.sphere, exact.sphere) << i;
  }
}

TEST(SphereTree, FindsExactlyTheSpheresNearASegment) {
  std::mt19937_64 random(6);
  const Cloud c = cloud(random, 2000);
  const SphereTree tree(c.center, c.radius);
  std::vector<Place> found(2000);
  for (int i = 0; i < 1000; ++i) {
    const dvec3 a = random_in(random, 5e-3) + dvec3(0.1, -0.2, 0.05), b = a + random_in(random, i % 2 ? 2e-3 : 1e-7);
    const std::size_t n = tree.near_segment(a, b, 3e-4, found);
    std::vector<char> in(2000, 0);
    for (std::size_t k = 0; k < n; ++k) ASSERT_EQ(in[static_cast<std::size_t>(tree.sphere_in(found[k]))]++, 0);
    for (std::size_t k = 0; k < 2000; ++k) {
      const dvec3 off = c.center[k] - nearest_on_segment(a, b, c.center[k]);
      const double reach = c.radius[k] + 3e-4;
      ASSERT_EQ(in[k] != 0, glm::dot(off, off) < reach * reach) << i << " " << k;
    }
  }
  std::vector<Place> all;
  for (int i = 0; i < 2000; ++i) all.push_back(tree.place_of(i));
  for (std::size_t k = 0; k + 8 <= all.size(); k += 8) {  // near_of() finds the same spheres among eight given ones
    const dvec3 a = random_in(random, 3e-3) + dvec3(0.1, -0.2, 0.05), b = a + random_in(random, 2e-3);
    const unsigned near = tree.near_of(std::span(all).subspan(k, 8), a, b, 1e-3);
    for (std::size_t j = 0; j < 8; ++j) {
      const dvec3 off = c.center[k + j] - nearest_on_segment(a, b, c.center[k + j]);
      const double reach = c.radius[k + j] + 1e-3;
      ASSERT_EQ((near >> j & 1) != 0, glm::dot(off, off) < reach * reach) << k + j;
    }
  }
  std::array<Place, 3> few;
  EXPECT_GT(tree.near_segment(dvec3(0.1, -0.2, 0.05), dvec3(0.1, -0.2, 0.05), 3e-3, few), 3u);  // counted, not stored
}

}  // namespace
}  // namespace typodont::haptics::packing
