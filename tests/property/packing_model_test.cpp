// Tests of the contact model "packing" through the common interface, with servo and carver in lock-step.
#include "haptics/contact/packing/packing_model.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>

#include "engine/base/error.h"
#include "engine/base/units.h"
#include "haptics/contact/packing/packing_body.h"
#include "haptics/contact_method.h"
#include "haptics/dense_tissue.h"
#include "haptics/import/mesh_solid.h"
#include "haptics/packing.h"
#include "tests/support/haptic_bench.h"
#include "tests/support/import_phantom.h"
#include "tests/support/mesh_shapes.h"

namespace typodont::haptics {
namespace {

using namespace literals;

const ToolMeshReaderRegistration kToolMeshes{read_mesh_solid};

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
  for (Material& m : s.materials) m.stiffness = 1000, m.specific_energy = 8e9;
  s.method = read_contact_method(Json::parse(method, "model"));
  return s;
}
constexpr const char* kPacking = R"({"packing": {"spheres": 2500}})";

struct Session : test::HapticBench {
  explicit Session(const ServoSettings& s) : Session(ball(), s) {}
  Session(TissueVolume tissue, const ServoSettings& s) : HapticBench(std::move(tissue), s, s.materials) {}
  Session(std::string_view tissue, const ServoSettings& s) : HapticBench(tissue, s, s.materials) {}
  void step(const dvec3& p, double pedal = 0) { tick(Pose{p, {1, 0, 0, 0}}, pedal); }
  /// The hand is above the ball and pushes down with `newton` (N), wherever the tool is held.
  void push(double newton, double pedal, const dvec3& aside = dvec3(0)) {
    const double k = 1000;  // N/m
    step(dvec3(aside.x, aside.y, last.X_WG.p.z - newton / k), pedal);
  }
};
/// Moves down onto the ball to `deep` below its top. Then moves around the ball by up to `turn` rad.
dvec3 pressing(int tick, double deep, double turn = 0) {
  const double down = std::min(tick / 200.0, 1.0), angle = turn * std::max(0, tick - 200) / 1000.0;
  return (kBall + kHead + 0.3_mm - down * (0.3_mm + deep)) * dvec3(std::sin(angle), 0, std::cos(angle));
}

TEST(PackingModel, OnABallTheForceIsTheSpringForceAlongTheNormal) {
  Session run(settings(kPacking, false));
  double worst = 0;
  for (int i = 0; i < 1200; ++i) {
    run.step(pressing(i, 0.4_mm, 1.0));
    if (i < 260) continue;
    ASSERT_GT(run.last.depth, 0.2_mm) << i;
    const dvec3 out = glm::normalize(run.last.X_WT.p);
    worst = std::max(worst, glm::length(glm::cross(glm::normalize(run.last.f_T_W), out)));
    ASSERT_NEAR(glm::length(run.last.f_T_W), 0.4, 0.1) << i;
  }
  // the surface is uneven, because the spheres have a size of a quarter of a millimetre
  EXPECT_LT(worst, std::sin(25.0_deg));
}

TEST(PackingModel, ASphereOffTheToolsOriginTurnsTheHandWithItsForceTimesItsLever) {
  const dvec3 center(0.9_mm, -0.5_mm, 1.3_mm);
  const std::string file = test::write_stl("ball.stl", test::ball(dvec3(0.7_mm), 0.1_mm, center)).string();
  for (const double rate : {500.0, 2000.0, 4000.0}) {
    ServoSettings s = settings(
        fmt::format(R"({{"packing": {{"spheres": 2500, "tool_spheres": 1, "tool_mesh": {{"file": "{}"}}}}}})", file)
            .c_str(),
        false);
    s.tick = 1 / rate;
    for (const double turn : {0.0, 0.7, -1.9}) {
      Session run(s);
      const dquat R = glm::angleAxis(turn, glm::normalize(dvec3(1, 2, -0.5)));
      const int ticks = static_cast<int>(0.4 * rate);
      // The tool's sphere sinks into the ball from above and stays there, while the hand turns to and fro around it.
      for (int i = 0; i < 2 * ticks; ++i) {
        const double deep = 0.2_mm * std::min(1.0, 1.0 * i / ticks) - 0.03_mm, swing = 0.05 * std::sin(12.0 * i / rate);
        const dquat turned = glm::angleAxis(swing, dvec3(0, 1, 0)) * R;
        run.tick({dvec3(0, 0, kBall + 0.7_mm - deep) - turned * center, turned});
        if (i < ticks) continue;
        // From the tool's origin to the contact, which lies near the top of the uneven ball.
        const dvec3 lever = turned * center - dvec3(0, 0, 0.7_mm), force = run.last.f_T_W;
        ASSERT_GT(glm::length(force), 0.05) << rate << " Hz, turned by " << turn << ", tick " << i;
        ASSERT_LT(glm::length(run.last.tau_T_W - glm::cross(lever, force)),
                  0.15 * glm::length(lever) * glm::length(force))
            << rate << " Hz, turned by " << turn << ", tick " << i;
      }
      EXPECT_GT(run.min_energy, -1e-9) << rate << " Hz, turned by " << turn;
    }
  }
}

TEST(PackingModel, DenserTissueIsCutSlowerByTheRatioOfTheDensities) {
  for (const char* speed : {"", R"("speed_mm_per_s": 1, )"}) {
    double taken[2];
    for (const bool dense : {false, true}) {
      Session run(settings(
          fmt::format(R"({{"packing": {{"spheres": 6000, {}"density": {{"dentin": {}}}}}}})", speed, dense ? 2 : 1)
              .c_str()));
      // pressed on the tissue, with the spindle at rest
      for (int i = 0; i < 200; ++i) run.step(pressing(i, 1.5_mm), 0);
      const double from = run.last.X_WG.p.z;
      for (int i = 0; i < 500; ++i) run.push(0.6, 1);
      taken[dense] = *speed != 0 ? from - run.last.X_WG.p.z : total(run.last.removed);
    }
    EXPECT_NEAR(taken[0] / taken[1], 2, 0.1) << speed;
  }
}

TEST(PackingModel, AFixedSpeedRemovesTheSameAt1And4Kilohertz) {
  double taken[2];
  for (const bool fast : {false, true}) {
    ServoSettings s = settings(R"({"packing": {"spheres": 2500, "speed_mm_per_s": 1}})");
    s.tick = fast ? 0.25e-3 : 1e-3;
    Session run(s);
    const int every = fast ? 4 : 1;
    for (int i = 0; i < 900 * every; ++i) run.step(pressing(i / every, 0.9_mm), 1);
    taken[fast] = total(run.last.removed);
  }
  EXPECT_NEAR(taken[1] / taken[0], 1, 0.02);
}

TEST(PackingModel, ItSlipsWhereTheTangentialForceExceedsTheStaticFrictionWithinOnePercent) {
  // One sphere of the size of the ball, so that the surface is smooth.
  ServoSettings s = settings(R"({"packing": {"spheres": 1}})", false);
  s.friction = true;
  for (const auto& [fixed, sliding] : {std::pair{0.3, 0.22}, {0.6, 0.45}}) {
    for (Material& m : s.materials) m.static_friction = fixed, m.dynamic_friction = sliding;
    Session run(s);
    for (int i = 0; i < 300; ++i) run.step(dvec3(0, 0, kBall + kHead + 0.1_mm - i * 1e-6));
    for (int i = 0; i < 50; ++i) run.step(dvec3(0, 0, kBall + kHead - 0.2_mm));
    const dvec3 stuck = run.last.X_WG.p;
    const auto& spheres = static_cast<const packing::PackingSnapshot&>(run.servo.snapshot()).spheres;
    const dvec3 middle = spheres.tree().center(0), n = glm::normalize(stuck - middle);
    const dvec3 side = glm::normalize(glm::cross(n, dvec3(0, 1, 0)));
    double slipped_at = 0;
    for (int i = 0; i < 30000 && slipped_at == 0; ++i) {
      const double x = i * 2e-8;
      run.step(stuck - 0.2_mm * n + x * side);
      if (glm::distance(run.last.X_WG.p, stuck) > 1e-9) slipped_at = x;
    }
    EXPECT_NEAR(slipped_at / 0.2_mm, fixed, 0.01 * fixed);
    // At this point the hand begins to slip. Before it feels static friction along the surface, afterwards dynamic
    // friction.
    for (int i = 0; i < 400; ++i) run.step(stuck - 0.2_mm * n + (slipped_at + i * 1e-6) * side);
    const dvec3 out = glm::normalize(run.last.X_WG.p - middle), f = run.last.f_T_W;
    const double along = glm::length(f - glm::dot(f, out) * out);
    EXPECT_NEAR(along / glm::dot(f, out), sliding, 0.02 * sliding);
  }
}

TEST(PackingModel, SofterGradedCariesYieldsMore) {
  // Three lesions of hardness 0.8, 0.7 and 0.6, at different depths as in S2.
  double force[3], speed[3];
  int k = 0;
  for (const double hardness : {0.8, 0.7, 0.6}) {
    ServoSettings s = settings(kPacking);
    TissueVolume tissue = ball();
    tissue.paint(Tissue::kCaries, *read_solid(Json::parse(R"({"sphere": {"radius_mm": 4}})", "t")),
                 hardness_byte(hardness));
    Session run(std::move(tissue), s);
    for (int i = 0; i < 300; ++i) run.step(pressing(i, 0.4_mm), 0);
    force[k] = glm::length(run.last.f_T_W);
    const double before = total(run.last.removed);
    // In a softer lesion, the hand moves farther for the same felt force of 0.3 N.
    for (int i = 0; i < 300; ++i) run.push(0.3 / hardness, 1);
    speed[k++] = total(run.last.removed) - before;
  }
  EXPECT_GT(force[0], 1.05 * force[1]);
  EXPECT_GT(force[1], 1.05 * force[2]);
  EXPECT_GT(speed[1], speed[0]);
  EXPECT_GT(speed[2], speed[1]);
}

TEST(PackingModel, PaintedTissueIsFeltAndUndoneWithItsStroke) {
  Session run(settings(kPacking, false));
  for (int i = 0; i < 260; ++i) run.step(pressing(i, 0.3_mm));
  const double dentin = glm::length(run.last.f_T_W);
  EXPECT_EQ(run.last.tissue, Tissue::kDentin);
  for (int i = 0; i < 50; ++i) run.step(dvec3(0, 0, 6.0_mm));
  Carver& carver = run.carver;
  carver.volume().begin_stroke();
  carver.volume().paint(Tissue::kCaries, *read_solid(Json::parse(R"({"sphere": {"radius_mm": 4}})", "t")),
                        hardness_byte(0.5));
  carver.volume().end_stroke();
  run.steps.take_snapshot(dvec3(0));
  run.steps.adopt_snapshot();
  for (int i = 0; i < 260; ++i) run.step(pressing(i, 0.3_mm));
  EXPECT_EQ(run.last.tissue, Tissue::kCaries);
  EXPECT_NEAR(glm::length(run.last.f_T_W) / dentin, 0.5, 0.1);
  for (int i = 0; i < 50; ++i) run.step(dvec3(0, 0, 6.0_mm));
  ASSERT_TRUE(carver.undo());
  for (int i = 0; i < 50; ++i) run.step(dvec3(0, 0, 6.0_mm));
  for (int i = 0; i < 260; ++i) run.step(pressing(i, 0.3_mm));
  EXPECT_EQ(run.last.tissue, Tissue::kDentin);
}

TEST(PackingModel, AShankIsFeltAndNeverCuts) {
  ServoSettings s = settings(kPacking);
  s.tool.shank_length = 8.0_mm, s.tool.shank_diameter = 1.6_mm, s.tool.neck_diameter = 0.8_mm,
  s.tool.neck_length = 2.0_mm;
  Session run(s);
  // The tool is horizontal beside the ball, and its shank is pressed against the ball.
  const dquat lying(std::sqrt(0.5), 0, std::sqrt(0.5), 0);  // the shank points along +x
  for (int i = 0; i < 600; ++i) {
    const double z = kBall + 0.8_mm + 0.3_mm - std::min(i / 400.0, 1.0) * 0.6_mm;
    run.tick({{-5.0_mm, 0, z}, lying}, 1);
  }
  EXPECT_EQ(total(run.last.removed), 0);
  EXPECT_GT(run.last.f_T_W.z, 0.1);
  EXPECT_GT(run.last.X_WG.p.z, kBall + 0.55_mm);
}

TEST(PackingModel, ALoosePieceIsRemovedCountedAndRestoredByUndo) {
  // A stud on a plate. A bur cuts through its neck.
  const auto stud = [] {
    return TissueVolume(
        read_solids(Json::parse(R"({"voxel_mm": 0.1, "solids": [{"tissue": "dentin", "solid": {"union": [
        {"box": {"center_mm": [0, 0, -1], "size_mm": [4, 4, 2]}},
        {"cylinder": {"center_mm": [0, 0, 1.4], "axis": [0, 0, 1], "radius_mm": 0.5, "height_mm": 3}}]}}]})",
                                "t")));
  };
  Session run(stud(), settings(R"({"packing": {"spheres": 3000, "speed_mm_per_s": 20}})"));
  const double before = run.carver.volume().volumes()[static_cast<std::size_t>(Tissue::kDentin)];
  const double top = kPi * 0.5_mm * 0.5_mm * 0.8_mm;  // m³, the part of the stud that lies above the bur
  double largest = 0;
  LoosePiece piece;
  for (int i = 0; i < 4000 && largest < 0.1 * top; ++i) {
    run.step(dvec3(-1.4_mm + i * 0.7e-6, 0, 1.5_mm), 1);
    for (const LoosePiece& loose : run.carver.take_pieces()) {
      if (total(loose.removed) > largest) largest = total(loose.removed), piece = loose;
    }
  }
  EXPECT_NEAR(largest / top, 1, 0.4);
  EXPECT_GT(piece.center_W.z, 1.9_mm);
  for (int i = 0; i < 20; ++i) run.step(dvec3(-4.0_mm, 0, 4.0_mm), 0);
  const double after = run.carver.volume().volumes()[static_cast<std::size_t>(Tissue::kDentin)];
  EXPECT_NEAR((before - after) / total(run.last.removed), 1, 0.1);
  EXPECT_GE(run.servo.snapshot().pieces, 1u);
  EXPECT_LT(run.servo.snapshot().pieces, 20u);
  // The bur moves to the former position of the piece and must feel nothing.
  double most = 0;
  for (int i = 0; i < 300; ++i) {
    run.step(dvec3(-2.0_mm + i * 0.01_mm, 0, 2.6_mm), 0);
    most = std::max(most, glm::length(run.last.f_T_W));
  }
  EXPECT_LT(most, 1e-3);
  for (int i = 0; i < 400; ++i) run.step(dvec3(-4.0_mm, 0, 4.0_mm), 0);
  ASSERT_TRUE(run.carver.undo());
  for (int i = 0; i < 20; ++i) run.step(dvec3(-4.0_mm, 0, 4.0_mm), 0);
  EXPECT_DOUBLE_EQ(run.carver.volume().volumes()[static_cast<std::size_t>(Tissue::kDentin)], before);
}

/// A bur drills down into a block and sideways, so that tissue remains above it. Then the drill stops, and the hand
/// moves straight up.
void drill_under_a_roof(Session& run) {
  const auto line = [&](const dvec3& from, const dvec3& to, int ticks, double pedal) {
    for (int i = 1; i <= ticks; ++i) run.step(from + (to - from) * (i / static_cast<double>(ticks)), pedal);
  };
  line({0, 0, 3.5_mm}, {0, 0, 0.3_mm}, 1200, 1);
  line({0, 0, 0.3_mm}, {2.2_mm, 0, 0.3_mm}, 1600, 1);
  for (int i = 0; i < 300; ++i) run.step(dvec3(2.2_mm, 0, 0.3_mm), 0);
  ASSERT_GT(run.last.X_WG.p.x, 1.8_mm);
  ASSERT_LT(run.last.X_WG.p.z, 0.8_mm);
  line({2.2_mm, 0, 0.3_mm}, {2.2_mm, 0, 6.0_mm}, 500, 0);
}
Session under_a_roof() {
  return {R"({"voxel_mm": 0.2, "solids": [{"tissue": "dentin", "solid": {"box": {"size_mm": [8, 4, 5]}}}]})",
          settings(R"({"packing": {"spheres": 4000, "speed_mm_per_s": 5}})")};
}

TEST(PackingModel, ABurUnderAnOverhangRetreatsAlongItsPathWithoutCutting) {
  Session run = under_a_roof();
  drill_under_a_roof(run);
  ASSERT_LT(run.last.X_WG.p.z, 1.5_mm);
  const std::uint64_t cuts = run.last.cuts;
  std::uint32_t faults = 0;
  for (int i = 0; i < 3000; ++i) {
    run.step(dvec3(2.2_mm, 0, 6.0_mm), 0);
    faults |= run.last.faults;
  }
  EXPECT_LT(glm::distance(run.last.X_WG.p, run.last.X_WT.p), 1e-6);
  EXPECT_TRUE(faults & bits(Fault::kWedged)) << "the user was told";
  EXPECT_FALSE(run.last.faults & bits(Fault::kWedged)) << "no longer";
  EXPECT_EQ(run.last.cuts, cuts);
}

TEST(PackingModel, AHandThatPushesIntoAWallIsHeldHoweverLong) {
  Session run = under_a_roof();
  for (int i = 0; i < 400; ++i) run.step(dvec3(0, 0, 3.5_mm - i * 0.01_mm), 0);
  const dvec3 held = run.last.X_WG.p;
  for (int i = 0; i < 3000; ++i) run.step(dvec3(0, 0, -0.5_mm), 0);
  EXPECT_LT(glm::distance(run.last.X_WG.p, held), 0.1_mm);
  EXPECT_FALSE(run.last.faults & bits(Fault::kWedged));
}

TEST(PackingModel, TwoBodiesThatWereSeparateFromTheStartAreKept) {
  Session run(
      R"({"voxel_mm": 0.1, "solids": [{"tissue": "dentin", "solid": {"union": [
      {"sphere": {"center_mm": [0, 0, 0], "radius_mm": 1.5}}, {"sphere": {"center_mm": [3.4, 0, 0], "radius_mm": 1}}]}}]})",
      settings(R"({"packing": {"spheres": 1000, "speed_mm_per_s": 20}})"));
  for (int i = 0; i < 1200; ++i) run.step(dvec3(1.9_mm, 0, 2.5_mm - i * 2e-6), 1);
  EXPECT_GT(total(run.last.removed), 0);
  EXPECT_TRUE(run.carver.take_pieces().empty());
}

TEST(PackingModel, ServoAndCarverHoldTheSameSpheresBitForBit) {
  Session run(settings(kPacking));
  for (int i = 0; i < 1200; ++i) run.step(pressing(i, 0.6_mm, 0.8), 1);
  ASSERT_GT(run.last.cuts, 300u);
  const auto& servo = static_cast<const packing::PackingSnapshot&>(run.servo.snapshot()).spheres;
  const auto snapshot = run.carver.make_snapshot();
  const auto& carver = static_cast<const packing::PackingSnapshot&>(*snapshot).spheres;
  ASSERT_EQ(servo.size(), carver.size());
  for (int i = 0; i < static_cast<int>(servo.size()); ++i) ASSERT_EQ(servo.sphere(i), carver.sphere(i)) << i;
}

TEST(PackingModel, ThePackingOfAnotherTissueIsRefused) {
  SpherePacking other;
  other.center = {dvec3(0)}, other.radius = {1.0_mm}, other.tissue = {Tissue::kDentin}, other.tissue_hash = 7;
  const Tool tool;
  EXPECT_THROW(packing::PackingBody(ball(), other, {&tool, 1}, {}), Error);
}

}  // namespace
}  // namespace typodont::haptics
