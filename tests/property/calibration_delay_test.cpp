// Tests of the delay estimate. For motion with enough information its error reaches the theoretical bound. If the
// motion has too little information, the estimate says so.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "calibration/delay_solver.h"
#include "calibration/statistics.h"
#include "engine/base/error.h"
#include "engine/base/units.h"

namespace typodont::calibration {
namespace {

using Motion = std::function<dvec3(double)>;

dvec3 sine(double t) {
  return {0.05 * std::sin(2 * kPi * t), 0, 0};
}
// Returns the position for small fast motion at 4 Hz on a slow irregular path.
dvec3 drill(double t) {
  return {0.004 * std::sin(2 * kPi * 4.1 * t + std::sin(0.9 * t)), 0.003 * std::sin(2 * kPi * 0.7 * t),
          0.002 * std::sin(2 * kPi * 9.3 * t) + 0.01 * std::sin(1.3 * t)};
}
// Returns the position of a hand that moves slowly in a volume: a sum of slow components without a common period.
dvec3 hand(double t) {
  return {0.03 * std::sin(1.9 * t) + 0.01 * std::sin(5.3 * t + 1),
          0.02 * std::sin(2.7 * t + 2) + 0.008 * std::sin(7.1 * t),
          0.025 * std::cos(1.3 * t) + 0.006 * std::sin(9.7 * t)};
}

struct Recording {
  double rate_a = 100, rate_b = 100, seconds = 10, delay = 0.0372, noise_a = 2e-4, noise_b = 2e-4, skew = 0;
  Pose X_BA;
};

struct Recorded {
  Stream a, b;
};

Recorded record(const Motion& motion, const Recording& s, std::uint64_t seed) {
  Noise random(seed);
  Recorded r;
  for (int i = 0; i < s.seconds * s.rate_a; ++i) {
    r.a.t.push_back(i / s.rate_a);
    r.a.p.push_back(motion(r.a.t.back()) + random.normal3(s.noise_a));
  }
  for (int i = 0; i < s.seconds * s.rate_b; ++i) {
    const double t = 0.0031 + i / s.rate_b;
    r.b.t.push_back(t);
    r.b.p.push_back(s.X_BA * motion((t - s.delay) / (1 + s.skew)) + random.normal3(s.noise_b));
  }
  return r;
}

double bound(const Motion& motion, const Recording& s) {
  const auto information = [&](double rate) {
    double sum = 0;
    for (int i = 0; i < s.seconds * rate; ++i) {
      const double t = i / rate;
      const dvec3 v = (motion(t + 1e-5) - motion(t - 1e-5)) / 2e-5;
      sum += glm::dot(v, v);
    }
    return sum;
  };
  return std::sqrt(s.noise_a * s.noise_a / information(s.rate_a) + s.noise_b * s.noise_b / information(s.rate_b));
}

// Returns the rms error over several seeds, divided by the bound. Also checks every reported sigma.
double efficiency(const Motion& motion, const Recording& setup, int runs = 16) {
  double squares = 0;
  for (int run = 1; run <= runs; ++run) {
    const Recorded r = record(motion, setup, static_cast<std::uint64_t>(run));
    const DelayResult d = estimate_delay(r.a, r.b);
    squares += std::pow((d.delay - setup.delay) / bound(motion, setup), 2);
    EXPECT_LT(std::abs(d.delay - setup.delay), 4.5 * d.sigma) << run;
    EXPECT_NEAR(d.sigma / bound(motion, setup), 1, 0.25) << run;
  }
  return std::sqrt(squares / runs);
}

// Returns the limit below which the root mean square of `runs` unit normal numbers stays, at three standard deviations.
double at_the_bound(int runs = 16) {
  return 1 + 3 / std::sqrt(2.0 * runs);
}

TEST(DelayLaws, TheErrorForSineDrillingAndHandMotionReachesTheTheoreticalBound) {
  EXPECT_LT(efficiency(sine, {}), at_the_bound());
  EXPECT_LT(efficiency(drill, {}), at_the_bound());
  EXPECT_LT(efficiency(hand, {}), at_the_bound());
}

TEST(DelayLaws, TheErrorWithNoiseOnOneStreamReachesTheTheoreticalBound) {
  Recording s;
  s.noise_a = 0;
  EXPECT_LT(efficiency(sine, s), at_the_bound());
  EXPECT_LT(efficiency(hand, s), at_the_bound());
}

TEST(DelayLaws, TheErrorForStreamsOfDifferentRatesReachesTheTheoreticalBound) {
  Recording s;
  s.rate_a = 1000, s.rate_b = 120, s.seconds = 6;
  EXPECT_LT(efficiency(hand, s, 12), at_the_bound(12));
  std::swap(s.rate_a, s.rate_b);
  s.delay = -0.021;
  EXPECT_LT(efficiency(hand, s, 12), at_the_bound(12));
}

TEST(DelayLaws, ExactStreamsGiveTheDelayToANanosecond) {
  Recording s;
  s.noise_a = s.noise_b = 0;
  const Recorded r = record(hand, s, 1);
  const DelayResult d = estimate_delay(r.a, r.b);
  EXPECT_NEAR(d.delay, s.delay, 1e-9);
  EXPECT_FALSE(d.ambiguous) << d.reason;
  EXPECT_TRUE(d.rich);
}

TEST(DelayLaws, StreamsInDifferentFramesGiveTheSameDelay) {
  Recording s;
  s.X_BA = {{0.3, -0.2, 0.1}, glm::normalize(dquat(0.5, 0.3, -0.7, 0.2))};
  const Recorded r = record(hand, s, 4);
  const DelayResult d = estimate_delay(r.a, r.b);
  EXPECT_TRUE(d.rotated);
  EXPECT_FALSE(d.ambiguous) << d.reason;
  EXPECT_NEAR(d.delay, s.delay, 4 * d.sigma);
  EXPECT_LT(d.sigma, 1e-4);
}

TEST(DelayLaws, ConstantVelocityIsReportedAsUndetermined) {
  for (const double noise : {0.0, 2e-4}) {
    Recording s;
    s.noise_a = s.noise_b = noise;
    const Recorded r = record([](double t) { return dvec3(0.02 * t, -0.01 * t, 0.005 * t); }, s, 5);
    const DelayResult d = estimate_delay(r.a, r.b);
    EXPECT_TRUE(d.ambiguous) << noise;
    EXPECT_FALSE(d.rich);
    EXPECT_GT(d.sigma, 0.1);
  }
}

TEST(DelayLaws, AHandAtRestIsReportedAsNoMotion) {
  for (const double noise : {0.0, 1e-5, 2e-4}) {
    for (const double seconds : {0.5, 10.0, 60.0}) {
      Recording s;
      s.noise_a = noise, s.noise_b = 2 * noise, s.seconds = seconds, s.delay = 0.01;
      const Recorded rest = record([](double) { return dvec3(0.1); }, s, 5), moving = record(hand, s, 5);
      const DelayResult both = estimate_delay(rest.a, rest.b);
      EXPECT_TRUE(both.ambiguous);
      EXPECT_FALSE(both.rich);
      EXPECT_GT(both.sigma, 0.1);
      EXPECT_EQ(both.reason.find("no motion: both streams are at rest"), 0u)
          << noise << " " << seconds << " " << both.reason;
      EXPECT_EQ(estimate_delay(rest.a, moving.b).reason.find("no motion: stream A is at rest"), 0u);
      EXPECT_EQ(estimate_delay(moving.a, rest.b).reason.find("no motion: stream B is at rest"), 0u);
    }
  }
  // The motion is as small as the noise. If the recording is long enough, it is accepted as motion. The rest of the
  // result is not tested.
  Recording s;
  s.seconds = 60;
  const Recorded r =
      record([](double t) { return 2e-4 * dvec3(std::sin(9 * t + std::sin(t)), std::sin(7 * t), 0); }, s, 5);
  EXPECT_EQ(estimate_delay(r.a, r.b).reason.find("no motion"), std::string::npos);
}

TEST(DelayLaws, PeriodicMotionIsReportedWithAllPossibleDelays) {
  for (const double hertz : {1.0, 2.0, 5.0}) {
    for (const double noise : {0.0, 2e-4}) {
      Recording s;
      s.noise_a = s.noise_b = noise;
      const Recorded r = record([&](double t) { return 0.03 * dvec3(std::sin(2 * kPi * hertz * t), 0, 0); }, s, 6);
      const DelayResult d = estimate_delay(r.a, r.b);
      EXPECT_TRUE(d.ambiguous) << hertz << " " << noise;
      ASSERT_GE(d.candidates.size(), 3u);
      EXPECT_NEAR(d.delay, s.delay, 1e-3);
      EXPECT_NEAR(std::abs(d.candidates[1] - d.candidates[0]), 1 / hertz, 2e-3);
    }
  }
}

TEST(DelayLaws, LostFrozenAndOutlierSamplesDoNotDisturbTheDelay) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Recorded r = record(hand, {}, seed);
    Noise random(seed + 50);
    Stream a, b;
    for (std::size_t i = 0; i < r.a.t.size(); ++i) {
      if (random.uniform(0, 1) < 0.05 || (i > 300 && i < 340)) continue;  // lost
      a.t.push_back(r.a.t[i]), a.p.push_back(r.a.p[i]);
    }
    for (std::size_t i = 0; i < r.b.t.size(); ++i) {
      b.t.push_back(r.b.t[i]);
      b.p.push_back(i > 500 && i < 560 ? r.b.p[500] : r.b.p[i]);  // frozen
      if (random.uniform(0, 1) < 0.01) b.p.back() += random.normal3(0.05);
    }
    const DelayResult d = estimate_delay(a, b);
    EXPECT_FALSE(d.ambiguous);
    EXPECT_NEAR(d.delay, 0.0372, 4 * d.sigma) << seed;
    EXPECT_LT(d.sigma, 1.6 * bound(hand, {})) << seed;
    EXPECT_GE(d.frozen_b, 50);
    EXPECT_GE(d.lost_a, 60);
  }
}

TEST(DelayLaws, ClockSkewIsMeasured) {
  for (const double seconds : {30.0, 120.0}) {
    Recording s;
    s.skew = 1e-4, s.seconds = seconds;
    const Recorded r = record(hand, s, 7);
    const DelayResult d = estimate_delay(r.a, r.b);
    EXPECT_FALSE(d.ambiguous) << d.reason;
    EXPECT_NEAR(d.skew, 1e-4, 4 * d.skew_sigma);
    // At time t the delay is delay + skew t (to first order). So the value that was set holds at the start.
    EXPECT_NEAR(d.delay, s.delay + s.skew * d.reference_time, 4 * d.sigma) << seconds;
    EXPECT_NEAR(d.delay_at_end, s.delay + s.skew * seconds, 2e-4);
  }
}

TEST(DelayLaws, UnrelatedStreamsAreNotMatched) {
  const Recorded r = record(hand, {}, 8), other = record(drill, {}, 9);
  const DelayResult d = estimate_delay(r.a, other.b);
  EXPECT_TRUE(d.ambiguous || d.noise > 5e-3) << d.noise;
  EXPECT_FALSE(d.rich);
}

TEST(DelayLaws, BadStreamsAreErrors) {
  Recorded r = record(hand, {}, 8);
  Stream few = r.a;
  few.t.resize(10), few.p.resize(10);
  EXPECT_THROW(estimate_delay(few, r.b), Error);
  Stream back = r.a;
  back.t[50] = back.t[48];
  EXPECT_THROW(estimate_delay(back, r.b), Error);
  Stream later = r.a;
  for (double& t : later.t) t += 1000;
  EXPECT_THROW(estimate_delay(later, r.b), Error);
}

}  // namespace
}  // namespace typodont::calibration
