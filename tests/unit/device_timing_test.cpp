#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <type_traits>
#include <vector>

#include "engine/base/units.h"
#include "engine/contract/loop_timing.h"
#include "haptics/coupling/velocity_estimator.h"
#include "tests/support/no_alloc.h"

namespace typodont::haptics {
namespace {

static_assert(std::is_trivially_copyable_v<LoopTiming>, "it travels through Latest");

TEST(LoopTiming, CountsMissesAndFindsTheWorstTick) {
  LoopTiming timing;
  for (int i = 0; i < 1000; ++i) {
    const Nanos woke = i * 1'000'000;
    timing.record(woke, woke + (i == 700 ? 1'500'000 : 20'000));
  }
  EXPECT_EQ(timing.ticks, 1000u);
  EXPECT_EQ(timing.misses, 1u);
  EXPECT_EQ(timing.worst_index, 700u);
  EXPECT_EQ(timing.worst_tick, 1'500'000);
  EXPECT_EQ(timing.worst_jitter, 0);
}

TEST(LoopTiming, QuantilesAreWithinOneBinAndNeverTooSmall) {
  std::mt19937 random(1);
  std::lognormal_distribution<double> spread(std::log(30e3), 1);
  std::vector<Nanos> all;
  DurationHistogram histogram;
  for (int i = 0; i < 20'000; ++i) {
    all.push_back(static_cast<Nanos>(spread(random)));
    histogram.add(all.back());
  }
  std::sort(all.begin(), all.end());
  for (const double q : {0.5, 0.9, 0.99, 0.999}) {
    const double truth = static_cast<double>(all[static_cast<std::size_t>(q * 20'000)]);
    EXPECT_GE(histogram.quantile(q), truth * 0.999);
    EXPECT_LE(histogram.quantile(q), truth * 1.1);
  }
}

constexpr double kStep = 0.055 * kMillimetre;  // quantisation of a common arm

dvec3 quantised(const dvec3& p) {
  return kStep * glm::round(p / kStep);
}

TEST(VelocityEstimator, OfAFlickeringCountAtRestIsAtMostOneCountInAWindow) {
  VelocityEstimator estimator(kStep);
  std::mt19937 random(1);
  double worst = 0;
  for (int i = 0; i < 5000; ++i) {
    const double flicker = static_cast<double>(random() % 2);  // sits on the edge between two counts
    const auto estimate = estimator.add(Nanos{i} * 1'000'000, {kStep * flicker, 0, 0});
    if (i > 100) worst = std::max(worst, glm::length(estimate.v));
  }
  EXPECT_LE(worst,
            kStep / (VelocityEstimator::kWindow - 1) / 1e-3 * (1 + 1e-9));  // 1.2 mm/s, where a difference says 55
}

TEST(VelocityEstimator, NoiseDoesNotGrowWithTheRate) {
  for (const Nanos period : {1'000'000, 500'000, 250'000, 100'000}) {
    VelocityEstimator estimator(kStep);
    double worst = 0;
    for (Nanos t = 0; t < 2'000'000'000; t += period) {
      const auto estimate = estimator.add(t, quantised({0.003 * to_seconds(t), 0, 0}));
      if (t > 100'000'000) worst = std::max(worst, std::abs(estimate.v.x - 0.003));
    }
    EXPECT_LT(worst, 0.002) << period;
  }
}

TEST(VelocityEstimator, HasATwentiethOfTheNoiseOfADifferenceInSlowMotion) {
  VelocityEstimator estimator(kStep);
  double noise = 0, noise_of_difference = 0;
  dvec3 last(0);
  const dvec3 v(0.003, -0.002, 0.001);
  int n = 0;
  for (int i = 0; i < 3000; ++i) {
    const dvec3 p = quantised(v * (i * 1e-3));
    const auto estimate = estimator.add(Nanos{i} * 1'000'000, p);
    if (i > 100) {
      noise += glm::dot(estimate.v - v, estimate.v - v);
      noise_of_difference += glm::dot((p - last) / 1e-3 - v, (p - last) / 1e-3 - v);
      ++n;
    }
    last = p;
  }
  EXPECT_LT(std::sqrt(noise / n), std::sqrt(noise_of_difference / n) / 20);
}

TEST(VelocityEstimator, ItsLagIsItsStatedLag) {
  // The estimate must be the true velocity at the time `lag` before now. In a fast oscillation, this differs much from
  // the present velocity.
  VelocityEstimator estimator(kStep);
  double error_at_lag = 0, error_now = 0, longest = 0;
  int n = 0;
  const auto velocity = [](double t) { return 0.2 * std::cos(2 * kPi * 4 * t); };
  for (int i = 0; i < 2000; ++i) {
    const double t = i * 1e-3;
    const double x = 0.2 / (2 * kPi * 4) * std::sin(2 * kPi * 4 * t);
    const auto estimate = estimator.add(Nanos{i} * 1'000'000, quantised({x, 0, 0}));
    if (i < 100) continue;
    error_at_lag += std::pow(estimate.v.x - velocity(t - estimate.lag), 2);
    error_now += std::pow(estimate.v.x - velocity(t), 2);
    longest = std::max(longest, estimate.lag);
    ++n;
  }
  EXPECT_LT(std::sqrt(error_at_lag / n), 0.012);  // m/s: the quantum over a short window
  EXPECT_LT(longest, 0.02);
}

TEST(VelocityEstimator, AStartIsDetectedWithinMilliseconds) {
  VelocityEstimator estimator(kStep);
  int seen = -1;
  for (int i = 0; i < 400; ++i) {
    const double x = i < 200 ? 0 : 0.1 * (i - 200) * 1e-3;
    const auto estimate = estimator.add(Nanos{i} * 1'000'000, quantised({x, 0, 0}));
    if (seen < 0 && i > 200 && estimate.v.x > 0.05) seen = i - 200;
  }
  EXPECT_GT(seen, 0);
  EXPECT_LE(seen, 6);
}

TEST(VelocityEstimator, ATimeThatRunsBackwardsStartsAnewAndNothingAllocates) {
  VelocityEstimator estimator(kStep);
  typodont::test::NoAlloc guard;
  for (int i = 0; i < 100; ++i) estimator.add(Nanos{i} * 1'000'000, {i * 1e-3, 0, 0});
  EXPECT_EQ(estimator.add(50'000'000, {7, 7, 7}).v, dvec3(0));
  EXPECT_NEAR(estimator.add(51'000'000, {7.001, 7, 7}).v.x, 1, 1e-6);
  EXPECT_EQ(guard.count(), 0u);
}

TEST(LoopTiming, EveryDurationHasABin) {
  for (const Nanos t : {Nanos{-5}, Nanos{0}, Nanos{1}, Nanos{100}, Nanos{101}, Nanos{104'857'599}, Nanos{1} << 60}) {
    const int bin = DurationHistogram::bin(t);
    EXPECT_GE(bin, 0);
    EXPECT_LT(bin, DurationHistogram::kBins);
  }
  EXPECT_EQ(DurationHistogram().quantile(0.5), 0);
}

}  // namespace
}  // namespace typodont::haptics
