// Tests of the hand–eye and robot–world solver. Exact poses give the exact result; the stated uncertainty equals the
// scatter; wrong rows have little effect; motion that does not determine the result is refused.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "calibration/hand_eye_solver.h"
#include "calibration/statistics.h"
#include "engine/base/error.h"
#include "engine/base/units.h"
#include "tests/support/pose_error.h"

namespace typodont::calibration {
namespace {

using test::error_of;
using test::Matrix6;
using test::Vector6;

dquat turn_by(const dvec3& v) {
  const double angle = glm::length(v);
  if (angle < 1e-12) return {1, 0, 0, 0};
  const dvec3 s = std::sin(0.5 * angle) / angle * v;
  return {std::cos(0.5 * angle), s.x, s.y, s.z};
}

struct NoiseLevels {
  double arm_turn = 0, arm_shift = 0, tracker_turn = 0, tracker_shift = 0;  // rad, m per axis
};
constexpr NoiseLevels kUsual{0.05 * kDegree, 1e-4, 0.1 * kDegree, 2e-4};

Pose shaken(const Pose& X, Noise& random, double turn, double shift) {
  return {X.p + random.normal3(shift), X.R * turn_by(random.normal3(turn))};
}

/// Poses of a stylus, and of a marker on the stylus as a tracker measures them.
struct Bench {
  Pose X, Z;
  std::vector<Pose> A, B;
  Bench(std::uint64_t seed, std::size_t count, const NoiseLevels& noise = {}, double turn = 40 * kDegree) {
    Noise random(seed);
    X = {random.in_box(dvec3(-0.08), dvec3(0.08)), random.rotation()};
    Z = {random.in_box(dvec3(-1), dvec3(1)), random.rotation()};
    const dquat held = random.rotation();
    for (std::size_t i = 0; i < count; ++i) {
      const Pose arm{random.in_box(dvec3(-0.08), dvec3(0.08)),
                     held * turn_by(random.in_box(dvec3(-turn), dvec3(turn)))};
      add(arm, random, noise);
    }
  }
  void add(const Pose& arm, Noise& random, const NoiseLevels& noise) {
    A.push_back(shaken(arm, random, noise.arm_turn, noise.arm_shift));
    B.push_back(shaken(inverse(Z) * arm * X, random, noise.tracker_turn, noise.tracker_shift));
  }
};

double mahalanobis(const Pose& found, const Pose& truth, const std::array<double, 36>& covariance) {
  const Vector6 e = error_of(found, truth);
  const Matrix6 C = Eigen::Map<const Matrix6>(covariance.data());
  return e.dot(C.ldlt().solve(e));
}

TEST(HandEye, ExactPosesRecoverBothTransforms) {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    for (const std::size_t count : {3u, 5u, 12u, 60u}) {
      const Bench bench(seed, count);
      const HandEyeResult found = solve_hand_eye(bench.A, bench.B);
      ASSERT_EQ(found.not_determined, "") << seed << " " << count;
      EXPECT_LT(error_of(found.X, bench.X).norm(), 1e-9) << seed << " " << count;
      EXPECT_LT(error_of(found.Z, bench.Z).norm(), 1e-9) << seed << " " << count;
      EXPECT_EQ(found.inliers.size(), count);
    }
  }
}

TEST(HandEye, ExactMotionsRecoverTheTransform) {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    for (const std::size_t count : {2u, 4u, 40u}) {
      const Bench bench(seed, count + 1);
      std::vector<Pose> A, B;
      for (std::size_t i = 0; i < count; ++i) {
        A.push_back(inverse(bench.A[i + 1]) * bench.A[i]), B.push_back(inverse(bench.B[i + 1]) * bench.B[i]);
      }
      HandEyeOptions motions;
      motions.motions = true;
      const HandEyeResult found = solve_hand_eye(A, B, motions);
      ASSERT_EQ(found.not_determined, "") << seed << " " << count;
      EXPECT_LT(error_of(found.X, bench.X).norm(), 1e-8) << seed << " " << count;
      EXPECT_EQ(found.Z.p, found.X.p);
    }
  }
}

TEST(HandEye, TheReportedCovarianceIsTheScatterOfTheResults) {
  // With many rows, the noise has 21 numbers, which include the lever of the arm's rotation. With few rows, it has two
  // numbers.
  for (const std::size_t count : {12u, 40u}) {
    double x2 = 0, z2 = 0;
    int inside = 0, runs = 0;
    for (std::uint64_t seed = 1; seed <= 250; ++seed, ++runs) {
      const Bench bench(1000 + seed, count, kUsual);
      HandEyeOptions options;
      options.reject_outliers = false;
      const HandEyeResult found = solve_hand_eye(bench.A, bench.B, options);
      ASSERT_EQ(found.not_determined, "");
      const double x = mahalanobis(found.X, bench.X, found.X_covariance);
      x2 += x, z2 += mahalanobis(found.Z, bench.Z, found.Z_covariance);
      inside += x <= chi_squared_quantile(0.95, 6);
    }
    // The mean would be six if the noise were known. But it is estimated from 12 or 40 rows.
    EXPECT_GT(x2 / runs, 5) << count;
    EXPECT_LT(x2 / runs, 8) << count;
    EXPECT_GT(z2 / runs, 5) << count;
    EXPECT_LT(z2 / runs, 8) << count;
    EXPECT_GT(inside, 0.87 * runs) << count;
  }
}

TEST(HandEye, TheReportedNoiseIsThatOfArmAndTracker) {
  double turn2 = 0, shift2 = 0;
  const NoiseLevels noise{0, 0, 0.2 * kDegree, 3e-4};  // noise of the tracker alone, without a lever
  const int runs = 60;
  for (std::uint64_t seed = 1; seed <= runs; ++seed) {
    const Bench bench(2000 + seed, 30, noise);
    const HandEyeResult found = solve_hand_eye(bench.A, bench.B);
    turn2 += found.rotation_sigma * found.rotation_sigma / runs;
    shift2 += found.translation_sigma * found.translation_sigma / runs;
  }
  EXPECT_NEAR(std::sqrt(turn2) / kDegree, 0.2, 0.01);
  EXPECT_NEAR(std::sqrt(shift2), 3e-4, 0.15e-4);
}

TEST(HandEye, UpToFortyPercentOutliersChangeTheResultLittle) {
  for (const double fraction : {0.0, 0.1, 0.25, 0.4}) {
    double found2 = 0, oracle2 = 0;
    std::size_t good_dropped = 0, good = 0;
    for (std::uint64_t seed = 1; seed <= 25; ++seed) {
      Bench bench(4000 + seed, 40, kUsual);
      Noise random(seed);
      const auto bad = static_cast<std::size_t>(40 * fraction);
      const Pose alike{random.in_box(dvec3(-0.05), dvec3(0.05)), turn_by(random.normal3(0.3))};
      for (std::size_t i = 0; i < bad; ++i) {
        switch (seed % 3) {
          case 0:  // another pose altogether
            bench.B[i] = {random.in_box(dvec3(-1), dvec3(1)), random.rotation()};
            break;
          case 1:  // the marker slipped: all wrong rows agree
            bench.B[i] = bench.B[i] * alike;
            break;
          default:  // a glitch of millimetres and degrees
            bench.B[i] = shaken(bench.B[i], random, 3 * kDegree, 4e-3);
        }
      }
      const HandEyeResult found = solve_hand_eye(bench.A, bench.B);
      ASSERT_EQ(found.not_determined, "") << fraction << " " << seed;
      const HandEyeResult oracle =
          solve_hand_eye(std::span(bench.A).subspan(bad), std::span(bench.B).subspan(bad), {false, false});
      found2 += glm::dot(found.X.p - bench.X.p, found.X.p - bench.X.p);
      oracle2 += glm::dot(oracle.X.p - bench.X.p, oracle.X.p - bench.X.p);
      good += 40 - bad;
      good_dropped += static_cast<std::size_t>(
          std::count_if(found.outliers.begin(), found.outliers.end(), [&](std::size_t i) { return i >= bad; }));
    }
    EXPECT_LT(std::sqrt(found2), 1.25 * std::sqrt(oracle2)) << fraction;
    EXPECT_LE(good_dropped, good / 200) << fraction;
  }
}

TEST(HandEye, DegenerateMotionIsRefusedWithAReason) {
  Noise random(9);
  const dvec3 axis = glm::normalize(dvec3(1, 2, -1));
  for (const NoiseLevels& noise : {NoiseLevels{}, kUsual}) {
    Bench still(50, 0), one_axis(51, 0);
    const dquat held = random.rotation();
    for (int i = 0; i < 20; ++i) {
      const dvec3 at = random.in_box(dvec3(-0.1), dvec3(0.1));
      still.add({at, held}, random, noise);
      one_axis.add({at, held * turn_by(random.uniform(-1, 1) * axis)}, random, noise);
    }
    const HandEyeResult a = solve_hand_eye(still.A, still.B), b = solve_hand_eye(one_axis.A, one_axis.B);
    EXPECT_NE(a.not_determined.find("neither rotation nor translation is determined"), std::string::npos)
        << a.not_determined;
    EXPECT_NE(b.not_determined.find("all turns are about one axis"), std::string::npos) << b.not_determined;
    EXPECT_NE(b.not_determined.find("0.408"), std::string::npos) << b.not_determined;  // 1/√6, the axis in S
  }
}

TEST(HandEye, AnOutlierDoesNotHideThatAllRotationsShareOneAxis) {
  Noise random(10);
  Bench bench(52, 0);
  for (int i = 0; i < 20; ++i) {
    bench.add({random.in_box(dvec3(-0.1), dvec3(0.1)), turn_by(dvec3(0, random.uniform(-1, 1), 0))}, random, kUsual);
  }
  bench.A[3].R = random.rotation();
  EXPECT_NE(solve_hand_eye(bench.A, bench.B).not_determined, "");
}

TEST(HandEye, InvertedPosesAreRecognised) {
  Bench bench(60, 25, kUsual);
  for (Pose& pose : bench.B) pose = inverse(pose);
  EXPECT_NE(solve_hand_eye(bench.A, bench.B).not_determined.find("they do fit with every pose b inverted"),
            std::string::npos)
      << solve_hand_eye(bench.A, bench.B).not_determined;
}

TEST(HandEye, UnrelatedPosesAreAlwaysRejected) {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    Noise random(seed);
    for (const std::size_t count : {4u, 8u, 30u}) {
      std::vector<Pose> A, B;
      for (std::size_t i = 0; i < count; ++i) {
        A.push_back({random.in_box(dvec3(-0.1), dvec3(0.1)), random.rotation()});
        B.push_back({random.in_box(dvec3(-0.1), dvec3(0.1)), random.rotation()});
      }
      EXPECT_NE(solve_hand_eye(A, B).not_determined, "") << seed << " " << count;
    }
  }
}

TEST(HandEye, TooFewOrUnequalListsAreErrors) {
  const std::vector<Pose> two(2), three(3);
  EXPECT_THROW(solve_hand_eye(two, two), Error);
  EXPECT_THROW(solve_hand_eye(three, two), Error);
}

}  // namespace
}  // namespace typodont::calibration
