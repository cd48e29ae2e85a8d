// Tests hands that push every shipped tool that cuts or scrapes with a constant force into the molar with caries.
// From the first touch on, the force on the hand must change in each tick at 1 kHz by less than 0.02 N, or by less than
// the effect of the hand's own displacement in this tick on the coupling's spring. ./run stress makes the test long;
// bench_push measures 2,000 hands.
#include "tests/support/constant_push.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/campaign.h"

namespace typodont::test {
namespace {

void expect_no_step_beyond_the_hands_motion(ToolKind kind, int hands) {
  const auto tools = tools_of(kind);
  const haptics::TissueVolume tissue = pushed_tissue();
  // number of hands that never had to be led out of tissue. (Leading out may give energy to the hand, so the test
  // cannot check the energy of the other hands.)
  int audited = 0;
  for (std::uint32_t seed = 0; seed < static_cast<std::uint32_t>(campaign(hands)); ++seed) {
    const PushHand hand = random_push(tools, seed);
    const PushResult felt = simulate_push(hand, tissue);
    if (felt.begins_inside) continue;
    const ForceStep& step = felt.any.beyond_spring;
    EXPECT_EQ(felt.any.over, 0) << text_of(hand) << ", seed " << seed << ": " << step.size << " N at " << step.t
                                << " s, the hand at " << 1e3 * step.speed << " mm/s";
    if ((felt.faults & bits(Fault::kDeepPenetration)) == 0) {
      EXPECT_GE(felt.min_energy, -1e-9) << text_of(hand) << ", seed " << seed;
      ++audited;
    }
  }
  EXPECT_GT(audited, 5);
}

TEST(ConstantPush, ARotatingToolGivesNoForceStepBeyondThatOfTheHandsMotion) {
  expect_no_step_beyond_the_hands_motion(ToolKind::kTurns, 24);
}
TEST(ConstantPush, AScrapingToolGivesNoForceStepBeyondThatOfTheHandsMotion) {
  expect_no_step_beyond_the_hands_motion(ToolKind::kScrapes, 15);
}

TEST(ConstantPush, AnExplorerThatSticksInCariesStaysOutsideSoundTissueAndGivesNoForceStepWhereItSticksOrComesOut) {
  const haptics::TissueVolume tissue = pushed_tissue();
  for (std::uint32_t seed = 0; seed < 10; ++seed) {
    const PushHand hand = random_push({"explorer"}, seed);
    const PushResult felt = simulate_push(hand, tissue);
    if (felt.begins_inside) continue;
    EXPECT_EQ(felt.faults & bits(Fault::kDeepPenetration), 0u) << text_of(hand) << ", seed " << seed;
    // During landing, the damper and the passivity controller change the force.
    EXPECT_LT(felt.any.over, 1.5) << text_of(hand) << ", seed " << seed;
    EXPECT_LT(felt.after_landing.over, 0.25) << text_of(hand) << ", seed " << seed;
  }
}

/// An implant drill that meets the tooth at 74 mm/s, 2 ms before its pedal is pressed, and bounces (a recorded hand).
TEST(ConstantPush, AnImplantDrillThatBouncesLandsWithoutAForceStep) {
  PushHand hand{"implant_drill_035", "air_turbine", 0.3869166760885232, {}};
  for (int i = 0; i <= 100; ++i) {
    haptics::HandPath::Row row;
    row.t = 0.01 * i;
    row.X_WT = {{7.496423754655182e-3 - 3.94e-3 * row.t, 5.512864598454644e-3 - 0.086e-3 * row.t, 31e-3},
                {0.9763047122178038, 0.21635951047371335, 0.00420370418635358, 0}};
    row.pedal = row.t > 0.105 ? 1 : 0;
    hand.path.rows.push_back(row);
  }
  const haptics::TissueVolume tissue = pushed_tissue();
  const PushResult felt = simulate_push(hand, tissue);
  // As long as the drill does not turn, the tissue is a wall, which the hand feels from the first tick on.
  EXPECT_LT(felt.any.beyond_spring.t, 0.11) << felt.any.beyond_spring.size << " N";
}

}  // namespace
}  // namespace typodont::test
