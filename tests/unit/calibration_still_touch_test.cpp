#include <gtest/gtest.h>

#include <limits>

#include "calibration/statistics.h"
#include "calibration/still_touch.h"

namespace typodont::calibration {
namespace {

using Verdict = StillTouch::Verdict;
constexpr Nanos kTick = 1'000'000;

TEST(StillTouch, AveragesTheTenthOfASecondBeforeThePress) {
  StillTouch still({});
  Noise random(3);
  dvec3 sum(0);
  Nanos t = 0;
  for (int i = 0; i < 300; ++i, t += kTick) {
    const dvec3 p = dvec3(0.1, -0.2, 0.3) + random.normal3(5e-5);
    const bool last = i == 299;
    if (i >= 199) sum += p;
    EXPECT_EQ(still.add(t, p, last ? 1 : 0, false), last ? Verdict::kTaken : Verdict::kNone);
  }
  EXPECT_LT(glm::length(still.point() - sum / 101.0), 1e-15);
}

TEST(StillTouch, AveragesJointAnglesWhereEverySampleHasSix) {
  StillTouch still({});
  Nanos t = 0;
  std::array<double, 6> joints{};
  for (int i = 0; i < 300; ++i, t += kTick) {
    for (std::size_t k = 0; k < 6; ++k) joints[k] = 0.1 * static_cast<double>(k) + (i % 2 ? 1e-4 : -1e-4);
    still.add(t, dvec3(0), 0, false, joints);
  }
  ASSERT_EQ(still.add(t, dvec3(0), 0, true, joints), Verdict::kTaken);
  ASSERT_TRUE(still.has_joints());
  for (std::size_t k = 0; k < 6; ++k) EXPECT_NEAR(still.joints()[k], 0.1 * static_cast<double>(k), 1e-5);
  ASSERT_EQ(still.add(t + kTick, dvec3(0), 0, true, std::span(joints).first(3)), Verdict::kTaken);
  EXPECT_FALSE(still.has_joints());
}

TEST(StillTouch, RefusesAMovingTipAndReportsItsMotion) {
  StillTouch still({});
  Nanos t = 0;
  for (int i = 0; i < 200; ++i, t += kTick) still.add(t, dvec3(0.02 * to_seconds(t), 0, 0), 0, false);  // 20 mm/s
  EXPECT_EQ(still.add(t, dvec3(0.02 * to_seconds(t), 0, 0), 0, true), Verdict::kMoved);
  EXPECT_NEAR(still.moved(), 1e-3, 1e-9);
}

TEST(StillTouch, APressOfThePedalGivesOneTouch) {
  StillTouch still({});
  int taken = 0;
  for (int i = 0; i < 2000; ++i) {
    const double pedal = i < 200 ? 1 : i % 500 < 250 ? 0 : i % 2 ? 0.45 : 1;  // held at first, bouncing later
    taken += still.add(i * kTick, dvec3(0), pedal, false) == Verdict::kTaken;
  }
  EXPECT_EQ(taken, 4);
}

TEST(StillTouch, AGapOrAClockThatJumpsBackClearsTheWindow) {
  StillTouch still({});
  Nanos t = 0;
  for (; t < 200 * kTick; t += kTick) still.add(t, dvec3(0), 0, false);
  EXPECT_EQ(still.add(t, dvec3(std::numeric_limits<double>::quiet_NaN()), 0, true), Verdict::kTooSoon);
  for (t = 0; t < 99 * kTick; t += kTick) still.add(t, dvec3(0), 0, false);
  EXPECT_EQ(still.add(t, dvec3(0), 0, true), Verdict::kTooSoon);
  EXPECT_EQ(still.add(t + kTick, dvec3(0), 0, true), Verdict::kTaken);
  EXPECT_EQ(still.add(t + 1000 * kTick, dvec3(0), 0, true), Verdict::kTooSoon) << "one sample after a silence";
}

}  // namespace
}  // namespace typodont::calibration
