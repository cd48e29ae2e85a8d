#include <gtest/gtest.h>

#include "engine/base/units.h"
#include "engine/base/voxels.h"
#include "engine/session/score.h"
#include "tests/support/cavity_fixture.h"

namespace typodont::session {
namespace {

using namespace test;

/// A block with two lesions in its top, 2 mm to either side of the middle, and one deep inside that cannot be found.
struct Tooth {
  Preparation block = a_block();
  Tooth() {
    for (const auto& lesion : {ball(kMiddle + dvec3(2e-3, 0, 0), 0.5e-3), ball(kMiddle - dvec3(2e-3, 0, 0), 0.5e-3),
                               ball(kMiddle - dvec3(0, 0, 1.5e-3), 0.4e-3)}) {
      for_each_voxel(kBlock, [&](int x, int y, int z) {
        if (lesion(kVoxel * dvec3(x, y, z)) < 0) block.tissue[block.before.at(x, y, z)] = Tissue::kCaries;
      });
    }
  }
  ExploreMeter meter() const { return {block.frame, block.before, block.tissue, {}}; }
};

ServoTick at(const dvec3& p, bool pedal, bool contact = true) {
  ServoTick t;
  t.X_WT.p = t.X_WG.p = p;
  t.pedal = pedal ? 1 : 0;
  t.depth = contact ? 1e-5 : 0;
  return t;
}

TEST(ExploreMeter, FindsTheLesionsThatWereMarkedAndCountsMarksOnSoundTissue) {
  const Tooth tooth;
  ExploreMeter meter = tooth.meter();
  EXPECT_EQ(meter.result().lesions, 2);  // the one below the surface is none to be found
  const std::vector<ServoTick> ticks = {at(kMiddle + dvec3(2e-3, 0, 0), true),
                                        at(kMiddle + dvec3(2e-3, 0, 0), true),  // held down: one mark
                                        at(kMiddle, false),
                                        at(kMiddle, true),  // sound
                                        at(kMiddle - dvec3(2e-3, 0, 0), false, false),
                                        at(kMiddle - dvec3(2e-3, 0, 0), true, false)};  // in the air: none
  meter.add(ticks);
  const ExploreMeasures m = meter.result();
  EXPECT_EQ(m.found, 1);
  EXPECT_EQ(m.false_finds, 1);
}

TEST(ExploreMeter, ExploredIsTheFractionOfTheSurfaceNearTheTipsPath) {
  const Tooth tooth;
  ExploreMeter meter = tooth.meter();
  EXPECT_EQ(meter.result().explored, 0);
  std::vector<ServoTick> ticks;
  for (double x = 0; x <= 8e-3; x += 0.1e-3) ticks.push_back(at({x, 4e-3, kTop}, false));
  meter.add(ticks);
  EXPECT_NEAR(meter.result().explored, 1.5 / 8.1, 0.01);  // a strip of 1.5 mm across the block
  for (double y = 0; y <= 8e-3; y += 1e-3) {
    for (double x = 0; x <= 8e-3; x += 0.1e-3) meter.add(std::vector{at({x, y, kTop}, false)});
  }
  EXPECT_EQ(meter.result().explored, 1);
}

// The axis is tilted: depth counts along the axis, not along z.
TEST(ExploreMeter, AReadingIsTheTipsDepthBelowTheMarginOfTheNearestSiteAndTheLastOneCounts) {
  const dvec3 up = glm::normalize(dvec3(0.3, -0.2, 1)), beside(3e-3, 0, 0);
  constexpr double kRadius = 0.25e-3;
  const std::vector<ProbeSite> sites = {{kMiddle, kMiddle - 5e-3 * up},
                                        {kMiddle + beside, kMiddle + beside - 2e-3 * up}};
  ExploreMeter meter(sites, up, kRadius);
  const auto press = [&](const dvec3& tip, double force, bool contact = true) {
    ServoTick down = at(tip + kRadius * up, true, contact), free = at(tip + kRadius * up, false, contact);
    down.f_T_W = free.f_T_W = force * up;
    meter.add(std::vector{free, down, down, free});
  };
  press(kMiddle - 3e-3 * up, 0.1);
  press(kMiddle - 4.4e-3 * up, 0.2);                // replaces the first reading
  press(kMiddle + beside - 2e-3 * up, 0.5, false);  // without contact: none
  press(kMiddle + beside + 1e-3 * up, 0.9);         // above the margin: none
  press(kMiddle + 3.0 * beside - 2e-3 * up, 0.9);   // beside every site: none
  ExploreMeasures m = meter.result();
  ASSERT_EQ(m.sites.size(), 2u);
  EXPECT_NEAR(m.sites[0].depth, 5e-3, 1e-12);
  EXPECT_NEAR(m.sites[0].reading, 4.4e-3, 1e-12);
  EXPECT_NEAR(m.sites[0].force, 0.2, 1e-12);
  EXPECT_LT(m.sites[1].reading, 0);
  EXPECT_EQ(m.sites_read(), 1);
  EXPECT_NEAR(m.probing_force, 0.2, 1e-12);
  ScoreInput in;
  in.explore = m;
  const Score half = score(in, default_rules(in));
  EXPECT_EQ(half.completion, 0.5);
  press(kMiddle + beside - 0.9e-3 * up, 0.25);  // 1.1 mm off
  in.explore = m = meter.result();
  EXPECT_EQ(m.sites_within(1e-3), 1);
  const Score wrong = score(in, default_rules(in));
  EXPECT_EQ(wrong.completion, 1);
  EXPECT_GT(wrong.points, half.points);
  press(kMiddle + beside - 1.1e-3 * up, 0.25);
  in.explore = meter.result();
  const Score right = score(in, default_rules(in));
  EXPECT_DOUBLE_EQ(right.points, right.full);
  press(kMiddle + beside - 2e-3 * up, 0.7);
  in.explore = meter.result();
  EXPECT_LT(score(in, default_rules(in)).points, 0.85 * right.points) << "tissue would be pierced";
}

TEST(ExploreMeter, DoingNothingScoresNothingAndFindingAllScoresFull) {
  ScoreInput in;
  in.before[2] = in.after[2] = 100e-9;
  in.before[3] = in.after[3] = 1e-9;
  in.explore = ExploreMeasures{2, 0, 0, 0};
  EXPECT_EQ(score(in, default_rules(in)).points, 0);
  in.explore = ExploreMeasures{2, 2, 0, 1};
  const Score best = score(in, default_rules(in));
  EXPECT_DOUBLE_EQ(best.points, best.full);
  double last = best.points;
  for (const ExploreMeasures& worse :
       {ExploreMeasures{2, 2, 0, 0.8}, ExploreMeasures{2, 2, 1, 0.8}, ExploreMeasures{2, 1, 1, 0.8}}) {
    in.explore = worse;
    const double points = score(in, default_rules(in)).points;
    EXPECT_LT(points, last);
    last = points;
  }
}

TEST(ExploreMeter, AnExplorerMayPressAsDentistsPressAndHalfThePointsRemainOneStandardDeviationAbove) {
  ScoreInput in;
  in.before[2] = in.after[2] = 100e-9;
  in.before[3] = in.after[3] = 1e-9;
  in.explore = ExploreMeasures{2, 2, 0, 1};
  const double full = score(in, default_rules(in)).points;
  in.hand.force_mean = 3.33;
  EXPECT_DOUBLE_EQ(score(in, default_rules(in)).points, full);
  in.hand.force_mean = 3.33 + 2.14;
  const double lost = full - score(in, default_rules(in)).points;
  in.hand.force_mean = 100;
  EXPECT_NEAR(lost / (full - score(in, default_rules(in)).points), 0.5, 0.02);
}

}  // namespace
}  // namespace typodont::session
