// Tests of the registration with random noise from a seed.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "calibration/registration_solver.h"
#include "calibration/statistics.h"
#include "tests/support/pose_error.h"

namespace typodont::calibration {
namespace {

using test::error_of;
using test::Matrix6;
using test::Vector6;
constexpr double kSigma = 2e-4;  // m

struct Scene {
  Pose X_DH;
  std::vector<dvec3> H, exact_D;
  Scene(std::uint64_t seed, std::size_t count) {
    Noise random(seed);
    X_DH = {random.in_box(dvec3(-0.3), dvec3(0.3)), random.rotation()};
    for (std::size_t i = 0; i < count; ++i) {
      H.push_back(random.in_box(dvec3(-0.04), dvec3(0.04)) + dvec3(0.1, -0.05, 0.2));
      exact_D.push_back(X_DH * H.back());
    }
  }
  std::vector<dvec3> noisy(Noise& random) const {
    std::vector<dvec3> D = exact_D;
    for (dvec3& d : D) d += random.normal3(kSigma);
    return D;
  }
};

TEST(RegistrationLaws, ReportedCovarianceIsTheScatterOfTheEstimates) {
  const Scene scene(1, 24);
  Noise random(2);
  Matrix6 scatter = Matrix6::Zero(), reported = Matrix6::Zero();
  const int runs = 6000;
  RegistrationOptions options;
  options.reject_outliers = false;
  for (int run = 0; run < runs; ++run) {
    const auto result = register_points(scene.H, scene.noisy(random), options);
    const Vector6 e = error_of(result.X_DH, scene.X_DH);
    scatter += e * e.transpose() / runs;
    reported += Eigen::Map<const Matrix6>(result.covariance.data()) / runs;
  }
  // Measures the scatter of the results in units of the reported covariance. It must be the unit matrix, within 5 % in
  // every direction.
  const Matrix6 W = reported.llt().matrixL().solve(Matrix6::Identity());
  const Matrix6 whitened = W * scatter * W.transpose();
  const Eigen::SelfAdjointEigenSolver<Matrix6> eigen(whitened);
  EXPECT_GT(eigen.eigenvalues()[0], 0.92);  // the extreme eigenvalues of 6000 samples spread by 2·sqrt(6/6000) = 6 %
  EXPECT_LT(eigen.eigenvalues()[5], 1.08);
  EXPECT_NEAR(whitened.trace() / 6, 1, 0.05);
}

TEST(RegistrationLaws, PredictedTargetErrorIsWithinTwoPercentOfSimulation) {
  const Scene scene(3, 20);
  Noise random(4);
  const std::vector<dvec3> targets{dvec3(0.1, -0.05, 0.2), dvec3(0.14, -0.01, 0.24), dvec3(0.0, 0.1, 0.3)};
  std::vector<double> seen(targets.size()), predicted(targets.size());
  double box_seen = 0, box_predicted = 0;
  const int runs = 12000;
  RegistrationOptions options;
  options.reject_outliers = false;
  options.workspace_H = {dvec3(0.06, -0.09, 0.16), dvec3(0.14, -0.01, 0.24)};
  for (int run = 0; run < runs; ++run) {
    const auto result = register_points(scene.H, scene.noisy(random), options);
    const auto squared = [&](const dvec3& p) {
      const dvec3 e = result.X_DH * p - scene.X_DH * p;
      return glm::dot(e, e);
    };
    for (std::size_t i = 0; i < targets.size(); ++i) {
      seen[i] += squared(targets[i]) / runs;
      predicted[i] += std::pow(predicted_tre(result, targets[i]), 2) / runs;
    }
    box_seen += squared(random.in_box(options.workspace_H.low, options.workspace_H.high)) / runs;
    box_predicted += std::pow(result.predicted_tre_rms, 2) / runs;
  }
  for (std::size_t i = 0; i < targets.size(); ++i) EXPECT_NEAR(std::sqrt(predicted[i] / seen[i]), 1, 0.02) << i;
  EXPECT_NEAR(std::sqrt(box_predicted / box_seen), 1, 0.02);
}

TEST(RegistrationLaws, FiducialErrorFollowsFitzpatrick) {
  // E[FRE²] = (1 - 2/N) FLE², FLE² = 3σ².
  const Scene scene(7, 8);
  Noise random(8);
  double fre2 = 0;
  const int runs = 6000;
  RegistrationOptions options;
  options.reject_outliers = false;
  for (int run = 0; run < runs; ++run) {
    fre2 += std::pow(register_points(scene.H, scene.noisy(random), options).fre_rms, 2) / runs;
  }
  EXPECT_NEAR(fre2 / ((1 - 2.0 / 8) * 3 * kSigma * kSigma), 1, 0.03);
}

TEST(RegistrationLaws, ScatteredOutliersUpToSeventyPercentAreFoundExactly) {
  for (const std::size_t count : {20u, 60u, 200u}) {
    for (const double fraction : {0.1, 0.4, 0.7}) {
      for (std::uint64_t seed = 1; seed <= 6; ++seed) {
        const Scene scene(100 + seed, count);
        Noise random(200 + seed);
        auto D = scene.noisy(random);
        const auto bad = static_cast<std::size_t>(fraction * static_cast<double>(count));
        for (std::size_t i = 0; i < bad; ++i) {
          dvec3 off = random.normal3(1);
          D[i] += glm::normalize(off) * random.uniform(0.003, 0.05);  // 15σ and more
        }
        const auto result = register_points(scene.H, D);
        if (!result.rivals.empty()) continue;
        std::vector<std::size_t> good(count - bad);
        std::iota(good.begin(), good.end(), bad);
        EXPECT_EQ(result.inliers, good) << count << " " << fraction << " " << seed;
        EXPECT_TRUE(result.trusted()) << count << " " << fraction << " " << seed << " " << result.degeneracy.reason;
      }
    }
  }
}

// Wrong pairs that all follow one other motion, which is a shift or a screw motion. Each of them is at least `distance`
// standard deviations of the noise away from its correct position.
struct TwoMotions {
  Scene scene;
  std::vector<dvec3> D;
  std::vector<std::size_t> good;
  TwoMotions(std::uint64_t seed, std::size_t count, double fraction, double distance) : scene(seed, count) {
    Noise random(seed + 7);
    const dvec3 along = glm::normalize(random.normal3(1)), middle = scene.X_DH * dvec3(0.1, -0.05, 0.2);
    const double angle = seed % 2 == 0 ? 0 : distance * kSigma / 0.04;
    const dquat turn(std::cos(0.5 * angle), along * std::sin(0.5 * angle));
    const auto bad = static_cast<std::size_t>(fraction * static_cast<double>(count) + 1e-9);
    D = scene.exact_D;
    for (std::size_t i = 0; i < bad; ++i) D[i] = turn * (D[i] - middle) + middle + distance * kSigma * along;
    for (dvec3& d : D) d += random.normal3(kSigma);
    good.resize(count - bad);
    std::iota(good.begin(), good.end(), bad);
  }
};

TEST(RegistrationLaws, ConsistentOutliersTenSigmaAwayAreFoundExactlyOrReported) {
  int runs = 0, inexact = 0;
  double error2 = 0, oracle2 = 0;
  RegistrationOptions told, plain;
  told.known_sigma = kSigma, plain.reject_outliers = false;
  for (const std::size_t count : {12u, 16u, 30u, 60u, 150u}) {
    for (int tenths = 1; tenths <= 7; ++tenths) {
      for (const double distance : {10.0, 14.0, 30.0}) {
        for (std::uint64_t seed = 1; seed <= 3; ++seed) {
          const TwoMotions two(10'000 * seed + 100 * count + 10 * static_cast<std::uint64_t>(tenths) + seed, count,
                               0.1 * tenths, distance);
          const std::size_t bad = count - two.good.size();
          for (const RegistrationOptions& options : {RegistrationOptions{}, told}) {
            const auto found = register_points(two.scene.H, two.D, options);
            ++runs;
            if (!found.trusted()) continue;
            ASSERT_GE(found.inliers.front(), bad)
                << "a wrong pair is trusted: " << count << " " << tenths << " " << distance << " " << seed;
            inexact += found.inliers != two.good;
            const auto oracle =
                register_points(std::span(two.scene.H).subspan(bad), std::span(two.D).subspan(bad), plain);
            for (const dvec3& p : two.scene.H) {
              error2 += std::pow(glm::length(found.X_DH * p - two.scene.X_DH * p), 2);
              oracle2 += std::pow(glm::length(oracle.X_DH * p - two.scene.X_DH * p), 2);
            }
          }
        }
      }
    }
  }
  EXPECT_LE(inexact, runs / 400) << "one good pair in 2000 sets may be set aside";
  EXPECT_LT(std::sqrt(error2), 1.1 * std::sqrt(oracle2));
}

TEST(RegistrationLaws, SecondMotionsNearTheNoiseLevelAreReportedIfDetectable) {
  // Half of the pairs are wrong by five standard deviations of the noise. A fit between both halves explains all pairs,
  // with slightly too large residuals.
  RegistrationOptions told;
  told.known_sigma = kSigma;
  int blind = 0, known = 0;
  const int runs = 40;
  for (std::uint64_t seed = 1; seed <= runs; ++seed) {
    const TwoMotions two(2000 + seed, 60, 0.5, 5);
    blind += !register_points(two.scene.H, two.D).trusted();
    known += !register_points(two.scene.H, two.D, told).trusted();
  }
  EXPECT_EQ(blind, runs);
  EXPECT_EQ(known, runs);
}

TEST(RegistrationLaws, GoodPairsAreNeverReportedAsTwoMotions) {
  RegistrationOptions told;
  told.known_sigma = kSigma;
  int doubted = 0, runs = 0;
  for (const std::size_t count : {8u, 12u, 20u, 50u, 150u}) {
    for (std::uint64_t seed = 1; seed <= 40; ++seed, ++runs) {
      const Scene scene(3000 + seed, count);
      Noise random(4000 + seed);
      const auto D = scene.noisy(random);
      EXPECT_TRUE(register_points(scene.H, D).trusted()) << count << " " << seed;
      doubted += !register_points(scene.H, D, told).trusted();
    }
  }
  EXPECT_LE(doubted, runs / 100);
}

TEST(RegistrationLaws, CoincidencesOfQuantisedPointsAreNotReportedAsASecondMotion) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const Scene scene(5000 + seed, 24);
    std::vector<dvec3> H, D;
    for (std::size_t i = 0; i < 24; ++i) {
      H.push_back(glm::round(scene.H[i] / 1e-3) * 1e-3);
      D.push_back(glm::round(scene.exact_D[i] / 1e-3) * 1e-3);
    }
    EXPECT_GE(register_points(H, D).inliers.size(), 23u) << seed;
  }
}

TEST(RegistrationLaws, AMirrorImageOrAnotherScaleIsReportedAndNotFitted) {
  for (const std::size_t count : {4u, 5u, 8u, 30u}) {
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      const Scene scene(1300 + seed, count);
      Noise random(1400 + seed);
      std::vector<dvec3> mirrored, scaled;
      for (const dvec3& p : scene.H) {
        mirrored.push_back(scene.X_DH * (p * dvec3(1, 1, -1)) + random.normal3(kSigma));
        scaled.push_back(scene.X_DH * (1.05 * p) + random.normal3(kSigma));
      }
      // A nearly flat set is nearly equal to its mirror image. Then the fit is as good as its residuals state.
      const auto reflected = register_points(scene.H, mirrored);
      EXPECT_TRUE(!reflected.trusted() || reflected.sigma < 8 * kSigma) << count << " " << seed;
      if (count >= 8) {
        EXPECT_EQ(reflected.degeneracy.defect, Defect::kMirrored) << count << " " << seed;
        EXPECT_EQ(register_points(scene.H, scaled).degeneracy.defect, Defect::kScaled) << count << " " << seed;
      }
      EXPECT_TRUE(register_points(scene.H, scene.noisy(random)).trusted()) << count << " " << seed;
    }
  }
}

// Kinds of wrong pairs that occur at a real bench, as a fraction of all pairs.
enum class Wrong { kScattered, kNear, kShifted, kCorner, kHeavyTail, kSwapped, kTurned };
constexpr Wrong kWrongs[] = {Wrong::kScattered, Wrong::kNear,    Wrong::kShifted, Wrong::kCorner,
                             Wrong::kHeavyTail, Wrong::kSwapped, Wrong::kTurned};

struct Contaminated {
  Scene scene;
  std::vector<dvec3> D;
  std::vector<bool> wrong;

  Contaminated(std::uint64_t seed, std::size_t count, double fraction, Wrong kind)
      : scene(seed, count), wrong(count, false) {
    Noise random(seed + 17);
    D = scene.noisy(random);
    std::vector<std::size_t> order(count);
    std::iota(order.begin(), order.end(), 0u);
    for (std::size_t i = count; i > 1; --i) std::swap(order[i - 1], order[random.index(i)]);
    if (kind == Wrong::kCorner) {  // the pairs next to one corner of the workspace, all with the same shift
      const dvec3 corner = dvec3(0.1, -0.05, 0.2) + 0.04 * glm::sign(random.normal3(1));
      std::sort(order.begin(), order.end(),
                [&](auto a, auto b) { return glm::length(scene.H[a] - corner) < glm::length(scene.H[b] - corner); });
    }
    const dvec3 shift = glm::normalize(random.normal3(1)) * random.uniform(0.001, 0.006);
    const Pose turned{scene.X_DH.p + random.normal3(0.02), random.rotation()};
    auto bad = static_cast<std::size_t>(fraction * static_cast<double>(count) + 1e-9);
    if (kind == Wrong::kSwapped) bad -= bad % 2;
    for (std::size_t k = 0; k < bad; ++k) {
      const std::size_t i = order[k];
      wrong[i] = true;
      switch (kind) {
        case Wrong::kScattered:
          D[i] += random.in_box(dvec3(-0.05), dvec3(0.05));
          break;
        case Wrong::kNear:
          D[i] += glm::normalize(random.normal3(1)) * random.uniform(0.0012, 0.003);
          break;
        case Wrong::kShifted:
        case Wrong::kCorner:
          D[i] += shift;
          break;
        case Wrong::kHeavyTail:  // Cauchy
          D[i] += random.normal3(1e-3) / std::max(0.02, std::abs(random.normal()));
          break;
        case Wrong::kSwapped:
          if (k % 2 == 1) std::swap(D[i], D[order[k - 1]]);
          break;
        case Wrong::kTurned:
          D[i] = turned * scene.H[i] + random.normal3(kSigma);
          break;
      }
    }
  }

  /// Returns the rms error (m) over the corners of the workspace.
  double error_of(const Pose& found) const {
    double squares = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const dvec3 p =
          dvec3(0.1, -0.05, 0.2) + 0.04 * dvec3(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
      squares += std::pow(glm::length(found * p - scene.X_DH * p), 2) / 8;
    }
    return std::sqrt(squares);
  }
  /// Returns the error of the fit to the correct pairs alone.
  double oracle_error() const {
    std::vector<dvec3> H, good;
    for (std::size_t i = 0; i < D.size(); ++i) {
      if (!wrong[i]) H.push_back(scene.H[i]), good.push_back(D[i]);
    }
    return error_of(fit_rigid(H, good));
  }
  int good_pairs_dropped(const RegistrationResult& result) const {
    return static_cast<int>(
        std::count_if(result.outliers.begin(), result.outliers.end(), [&](std::size_t i) { return !wrong[i]; }));
  }
};

TEST(RegistrationLaws, UpTo45PercentOutliersCostLittleMoreThanTheirAbsence) {
  RegistrationOptions told;
  told.known_sigma = kSigma;
  for (const Wrong kind : kWrongs) {
    double found2 = 0, oracle2 = 0;
    int sets = 0, spoilt = 0;
    for (const std::size_t count : {20u, 50u, 100u}) {
      for (int twentieths = 0; twentieths <= 9; ++twentieths) {
        for (std::uint64_t seed = 1; seed <= 3; ++seed) {
          const Contaminated set(60'000 + 100 * seed + count + static_cast<std::uint64_t>(twentieths), count,
                                 0.05 * twentieths, kind);
          const double oracle = set.oracle_error();
          for (const RegistrationOptions& options : {RegistrationOptions{}, told}) {
            const auto found = register_points(set.scene.H, set.D, options);
            found2 += std::pow(set.error_of(found.X_DH), 2), oracle2 += oracle * oracle;
            // Even in the worst set, the error depends only on wrong pairs that are near their correct positions, never
            // on the distance of the others.
            EXPECT_LT(set.error_of(found.X_DH), 1.5e-3) << static_cast<int>(kind) << " " << count << " " << twentieths;
            spoilt += set.good_pairs_dropped(found) > 2;
            ++sets;
          }
        }
      }
    }
    EXPECT_LT(std::sqrt(found2), 1.25 * std::sqrt(oracle2)) << static_cast<int>(kind);
    EXPECT_LE(spoilt, sets / 100) << static_cast<int>(kind);
  }
}

TEST(RegistrationLaws, FewerThanHalfOfThePairsCannotBreakTheFitHoweverFarOrConsistent) {
  for (const std::size_t count : {12u, 25u, 60u}) {
    for (const double distance : {0.02, 1.0, 100.0}) {
      for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        const Scene scene(70'000 + seed, count);
        Noise random(71'000 + seed);
        auto D = scene.noisy(random);
        const dvec3 away = glm::normalize(random.normal3(1)) * distance;
        // All wrong pairs are in one place, or all have the same shift: these configurations do the most harm.
        for (std::size_t i = 0; i < (count - 1) / 2 - 1; ++i) D[i] = seed % 2 ? scene.X_DH.p + away : D[i] + away;
        const auto found = register_points(scene.H, D);
        const dvec3 middle(0.1, -0.05, 0.2);
        EXPECT_LT(glm::length(found.X_DH * middle - scene.X_DH * middle), 6e-4)
            << count << " " << distance << " " << seed;
      }
    }
  }
}

TEST(RegistrationLaws, ConfidenceEllipsoidsHaveTheirCoverageAfterOutlierRemoval) {
  int inside = 0, trusted = 0;
  for (const Wrong kind : {Wrong::kScattered, Wrong::kNear, Wrong::kHeavyTail, Wrong::kSwapped}) {
    for (std::uint64_t seed = 1; seed <= 150; ++seed) {
      const Contaminated set(80'000 + seed, 50, 0.2, kind);
      const auto found = register_points(set.scene.H, set.D);
      if (!found.trusted()) continue;
      ++trusted;
      const Vector6 e = error_of(found.X_DH, set.scene.X_DH);
      const Matrix6 C = Eigen::Map<const Matrix6>(found.covariance.data());
      inside += e.dot(C.ldlt().solve(e)) <= chi_squared_quantile(0.95, 6);
    }
  }
  EXPECT_GT(trusted, 520);
  EXPECT_GE(inside, 0.92 * trusted);  // 95 %, less its scatter and the effect of wrong pairs within the noise
  EXPECT_LE(inside, 0.98 * trusted);
}

TEST(Statistics, QuantilesMatchTheTables) {
  EXPECT_NEAR(chi_squared_quantile(0.95, 3), 7.814728, 1e-5);
  EXPECT_NEAR(chi_squared_quantile(0.05, 10), 3.940299, 1e-5);
  EXPECT_NEAR(chi_squared_quantile(0.99, 6), 16.811894, 1e-5);
  EXPECT_NEAR(f_quantile(0.95, 3, 6), 4.757063, 1e-5);
  EXPECT_NEAR(f_quantile(0.99, 3, 60), 4.125892, 1e-5);
  EXPECT_NEAR(f_quantile(0.9997, 3, 100000), chi_squared_quantile(0.9997, 3) / 3, 1e-3);
}

}  // namespace
}  // namespace typodont::calibration
