// Hands no human has: whatever comes in, what goes out is finite, bounded and explained.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "engine/base/units.h"
#include "tests/support/campaign.h"
#include "tests/support/haptic_bench.h"

namespace typodont {
namespace {

using namespace literals;
using haptics::HeadShape;
using haptics::ServoSettings;
using test::campaign;
using test::HapticBench;

constexpr const char* kTooth = R"({"voxel_mm": 0.2, "solids": [
  {"tissue": "enamel", "solid": {"difference": [{"sphere": {"radius_mm": 4}}, {"cylinder": {"radius_mm": 0.8, "height_mm": 20}}]}},
  {"tissue": "dentin", "solid": {"difference": [{"sphere": {"radius_mm": 3}}, {"cylinder": {"radius_mm": 0.8, "height_mm": 20}}]}}]})";

void torment(HeadShape shape, double diameter, double length, int ticks, std::uint32_t seed) {
  ServoSettings s;
  s.tool.shape = shape;
  s.tool.diameter = diameter;
  s.tool.length = length;
  s.spindle.free_speed = 300.0_krpm;
  s.force_limit = 8;
  HapticBench bench(kTooth, s);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto anywhere = [&](double size) { return size * dvec3(uniform(random), uniform(random), uniform(random)); };
  dvec3 p(0, 0, 7.0_mm), velocity(0);
  dquat R(1, 0, 0, 0);
  PerTissue removed{};
  std::uint64_t cuts = 0;
  int bad = 0;
  for (int i = 0; i < ticks; ++i) {
    Pose X{p, R};
    double pedal = uniform(random);
    const double dice = uniform(random);
    if (dice > 0.999) {
      p = anywhere(8.0_mm);  // a leap
    } else if (dice > 0.998) {
      X.p = {std::numeric_limits<double>::quiet_NaN(), 0, 0};
    } else if (dice > 0.997) {
      X.p = dvec3(std::numeric_limits<double>::infinity());
    } else if (dice > 0.996) {
      X.R = dquat(0, 0, 0, 0);
    } else if (dice > 0.995) {
      X.p = anywhere(1e30);
    } else if (dice > 0.994) {
      pedal = std::numeric_limits<double>::quiet_NaN();
    } else if (dice > 0.993) {
      bench.t -= 5'000'000;  // the clock goes back
    } else if (dice > 0.992) {
      bench.t += 3'000'000'000;
    } else {
      velocity += anywhere(2e-3) - 0.01 * velocity - 5e-3 * p;
      p += velocity * 1e-3;
      R = glm::normalize(R * dquat(1, uniform(random) * 0.02, uniform(random) * 0.02, uniform(random) * 0.02));
    }
    if (glm::length(p) > 20.0_mm) p = anywhere(6.0_mm);
    const ServoTick& tick = bench.tick(X, pedal);
    ASSERT_TRUE(is_finite(tick.f_T_W) && is_finite(tick.tau_T_W) && is_finite(tick.X_WG.p)) << i;
    ASSERT_TRUE(std::isfinite(tick.energy) && std::isfinite(tick.depth) && std::isfinite(tick.contact_area)) << i;
    ASSERT_LE(glm::length(tick.f_T_W), 8 * (1 + 1e-9)) << i;
    ASSERT_LE(glm::length(tick.tau_T_W), 0.5 * (1 + 1e-9)) << i;
    ASSERT_GE(tick.cuts, cuts);
    cuts = tick.cuts;
    for (std::size_t t = 0; t < removed.size(); ++t) {
      ASSERT_GE(tick.removed[t], removed[t] - 1e-18) << i;
      removed[t] = tick.removed[t];
    }
    if (tick.faults & bits(Fault::kBadInput)) {
      ++bad;
      ASSERT_EQ(tick.f_T_W, dvec3(0)) << i;
    }
  }
  EXPECT_GT(bad, ticks / 1000);
  EXPECT_GT(cuts, 100u);
}

TEST(HostileHand, ARoundBurNeverAnswersWithNonsense) { torment(HeadShape::kSphere, 1.2_mm, 1.2_mm, campaign(60000), 1); }
TEST(HostileHand, AFlameNeverAnswersWithNonsense) { torment(HeadShape::kFlame, 1.2_mm, 4.0_mm, campaign(8000), 2); }
TEST(HostileHand, ACylinderNeverAnswersWithNonsense) { torment(HeadShape::kCylinder, 1.0_mm, 3.0_mm, campaign(8000), 3); }
TEST(HostileHand, AConeNeverAnswersWithNonsense) { torment(HeadShape::kCone, 1.6_mm, 3.0_mm, campaign(8000), 4); }
TEST(HostileHand, APearNeverAnswersWithNonsense) { torment(HeadShape::kPear, 1.2_mm, 2.2_mm, campaign(8000), 5); }
TEST(HostileHand, AnInvertedConeNeverAnswersWithNonsense) { torment(HeadShape::kInvertedCone, 1.2_mm, 1.1_mm, campaign(8000), 6); }

}  // namespace
}  // namespace typodont
