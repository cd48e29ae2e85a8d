// Tests the controller of a headset as a hand: no motion or loss of it may make the tool jump.
#include "engine/app/live/xr_hand.h"

#include <gtest/gtest.h>

#include "engine/base/error.h"
#include "engine/base/units.h"
#include "tests/support/folder.h"
#include "tests/support/no_alloc.h"

namespace typodont {
namespace {

constexpr double kTick = 1e-3;

XrHandSample at(dvec3 p, double pedal = 0) {
  return {{p, {1, 0, 0, 0}}, pedal, true, 0};
}

/// Runs the filter for `ticks` ticks. Returns the longest step (m) of the tool in one tick.
double run(XrHandFilter& filter, const XrHandSample& wanted, bool seen, int ticks, haptics::HandSample& last,
           dvec3 force = dvec3(0)) {
  double longest = 0;
  for (int i = 0; i < ticks; ++i) {
    const dvec3 before = last.X_WT.p;
    last = filter.next(wanted, seen, force, 0, kTick);
    longest = std::max(longest, glm::length(last.X_WT.p - before));
  }
  return longest;
}

TEST(XrHand, LosingTheControllerFreezesTheToolAndStopsTheDrill) {
  XrHandFilter filter({});
  haptics::HandSample last{};
  run(filter, at({0.01, 0, 0}, 0), true, 600, last);
  run(filter, at({0.01, 0, 0}, 1), true, 100, last);
  EXPECT_EQ(last.pedal, 1);
  const dvec3 held = last.X_WT.p;
  // If the controller is lost, the filter must ignore the pose that the runtime still reports.
  run(filter, {{dvec3(5, 5, 5), {1, 0, 0, 0}}, 1, false, 0}, false, 500, last);
  EXPECT_EQ(last.X_WT.p, held);
  EXPECT_EQ(last.pedal, 0);
  EXPECT_TRUE(filter.lost());
}

TEST(XrHand, AControllerThatReturnsElsewhereMovesTheToolThereWithoutAJump) {
  XrHandFilter filter({});
  haptics::HandSample last{};
  run(filter, at({0, 0, 0}), true, 600, last);
  run(filter, at({0, 0, 0}), false, 100, last);
  const double step = run(filter, at({0.2, 0, 0}), true, 1000, last);
  EXPECT_LT(step, 1e-3);  // 0.2 m in 0.4 s, no faster than 1.5 times its mean
  EXPECT_NEAR(last.X_WT.p.x, 0.2, 1e-6);
}

TEST(XrHand, ATriggerHeldDuringATrackingLossDrillsOnlyAfterItsRelease) {
  XrHandFilter filter({});
  haptics::HandSample last{};
  run(filter, at({}, 0), true, 600, last);
  run(filter, at({}, 1), false, 50, last);
  run(filter, at({}, 1), true, 2000, last);
  EXPECT_EQ(last.pedal, 0);
  run(filter, at({}, 0), true, 10, last);
  run(filter, at({}, 0.7), true, 10, last);
  EXPECT_DOUBLE_EQ(last.pedal, 0.7);
}

TEST(XrHand, ALostHandMovesBackUntilTheForceIsZero) {
  XrHandFilter filter({});
  haptics::HandSample last{};
  run(filter, at({0, 0, -2e-3}), true, 1500, last);
  // A wall at z = 0 with 1 N/mm pushes the tool back as long as the tool is in the wall.
  double force = 0, before = 1e9;
  for (int i = 0; i < 1000; ++i) {
    force = std::max(0.0, -last.X_WT.p.z) * 1000;
    EXPECT_LE(force, before + 1e-12);
    before = force;
    last = filter.next(at({}), false, {0, 0, force}, 0, kTick);
  }
  EXPECT_LT(force, 1e-3);
}

TEST(XrHand, NeverAllocates) {
  XrHandFilter filter({});
  haptics::HandSample last{};
  test::NoAlloc guard;
  for (int i = 0; i < 2000; ++i) last = filter.next(at({0.001 * i, 0, 0}), i % 300 < 200, {0, 0, 1}, 0, kTick);
  EXPECT_EQ(guard.count(), 0u);
  EXPECT_TRUE(is_finite(last.X_WT.p));
}

display::DisplayRig rig(const std::string& hmd) {
  return display::parse_rig(Json::parse("{\"display\": \"hmd\", \"hmd\": {" + hmd + "}}", "rig.json"));
}

TEST(HeadsetRig, MeasuredSpaceAndMagnificationExcludeEachOther) {
  EXPECT_DOUBLE_EQ(rig("\"magnify\": 4").hmd.magnify, 4);
  const std::string measured = R"("X_WD": {"translation_mm": [1, 2, 3], "rotation_wxyz": [1, 0, 0, 0]})";
  EXPECT_DOUBLE_EQ(rig(measured).hmd.X_WD->p.y, 2e-3);
  EXPECT_THROW(rig(measured + ", \"magnify\": 2"), Error);
  EXPECT_THROW(rig(measured + ", \"registration\": \"reg.json\""), Error);
  EXPECT_THROW(rig("\"space\": \"moon\""), Error);
  EXPECT_THROW(rig("\"wait\": 3"), Error);
}

TEST(HeadsetRig, UsesTheInverseOfTheRegistrationThatTheCalibrationFound) {
  const test::Folder folder;
  const std::string file = folder / "reg.json";
  write_file_atomically(file,
                        R"({"X_DH": {"translation_mm": [100, 0, 0], "rotation_wxyz": [0.70710678, 0, 0, 0.70710678]},
                                   "fre_rms_mm": 0.2})");
  const display::DisplayRig r = rig("\"registration\": \"" + file + "\"");
  const Pose X_DH{{0.1, 0, 0}, glm::normalize(dquat(1, 0, 0, 1))};
  // A point of the arm that the headset sees must be the same point in the workbench. (Here frame W is the arm's base.)
  const dvec3 p_H(0.01, 0.02, 0.03), p_W = *r.hmd.X_WD * (X_DH * p_H);
  EXPECT_LT(glm::length(p_W - p_H), 1e-9);
}

}  // namespace
}  // namespace typodont
