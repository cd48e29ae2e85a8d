// Tests an implant exercise tick by tick: phases, immediate messages, the bed compared with the plan, and heat.
#include <gtest/gtest.h>

#include <cmath>

#include "engine/base/units.h"
#include "engine/session/implant.h"

namespace typodont::session {
namespace {

constexpr double kTip = 6e-3;  // m from each tool's origin to its tip
enum Tools : std::uint32_t { kPilot, kGauge, kTwist, kImplant };

/// A bed of 10 mm straight down from the origin; a canal 13 mm below it, along x.
ImplantTask task() {
  ImplantTask t;
  t.plan = {{0, 0, 0}, {0, 0, -1}, 10e-3, 4e-3, 3e-3};
  const auto phase = [&](ImplantAction deed, std::uint32_t tool, double depth, double speed) {
    ImplantPhase p;
    p.deed = deed;
    p.tool = tool;
    p.depth = depth;
    p.speed = speed;
    t.phases.push_back(p);
  };
  phase(ImplantAction::kDrill, kPilot, 6e-3, 80);
  phase(ImplantAction::kCheck, kGauge, 6e-3, 0);
  phase(ImplantAction::kDrill, kPilot, 10e-3, 80);
  phase(ImplantAction::kDrill, kTwist, 10e-3, 60);
  phase(ImplantAction::kPlace, kImplant, 10e-3, 2);
  t.tip.assign(4, kTip);
  t.radius = {1.1e-3, 1.1e-3, 1.5e-3, 2e-3};
  t.max_force = 12;
  t.max_angle = 5 * kDegree;
  t.depth_tolerance = 0.5e-3;
  t.canal_clearance = 2e-3;
  t.canal_W = {{-20e-3, 0, -13e-3}, {20e-3, 0, -13e-3}};
  t.canal_radius = 1e-3;
  return t;
}

/// A hand that is controlled by the position of its tip.
struct Hand {
  ImplantMeter meter{task()};
  ServoTick tick;
  dquat R{1, 0, 0, 0};

  void at(const dvec3& tip_W, std::uint32_t tool, std::uint32_t level, double spindle = 0, double power = 0,
          double force = 1) {
    tick.t += 1'000'000;
    tick.tool = tool;
    tick.level = level;
    tick.spindle = spindle;
    tick.cutting_power = power;
    const bool free = level == implant_level::kFree || level == implant_level::kPlaced;
    tick.f_T_W = (free ? 0 : force) * (R * dvec3(0, 0, 1));
    tick.X_WG = {tip_W + R * dvec3(0, 0, kTip), R};
    meter.add({&tick, 1});
  }
  /// Moves along the tool's axis from one depth to another at 5 mm/s.
  void go(double from, double to, std::uint32_t tool, std::uint32_t level, double spindle = 0, double power = 0) {
    const int steps = std::max(1, static_cast<int>(std::ceil(std::abs(to - from) / 5e-6)));
    for (int i = 0; i <= steps; ++i)
      at(R * dvec3(0, 0, -(from + (to - from) * i / steps)), tool, level, spindle, power);
  }
  void drill(double from, double to, std::uint32_t tool = kPilot) {
    go(from, to, tool, implant_level::kDrilling, 70, 0.1);
    go(to, 0, tool, implant_level::kSliding);
    at({0, 0, 8e-3}, tool, implant_level::kFree);
  }
  /// Moves the gauge to the bottom of the bed.
  void check(double depth) {
    go(0, depth, kGauge, implant_level::kSliding);
    for (int i = 0; i < 400; ++i) at(R * dvec3(0, 0, -depth), kGauge, implant_level::kSliding);
    go(depth, 0, kGauge, implant_level::kSliding);
  }
};

TEST(ImplantMeter, PhasesAreCompletedInOrder) {
  Hand hand;
  hand.drill(0, 6e-3);
  EXPECT_EQ(hand.meter.phase(), 1u);
  hand.check(6e-3);
  EXPECT_EQ(hand.meter.phase(), 2u);
  hand.drill(6e-3, 10e-3);
  hand.drill(0, 10e-3, kTwist);
  EXPECT_EQ(hand.meter.phase(), 4u);
  hand.go(0, 9.9e-3, kImplant, implant_level::kScrewing, 2);
  EXPECT_EQ(hand.meter.phase(), 4u) << "it is not yet in its place";
  hand.at({0, 0, -9.9e-3}, kImplant, implant_level::kPlaced);
  const ImplantMeasures m = hand.meter.result();
  EXPECT_EQ(m.phases_done(), 1);
  EXPECT_TRUE(m.placed);
  for (const ImplantPhaseMeasures& phase : m.phases) EXPECT_FALSE(phase.skipped);
}

TEST(ImplantMeter, WorkWithTheToolOfALaterPhaseSkipsToIt) {
  Hand hand;
  hand.drill(0, 6e-3);
  hand.go(6e-3, 7e-3, kPilot, implant_level::kDrilling, 70, 0.1);  // 0.2 s: perhaps a mistake
  EXPECT_EQ(hand.meter.phase(), 1u);
  EXPECT_EQ(hand.meter.note(), ImplantNote::kWrongTool);
  for (int i = 0; i < 2000; ++i) hand.at({0, 0, -7e-3 - 1e-6 * i}, kPilot, implant_level::kDrilling, 70, 0.1);
  EXPECT_EQ(hand.meter.phase(), 2u);
  EXPECT_TRUE(hand.meter.result().phases[1].skipped);
  EXPECT_EQ(hand.meter.note(), ImplantNote::kNone);
}

TEST(ImplantMeter, AnErrorIsReportedInTheSameTick) {
  constexpr std::uint32_t kDrilling = implant_level::kDrilling;
  const auto note_at = [](auto&& deed) {
    Hand hand;
    deed(hand);
    return hand.meter.note();
  };
  EXPECT_EQ(note_at([](Hand& h) { h.go(0, 3e-3, kPilot, kDrilling, 70, 0.1); }), ImplantNote::kNone);
  EXPECT_EQ(note_at([](Hand& h) { h.go(0, 3e-3, kTwist, kDrilling, 70, 0.1); }), ImplantNote::kWrongTool);
  EXPECT_EQ(note_at([](Hand& h) { h.at({0, 0, -3e-3}, kPilot, kDrilling, 100, 0.1); }), ImplantNote::kOverSpeed);
  EXPECT_EQ(note_at([](Hand& h) { h.at({0, 0, -3e-3}, kPilot, kDrilling, 70, 0.1, 13); }), ImplantNote::kOverForce);
  EXPECT_EQ(note_at([](Hand& h) {
              h.R = glm::angleAxis(6 * kDegree, dvec3(1, 0, 0));
              h.at({0, 0, -3e-3}, kPilot, kDrilling, 70, 0.1);
            }),
            ImplantNote::kOffAxis);
  // The phase ends at 10 mm. A depth of 0.6 mm more is reported immediately, while the drill of this phase is still in
  // the hand.
  EXPECT_EQ(note_at([](Hand& h) {
              h.drill(0, 6e-3);
              h.check(6e-3);
              h.at({0, 0, -10.6e-3}, kPilot, kDrilling, 70, 0.1);
            }),
            ImplantNote::kTooDeep);
  EXPECT_EQ(note_at([](Hand& h) { h.at({0, 0, -10.2e-3}, kTwist, kDrilling, 70, 0); }), ImplantNote::kNearCanal);
  EXPECT_EQ(note_at([](Hand& h) {
              for (int i = 0; i < 3000; ++i) h.at({0, 0, -3e-3}, kPilot, kDrilling, 70, 1);
            }),
            ImplantNote::kHeat);
}

TEST(ImplantMeter, TheBedIsComparedWithThePlanAsTheDrillWent) {
  // 3 degrees about x, through a point 1 mm beside the entry.
  Hand hand;
  hand.R = glm::angleAxis(3 * kDegree, dvec3(1, 0, 0));
  const dvec3 axis = hand.R * dvec3(0, 0, -1), entry(1e-3, 0, 0);
  for (int i = 0; i <= 2000; ++i) hand.at(entry + axis * (10e-3 * i / 2000), kPilot, implant_level::kDrilling, 70, 0.1);
  const ImplantBedMeasures bed = hand.meter.result().bed;
  ASSERT_TRUE(bed.found);
  const dvec3 bottom = entry + 10e-3 * axis;
  EXPECT_NEAR(bed.axis_error, 3 * kDegree, 1e-6);
  EXPECT_NEAR(bed.entry_error, 1e-3, 1e-6);
  EXPECT_NEAR(bed.apex_error, glm::length(bottom - dvec3(0, 0, -10e-3)), 1e-6);
  EXPECT_NEAR(bed.depth, -bottom.z, 1e-6);
}

TEST(ImplantMeter, TheDistanceToTheCanalIsMeasuredFromWallAndBottomOfTheBed) {
  // The canal runs along x, 13 mm below the entry, and has a radius of 1 mm; the pilot's is 1.1 mm.
  for (const double aside : {0.5e-3, 3e-3}) {
    Hand hand;
    for (int i = 0; i <= 2000; ++i) hand.at({0, aside, -10e-3 * i / 2000}, kPilot, implant_level::kDrilling, 70, 0.1);
    const double beside = std::max(0.0, aside - 1.1e-3);
    EXPECT_NEAR(hand.meter.result().bed.canal_distance, std::hypot(beside, 3e-3) - 1e-3, 2e-6);
  }
}

TEST(ImplantMeter, TheBoneWarmsAndCoolsAsTheModelSays) {
  Hand hand;
  constexpr double kPower = 0.2, kDepth = 6e-3, r = 1.1e-3, s = HeatModel::shell;
  for (int i = 0; i < 1001; ++i) hand.at({0, 0, -kDepth}, kPilot, implant_level::kDrilling, 70, kPower);
  const double mass = kPi * ((r + s) * (r + s) - r * r) * kDepth * HeatModel::heat_capacity;  // J/K
  // The temperature approaches power × time constant / heat capacity exponentially. The test lasts one second, in which
  // the phase is dry.
  const double steady = HeatModel::fraction * kPower * HeatModel::dry_time / mass;
  EXPECT_NEAR(hand.meter.temperature() - HeatModel::body, steady * (1 - std::exp(-1 / HeatModel::dry_time)), 0.02);
  const double hot = hand.meter.temperature();
  for (int i = 0; i < 3000; ++i) hand.at({0, 0, 8e-3}, kPilot, implant_level::kFree);
  EXPECT_NEAR(hand.meter.temperature() - HeatModel::body, (hot - HeatModel::body) * std::exp(-3 / HeatModel::dry_time),
              1e-6);
}

TEST(ImplantMeter, AForceCurveKeepsItsMeanForAnyLengthOfThePhase) {
  for (const int ticks : {300, 30'000}) {
    Hand hand;
    for (int i = 0; i < ticks; ++i)
      hand.at({0, 0, -3e-3}, kPilot, implant_level::kDrilling, 70, 0, i < ticks / 2 ? 2 : 4);
    const ForceCurve curve = hand.meter.result().phases[0].force;
    ASSERT_GE(curve.along.size(), 20u);
    EXPECT_LE(curve.along.size(), 400u);
    EXPECT_NEAR(curve.span * static_cast<double>(curve.along.size()), 1e-3 * ticks, 2 * curve.span);
    EXPECT_NEAR(curve.along.front(), -2, 1e-5) << "the bone pushes against the plan's axis";
    EXPECT_NEAR(curve.along.back(), -4, 1e-5);
  }
}

}  // namespace
}  // namespace typodont::session
