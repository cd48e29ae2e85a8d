// The contact model "packing" behind the seam: servo and carver in lock-step.
#include "haptics/contact/packing/packing_model.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>

#include "engine/base/error.h"
#include "engine/base/units.h"
#include "haptics/contact/packing/packing_body.h"
#include "haptics/contact_method.h"
#include "haptics/lockstep.h"
#include "haptics/solid.h"
#include "tests/support/no_alloc.h"

namespace typodont::haptics {
namespace {

using namespace literals;

constexpr double kBall = 3.0_mm, kHead = 0.6_mm;

TissueVolume ball() {
  return TissueVolume(read_solids(Json::parse(
      R"({"voxel_mm": 0.1, "solids": [{"tissue": "dentin", "solid": {"sphere": {"radius_mm": 3}}}]})", "t")));
}
ServoSettings settings(const char* method, bool cuts = true) {
  ServoSettings s;
  s.tool.diameter = s.tool.length = 2 * kHead;
  s.tool.cuts = cuts;
  s.spindle.free_speed = 300.0_krpm;
  s.damping = 0;
  s.friction = false;
  for (Material& m : s.materials) m.stiffness = 1000;
  s.method = read_contact_method(Json::parse(method, "model"));
  return s;
}
constexpr const char* kPacking = R"({"packing": {"spheres": 6000}})";

struct Session {
  LockStep steps;
  ServoTick tick;
  Cut cut;
  Nanos t = 0;
  explicit Session(const ServoSettings& s) : steps(ball(), s) {}
  bool step(const dvec3& p, double pedal = 0) {
    HandSample hand;
    hand.t = t += 1'000'000;
    hand.X_WT.p = p;
    hand.pedal = pedal;
    return steps.tick(hand, tick, cut);
  }
};
double removed(const ServoTick& tick) {
  double sum = 0;
  for (const double v : tick.removed) sum += v;
  return sum;
}
/// Down onto the ball from above, to `deep` below its top, then round by up to `turn` rad.
dvec3 pressing(int tick, double deep, double turn = 0) {
  const double down = std::min(tick / 200.0, 1.0), angle = turn * std::max(0, tick - 200) / 1000.0;
  return (kBall + kHead + 0.3_mm - down * (0.3_mm + deep)) * dvec3(std::sin(angle), 0, std::cos(angle));
}

TEST(PackingModel, OnABallTheForcePointsOutAndIsTheSprings) {
  Session run(settings(kPacking, false));
  double worst = 0;
  for (int i = 0; i < 1200; ++i) {
    run.step(pressing(i, 0.4_mm, 1.0));
    if (i < 260) continue;
    ASSERT_GT(run.tick.depth, 0.2_mm) << i;
    const dvec3 out = glm::normalize(run.tick.X_WT.p);
    worst = std::max(worst, glm::length(glm::cross(glm::normalize(run.tick.f_T_W), out)));
    ASSERT_NEAR(glm::length(run.tick.f_T_W), 0.4, 0.1) << i;
  }
  EXPECT_LT(worst, std::sin(25.0_deg));  // the surface is bumpy: spheres of a quarter of a millimetre
}

TEST(PackingModel, FarFromTheTissueThereIsNoForce) {
  Session run(settings(kPacking));
  for (int i = 0; i < 100; ++i) run.step(dvec3(0, 0, 8.0_mm - i * 0.01_mm), 1);
  EXPECT_EQ(run.tick.f_T_W, dvec3(0));
  EXPECT_EQ(run.tick.faults, 0u);
}

TEST(PackingModel, ATurningBurSinksWhereTheHandPressesItAndRemovesWhatASweepOfItsWayHolds) {
  Session run(settings(R"({"packing": {"spheres": 36000, "speed_mm_per_s": 1}})"));
  for (int i = 0; i < 1500; ++i) run.step(pressing(i, 0.8_mm), 1);
  // The lens of head and ball down to where the head came.
  const double sunk = kBall + kHead - run.tick.X_WG.p.z;
  EXPECT_GT(sunk, 0.6_mm);
  EXPECT_NEAR(removed(run.tick) / packing::lens_volume(kBall, kHead, kBall + kHead - sunk), 1, 0.1);
}

TEST(PackingModel, AsPrintedTheSameWayRemovesMore) {
  double taken[2];
  for (const bool printed : {false, true}) {
    Session run(settings(printed ? R"({"packing": {"spheres": 6000, "as_printed": true}})" : kPacking));
    for (int i = 0; i < 600; ++i) run.step(pressing(i, 0.3_mm), 1);
    taken[printed] = removed(run.tick);
  }
  EXPECT_GT(taken[1], 1.2 * taken[0]);
}

TEST(PackingModel, DenserTissueIsCutSlowerByTheRatioOfTheDensities) {
  double sunk[2];
  for (const bool dense : {false, true}) {
    Session run(settings(dense ? R"({"packing": {"spheres": 6000, "density": {"dentin": 2}}})"
                               : R"({"packing": {"spheres": 6000, "density": {"dentin": 1}}})"));
    for (int i = 0; i < 200; ++i) run.step(pressing(i, 1.5_mm), 0);  // pressed on, standing
    const double from = run.tick.X_WG.p.z;
    for (int i = 200; i < 700; ++i) run.step(pressing(i, 1.5_mm), 1);
    sunk[dense] = from - run.tick.X_WG.p.z;
  }
  EXPECT_NEAR(sunk[0] / sunk[1], 2, 0.15);
}

TEST(PackingModel, ServoAndCarverHoldTheSameSpheresBitForBit) {
  Session run(settings(kPacking));
  for (int i = 0; i < 1200; ++i) run.step(pressing(i, 0.6_mm, 0.8), 1);
  ASSERT_GT(run.tick.cuts, 300u);
  const auto& servo = static_cast<const packing::PackingSnapshot&>(run.steps.servo().snapshot()).spheres;
  const auto snapshot = run.steps.carver().make_snapshot();
  const auto& carver = static_cast<const packing::PackingSnapshot&>(*snapshot).spheres;
  ASSERT_EQ(servo.size(), carver.size());
  for (int i = 0; i < static_cast<int>(servo.size()); ++i) ASSERT_EQ(servo.sphere(i), carver.sphere(i)) << i;
}

TEST(PackingModel, UndoBringsEverySphereBackAndRedoTakesItAgain) {
  Session run(settings(kPacking));
  const double field_before = run.steps.carver().volume().volumes()[static_cast<std::size_t>(Tissue::kDentin)];
  for (int i = 0; i < 800; ++i) run.step(pressing(i, 0.6_mm), 1);
  const double first = removed(run.tick);
  ASSERT_GT(first, 0.05_mm3);
  const auto state = [&] { return run.steps.carver().volume().volumes()[static_cast<std::size_t>(Tissue::kDentin)]; };
  const double cut = state();
  EXPECT_LT(cut, field_before);
  for (int i = 0; i < 50; ++i) run.step(dvec3(0, 0, 6.0_mm));
  ASSERT_TRUE(run.steps.carver().undo());
  EXPECT_FALSE(run.steps.carver().undo());
  for (int i = 0; i < 50; ++i) run.step(dvec3(0, 0, 6.0_mm));
  EXPECT_NEAR(removed(run.tick), 0, 1e-9 * first);
  EXPECT_DOUBLE_EQ(state(), field_before);
  ASSERT_TRUE(run.steps.carver().redo());
  for (int i = 0; i < 50; ++i) run.step(dvec3(0, 0, 6.0_mm));
  EXPECT_NEAR(removed(run.tick), first, 1e-9 * first);
  EXPECT_DOUBLE_EQ(state(), cut);
}

TEST(PackingModel, TheFieldLosesWhatTheSpheresLoseWithinAFifth) {
  Session run(settings(R"({"packing": {"spheres": 20000, "speed_mm_per_s": 2}})"));
  const double before = run.steps.carver().volume().volumes()[static_cast<std::size_t>(Tissue::kDentin)];
  for (int i = 0; i < 1200; ++i) run.step(pressing(i, 0.9_mm), 1);
  const double after = run.steps.carver().volume().volumes()[static_cast<std::size_t>(Tissue::kDentin)];
  EXPECT_NEAR((before - after) / removed(run.tick), 1, 0.2);
}

TEST(PackingModel, TheSameHandGivesTheSameBits) {
  ServoTick a, b;
  for (ServoTick* last : {&a, &b}) {
    Session run(settings(kPacking));
    for (int i = 0; i < 900; ++i) run.step(pressing(i, 0.5_mm, 0.5), 1);
    *last = run.tick;
  }
  EXPECT_EQ(std::memcmp(&a.f_T_W, &b.f_T_W, sizeof a.f_T_W), 0);
  EXPECT_EQ(std::memcmp(&a.removed, &b.removed, sizeof a.removed), 0);
  EXPECT_EQ(std::memcmp(&a.X_WG, &b.X_WG, sizeof a.X_WG), 0);
}

TEST(PackingModel, AServosTickNeverAllocates) {
  Session run(settings(kPacking));
  for (int i = 0; i < 210; ++i) run.step(pressing(i, 0.5_mm, 0.5), 1);
  HandSample hand;
  ServoTick tick;
  Cut cut;
  test::NoAlloc guard;
  for (int i = 210; i < 600; ++i) {
    hand.t = run.t += 1'000'000;
    hand.X_WT.p = pressing(i, 0.5_mm, 0.5);
    hand.pedal = 1;
    run.steps.servo().tick(hand, tick, cut);
  }
  EXPECT_EQ(guard.count(), 0u);
  EXPECT_GT(tick.cuts, 100u);
}

TEST(PackingModel, OfRandomHandsNoneGetsEnergyFromNothing) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> u(-1, 1);
  for (int hand = 0; hand < 12; ++hand) {
    Session run(settings(kPacking, hand % 2 == 0));
    const double wide = 0.6 + 0.5 * u(random), pace = 0.004 + 0.003 * u(random), phase = 3 * u(random);
    for (int i = 0; i < 3000; ++i) {
      const double down = std::min(i / 500.0, 1.0);
      const dvec3 p(wide * 1.0_mm * std::sin(pace * i + phase), wide * 1.0_mm * std::cos(0.7 * pace * i),
                    kBall + kHead + 1.0_mm - down * (1.0_mm + 0.3_mm + 0.2_mm * std::sin(2 * pace * i)));
      run.step(p, hand % 2 == 0 ? 1 : 0);
      ASSERT_GE(run.tick.energy, -1e-9) << hand << " " << i;
      ASSERT_TRUE(is_finite(run.tick.f_T_W));
    }
  }
}

TEST(PackingModel, ToolsThatFillAndTissuesOfAnotherPackingAreRefused) {
  ServoSettings s = settings(kPacking);
  s.tool.fill = Tissue::kAmalgam;
  EXPECT_THROW(LockStep(ball(), s), Error);
  SpherePacking other;
  other.center = {dvec3(0)}, other.radius = {1.0_mm}, other.tissue = {Tissue::kDentin}, other.tissue_hash = 7;
  const Tool tool;
  EXPECT_THROW(packing::PackingBody(ball(), other, {&tool, 1}, {}), Error);
}

TEST(PackingModel, ParametersOutOfRangeAreRefused) {
  for (const char* bad :
       {R"({"packing": {"spheres": 0}})", R"({"packing": {"spheres": 1000000000}})", R"({"packing": {"sphere": 10}})",
        R"({"packing": {"density": {"stone": 1}}})", R"({"packing": {"file": "p.h5"}})"}) {
    EXPECT_THROW(read_contact_method(Json::parse(bad, "model")), Error) << bad;
  }
}

}  // namespace
}  // namespace typodont::haptics
