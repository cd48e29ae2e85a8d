#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "calibration/registration_solver.h"
#include "calibration/statistics.h"
#include "engine/base/error.h"
#include "tests/support/no_alloc.h"

namespace typodont::calibration {
namespace {

struct Pairs {
  Pose X_DH;
  std::vector<dvec3> H, D;
};

Pairs exact_pairs(std::uint64_t seed, std::size_t count, double scale, double offset = 0) {
  Noise random(seed);
  Pairs pairs{{random.in_box(dvec3(-scale), dvec3(scale)), random.rotation()}, {}, {}};
  for (std::size_t i = 0; i < count; ++i) {
    pairs.H.push_back(random.in_box(dvec3(-scale), dvec3(scale)) + dvec3(offset));
    pairs.D.push_back(pairs.X_DH * pairs.H.back());
  }
  return pairs;
}

double angle_between(const dquat& a, const dquat& b) {
  const dquat d = glm::conjugate(a) * b;
  return 2 * std::asin(std::min(1.0, glm::length(dvec3(d.x, d.y, d.z))));
}

TEST(Registration, ExactPairsGiveTheMotionToTwelveDigitsAtEveryScale) {
  for (const double scale : {1e-6, 1e-3, 1.0, 1e3, 1e6}) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      for (const std::size_t count : {3u, 4u, 16u, 100u}) {
        const Pairs pairs = exact_pairs(seed, count, scale);
        const auto result = register_points(pairs.H, pairs.D);
        EXPECT_TRUE(result.trusted()) << scale << " " << seed << " " << count << " " << result.degeneracy.reason;
        EXPECT_LT(angle_between(result.X_DH.R, pairs.X_DH.R), 1e-12) << scale << " " << seed << " " << count;
        EXPECT_LT(glm::length(result.X_DH.p - pairs.X_DH.p), 1e-12 * scale * 10) << scale << " " << seed;
        EXPECT_TRUE(result.outliers.empty());
      }
    }
  }
}

TEST(Registration, FastFitNeverAllocatesAndAgreesWithTheRobustOne) {
  const Pairs pairs = exact_pairs(3, 16, 0.04);
  Pose X_DH;
  {
    test::NoAlloc guard;
    X_DH = fit_rigid(pairs.H, pairs.D);
    EXPECT_EQ(guard.count(), 0u);
  }
  EXPECT_LT(glm::length(X_DH.p - register_points(pairs.H, pairs.D).X_DH.p), 1e-16);
}

TEST(Registration, HalfTurnsAreAsExactAsSmallTurns) {
  for (const dvec3 axis : {dvec3(1, 0, 0), dvec3(0, 1, 0), dvec3(0, 0, 1), glm::normalize(dvec3(1, 2, -3))}) {
    Pairs pairs = exact_pairs(5, 12, 0.04);
    const Pose X_DH{{0.1, 0.2, 0.3}, {0, axis.x, axis.y, axis.z}};
    for (std::size_t i = 0; i < pairs.H.size(); ++i) pairs.D[i] = X_DH * pairs.H[i];
    EXPECT_LT(angle_between(register_points(pairs.H, pairs.D).X_DH.R, X_DH.R), 1e-13);
  }
}

TEST(Registration, CoplanarPointsAreDetermined) {
  Pairs pairs = exact_pairs(7, 9, 0.05);
  for (std::size_t i = 0; i < pairs.H.size(); ++i) {
    pairs.H[i].z = 0.02;
    pairs.D[i] = pairs.X_DH * pairs.H[i];
  }
  const auto result = register_points(pairs.H, pairs.D);
  EXPECT_TRUE(result.trusted()) << result.degeneracy.reason;
  EXPECT_LT(angle_between(result.X_DH.R, pairs.X_DH.R), 1e-12);
}

TEST(Registration, CollinearPointsAreReportedWithTheirDirection) {
  for (const double scale : {1e-6, 1.0, 1e6}) {
    for (const double noise : {0.0, 0.004}) {
      Noise random(11);
      const dvec3 line = glm::normalize(dvec3(1, -2, 0.5));
      Pairs pairs = exact_pairs(11, 0, scale);
      for (int i = 0; i < 12; ++i) {
        pairs.H.push_back(dvec3(0.3, 0.1, 0.2) * scale + line * (0.1 * i * scale));
        pairs.D.push_back(pairs.X_DH * pairs.H.back() + random.normal3(noise * scale));
        pairs.H.back() += random.normal3(noise * scale);
      }
      const auto result = register_points(pairs.H, pairs.D);
      EXPECT_EQ(result.degeneracy.defect, Defect::kCollinear) << scale << " " << noise;
      ASSERT_EQ(result.degeneracy.undetermined_H.size(), 1u);
      EXPECT_GT(std::abs(glm::dot(result.degeneracy.undetermined_H[0], line)), 0.999);
      EXPECT_GE(result.condition, 1e16);
      // All touches are on one line. A point beside the line may be anywhere on a circle about it, so the predicted
      // error must be large.
      const dvec3 off = pairs.H[5] + glm::normalize(glm::cross(line, dvec3(0, 0, 1))) * scale;
      EXPECT_GT(predicted_tre(result, off), scale);
    }
  }
}

TEST(Registration, OneTwoAndCoincidentPointsAreRejected) {
  const Pairs pairs = exact_pairs(13, 2, 0.04);
  const std::vector<dvec3> one_h{pairs.H[0]}, one_d{pairs.D[0]};
  EXPECT_EQ(register_points(one_h, one_d).degeneracy.defect, Defect::kCoincident);
  EXPECT_EQ(register_points(one_h, one_d).degeneracy.undetermined_H.size(), 3u);
  EXPECT_TRUE(std::isnan(register_points(one_h, one_d).sigma));
  EXPECT_EQ(register_points(pairs.H, pairs.D).degeneracy.defect, Defect::kCollinear);
  const std::vector<dvec3> many_h(20, pairs.H[0]), many_d(20, pairs.D[0]);
  EXPECT_EQ(register_points(many_h, many_d).degeneracy.defect, Defect::kCoincident);
  Noise random(17);
  std::vector<dvec3> noisy_h, noisy_d;
  for (int i = 0; i < 30; ++i) {
    noisy_h.push_back(pairs.H[0] + random.normal3(2e-4)), noisy_d.push_back(pairs.D[0] + random.normal3(2e-4));
  }
  EXPECT_FALSE(register_points(noisy_h, noisy_d).trusted());
}

TEST(Registration, DuplicatedPairsChangeNothingButTheCount) {
  Pairs pairs = exact_pairs(19, 5, 0.04);
  for (int copy = 0; copy < 3; ++copy) {
    for (std::size_t i = 0; i < 5; ++i) pairs.H.push_back(pairs.H[i]), pairs.D.push_back(pairs.D[i]);
  }
  const auto result = register_points(pairs.H, pairs.D);
  EXPECT_TRUE(result.trusted());
  EXPECT_LT(glm::length(result.X_DH.p - pairs.X_DH.p), 1e-13);
}

TEST(Registration, UnrelatedPointsAreRejected) {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    for (const std::size_t count : {3u, 4u, 6u, 20u, 100u}) {
      Noise random(seed);
      std::vector<dvec3> h, d;
      for (std::size_t i = 0; i < count; ++i) {
        h.push_back(random.in_box(dvec3(-1), dvec3(1))), d.push_back(random.in_box(dvec3(-1), dvec3(1)));
      }
      EXPECT_FALSE(register_points(h, d).trusted()) << seed << " " << count;
    }
  }
}

TEST(Registration, EmptyAndUnequalListsAreErrors) {
  const std::vector<dvec3> one{dvec3(1)}, none;
  EXPECT_THROW(register_points(none, none), Error);
  EXPECT_THROW(register_points(one, none), Error);
}

TEST(Registration, TheSuggestedTouchReducesTheErrorMost) {
  // Three touches are near the middle. So a touch in the far corner helps more than another touch in the middle.
  const std::vector<dvec3> touched{{0, 0, 0}, {0.01, 0, 0}, {0, 0.01, 0}};
  const std::vector<dvec3> candidates{{0.002, 0.002, 0.002}, {0.04, 0.04, 0.04}, {0.01, 0.01, 0}};
  EXPECT_EQ(most_useful_touch(touched, candidates, {dvec3(-0.04), dvec3(0.04)}), 1u);
}

}  // namespace
}  // namespace typodont::calibration
