// Tests of the contact model "implant" through the common interface: beds (holes for an implant), and motion in them.
#include "haptics/contact/implant/implant_model.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "tests/support/folder.h"
#include "tests/support/implant_bench.h"
#include "tests/support/no_alloc.h"

namespace typodont::haptics::implant {
namespace {

using test::bone_block;
using test::implant_settings;
using test::ImplantSession;
using namespace test;

constexpr std::uint32_t kHigh = static_cast<std::uint32_t>(Motion::kFree);

/// Radius (m) of the hole around the z axis at a depth, measured in the distance field as the mean over 64 directions.
struct Hole {
  double mean = 0, least = 1e9, greatest = 0;
};
Hole hole_at(const TissueVolume& volume, double depth, const dvec3& axis_at = dvec3(0)) {
  Hole hole;
  const double h = volume.frame().voxel;
  const glm::ivec3 lo(glm::floor(volume.frame().to_voxels(axis_at - dvec3(4e-3, 4e-3, depth + 2 * h)))),
      hi(glm::ceil(volume.frame().to_voxels(axis_at + dvec3(4e-3, 4e-3, -depth + 2 * h))));
  const glm::ivec3 size = hi - lo + 1;
  std::vector<float> d(static_cast<std::size_t>(size.x) * size.y * size.z);
  std::vector<Tissue> label(d.size());
  volume.copy(lo, size, d.data(), label.data());
  const auto value = [&](const dvec3& p_W) {
    const dvec3 q = volume.frame().to_voxels(p_W) - dvec3(lo);
    const glm::ivec3 at(glm::floor(q));
    const dvec3 f = q - dvec3(at);
    double sum = 0;
    for (int c = 0; c < 8; ++c) {
      const glm::ivec3 o(c & 1, c >> 1 & 1, c >> 2 & 1), p = at + o;
      sum += static_cast<double>(d[(static_cast<std::size_t>(p.x) * size.y + p.y) * size.z + p.z]) *
             (o.x ? f.x : 1 - f.x) * (o.y ? f.y : 1 - f.y) * (o.z ? f.z : 1 - f.z);
    }
    return sum;
  };
  constexpr int kWays = 64;
  for (int i = 0; i < kWays; ++i) {
    const double a = 2 * kPi * i / kWays;
    double inner = 0, outer = 3.5e-3;
    for (int k = 0; k < 40; ++k) {
      const double r = (inner + outer) / 2;
      (value(axis_at + dvec3(r * std::cos(a), r * std::sin(a), -depth)) > 0 ? inner : outer) = r;
    }
    hole.mean += inner / kWays;
    hole.least = std::min(hole.least, inner), hole.greatest = std::max(hole.greatest, inner);
  }
  return hole;
}

/// Drills a bed with a diameter of 2.2 mm and a depth of `mm`.
void pilot(ImplantSession& s, double mm) {
  s.land_with(kPilot);
  ASSERT_TRUE(s.drill(mm));
}

TEST(ImplantModel, ARoundBurCutsNoBoneAboveItsGreatestGrey) {
  const auto removed = [](double max_grey, double side_mm) {
    std::vector<Tool> tools = implant_tools();
    auto implant = std::make_shared<ImplantTool>(*tools[kRound].implant);
    implant->max_grey = max_grey;
    tools[kRound].implant = implant;
    ImplantSession run(bone_block(), implant_settings(R"("implant")", tools));
    run.land_with(kRound);
    for (int i = 0; i < 1500; ++i) run.tip_at({side_mm * i / 1500, 0, -1.0 * std::min(i, 300) / 300}, 1);
    return total(run.tick.removed);
  };
  for (const double side_mm : {0.0, 2.0}) {
    EXPECT_EQ(removed(1600, side_mm), 0) << side_mm;  // cortical bone: 1650
    EXPECT_GT(removed(1700, side_mm), 0.1e-9) << side_mm;
  }
}

TEST(ImplantModel, APilotDrillPressedOntoBoneBeginsABedAndDeepensIt) {
  ImplantSession s;
  s.land_with(kPilot);
  EXPECT_EQ(s.tick.level, kHigh);
  for (int i = 0; i < 5; ++i) s.push(0.2, 0);
  EXPECT_EQ(s.tick.level, kHigh) << "the drill stands";
  ASSERT_TRUE(s.drill(6));
  EXPECT_EQ(s.tick.level, static_cast<std::uint32_t>(Motion::kDrilling));
  EXPECT_NEAR(s.depth(), 6e-3, 0.1e-3);
  EXPECT_NEAR(s.removed_mm3(), kPi * 1.1 * 1.1 * 6, 0.03 * kPi * 1.1 * 1.1 * 6);
  const Hole hole = hole_at(s.steps.carver().volume(), 4e-3);
  EXPECT_NEAR(hole.mean, 1.1e-3, 0.02e-3);
}

TEST(ImplantModel, TheBedsAxisIsTheToolsAndATiltedHandKeepsTheToolOnIt) {
  ImplantSession s;
  pilot(s, 4);
  // 5 mm aside and turned by 8 degrees.
  const dquat R = glm::angleAxis(8 * kDegree, dvec3(0, 1, 0));
  dvec3 aside(0);
  for (int i = 0; i < 2000; ++i) {
    aside.x = std::min(5.0, i * 0.01);
    s.tip_at({aside.x, 0, -4.0}, 0, glm::slerp(dquat(1, 0, 0, 0), R, std::min(1.0, i / 500.0)));
    const dvec3 axis = s.tick.X_WG.R * dvec3(0, 0, 1);
    EXPECT_LT(std::acos(std::min(1.0, axis.z)), 0.2 * kDegree);
    EXPECT_LT(std::hypot(s.tick.X_WG.p.x, s.tick.X_WG.p.y), 1e-9);
  }
  EXPECT_GT(glm::length(s.tick.tau_T_W), 0.01) << "the hand feels that it is turned";
  EXPECT_GT(-s.tick.f_T_W.x, 1) << "and that it is aside";
}

TEST(ImplantModel, AGaugeSlidesInAFinishedBedAndStopsAtItsBottom) {
  ImplantSession s;
  pilot(s, 6);
  s.withdraw();
  s.take(kGauge22);
  const double before = s.removed_mm3();
  s.land();
  for (int i = 0; i < 20; ++i) s.push(0.6);
  ASSERT_NE(s.tick.level, kHigh);
  double most = 0;
  const double from = -s.depth() / kMillimetre;
  for (double z = from; z > -5.8; z -= 0.01) {  // 10 mm/s
    s.tip_at({0, 0, z});
    if (z < from - 1) most = std::max(most, glm::length(s.tick.f_T_W));
  }
  EXPECT_LT(most, 0.1);
  for (int i = 0; i < 2000; ++i) s.push(5);
  EXPECT_NEAR(s.depth(), 6e-3, 0.1e-3);
  EXPECT_GT(glm::length(s.tick.f_T_W), 2) << "5 N in bone half as hard";
  EXPECT_EQ(s.removed_mm3(), before);
}

TEST(ImplantModel, AWideningDrillRemovesARingAndStopsAtTheOldBottom) {
  ImplantSession s;
  pilot(s, 6);
  s.withdraw();
  const double before = s.removed_mm3();
  s.land_with(kTwist28);
  for (int i = 0; i < 30000; ++i) s.push(5, 1);
  EXPECT_NEAR(s.depth(), 6e-3, 0.1e-3);
  const double ring = kPi * (1.4 * 1.4 - 1.1 * 1.1) * 6;
  EXPECT_NEAR(s.removed_mm3() - before, ring, 0.03 * ring);
}

/// Mean axial force (N), torque (N·m) and speed (m/s) of a drill that a hand moves at `speed` into a narrower bed.
struct Widening {
  double force = 0, torque = 0, speed = 0;
};
Widening widen(ImplantSession& s, const dvec3& entry_W, const dquat& R, double speed) {
  Widening mean;
  const dvec3 up = R * dvec3(0, 0, 1);
  const auto height = [&] { return glm::dot(s.tick.X_WG.p - entry_W, up) - s.half(); };
  double before = 0;
  int count = 0;
  for (double z = 0.1e-3; z > -4e-3; z -= speed * s.period) {
    s.step({entry_W + (z + s.half()) * up, R}, 1);
    if (z < -2.5e-3) {
      mean.force += glm::dot(s.tick.f_T_W, up), mean.torque -= glm::dot(s.tick.tau_T_W, up);
      mean.speed += (before - height()) / s.period;
      ++count;
    }
    before = height();
  }
  return {mean.force / count, mean.torque / count, mean.speed / count};
}
/// Compares with equation 2 over the annulus that cuts. The drag of sliding, 2 N·s/m, adds to the force.
void expect_equation2(const Widening& is, double bed_mm, double drill_mm, double speed, double spindle,
                      const std::string& what) {
  const double r = bed_mm / 2 * kMillimetre, R = drill_mm / 2 * kMillimetre, u = 0.1e9, alpha = 12;
  const double N = spindle / (2 * kPi);
  EXPECT_NEAR(is.speed / speed, 1, 0.01) << what;
  EXPECT_NEAR((is.force - 2 * is.speed) / (u * is.speed * (R - r) / (alpha * N)), 1, 0.05) << what;
  EXPECT_NEAR(is.torque / (u * is.speed * (R * R - r * r) / (2 * N)), 1, 0.05) << what;
}

TEST(ImplantModel, AWideningDrillHasTheForceAndTorqueOfEquation2OverTheAnnulusThatCuts) {
  struct Case {
    double bed_mm, drill_mm, speed, rate, tilt_deg, voxel_mm;
  };
  for (const Case& c : {Case{2.2, 2.8, 0.4e-3, 1000, 0, 0.15}, Case{3.3, 3.6, 1.1e-3, 500, 21, 0.15},
                        Case{1.6, 2.4, 0.7e-3, 4000, 8, 0.15}, Case{2.1, 3.2, 2.3e-3, 2000, 33, 0.15},
                        Case{3.5, 4.2, 1.5e-3, 500, 5, 0.15}, Case{2.8, 3.3, 0.9e-3, 2000, 13, 0.1}}) {
    const dquat R = glm::angleAxis(c.tilt_deg * kDegree, glm::normalize(dvec3(1, 0.37, 0)));
    const dvec3 up = R * dvec3(0, 0, 1);
    const std::string solids = fmt::format(
        R"({{"voxel_mm": {}, "solids": [{{"tissue": "cancellous_bone", "solid": {{"difference": [
          {{"box": {{"center_mm": [0, 0, -6], "size_mm": [12, 12, 12]}}}},
          {{"cylinder": {{"center_mm": [0.21, -0.13, 0], "axis": [{}, {}, {}], "radius_mm": {}, "height_mm": 16}}}}]}}}}]}})",
        c.voxel_mm, up.x, up.y, up.z, c.bed_mm / 2);
    ServoSettings settings = implant_settings(fmt::format(R"({{"implant": {{"beds": [
          {{"entry_mm": [0.21, -0.13, 0], "axis": [{}, {}, {}], "depth_mm": 8, "diameter_mm": {}}}]}}}})",
                                                          -up.x, -up.y, -up.z, c.bed_mm),
                                              {implant_tool("drill", c.drill_mm, 10, drill_block(0.8 * c.bed_mm))});
    settings.tick = 1 / c.rate;
    ImplantSession s(TissueVolume(read_solids(Json::parse(solids, "bone"))), settings);
    const Widening mean = widen(s, dvec3(0.21, -0.13, 0) * kMillimetre, R, c.speed);
    expect_equation2(mean, c.bed_mm, c.drill_mm, c.speed, s.tick.spindle,
                     fmt::format("{} in {} mm, {} Hz, {} degrees", c.drill_mm, c.bed_mm, c.rate, c.tilt_deg));
  }
}

TEST(ImplantModel, InABedThatADrillMadeAWiderDrillHasTheForceOfEquation2) {
  ImplantSession s(bone_block(0.3, 1));
  pilot(s, 6);
  double bed_mm = 2.2;
  for (const auto& [tool, drill_mm] : {std::pair{kTwist28, 2.8}, {kTwist35, 3.5}, {kTwist42, 4.2}}) {
    s.withdraw();
    s.land_with(tool);
    const Widening mean = widen(s, dvec3(0), {1, 0, 0, 0}, 0.8e-3);
    expect_equation2(mean, bed_mm, drill_mm, 0.8e-3, s.tick.spindle, fmt::format("{} mm", drill_mm));
    for (int i = 0; i < 20000 && s.depth() < 5.9e-3; ++i) s.push(5, 1);
    bed_mm = drill_mm;
  }
}

/// Widens the bed with this drill to the depth (m).
void widen_with(ImplantSession& s, std::uint32_t drill, double depth) {
  s.withdraw();
  s.land_with(drill);
  for (int i = 0; i < 20000 && s.depth() < depth; ++i) s.push(5, 1);
}

TEST(ImplantModel, AfterA42DrillTheBedHasItsRadius) {
  ImplantSession s;
  pilot(s, 5);
  for (const std::uint32_t drill : {kTwist28, kTwist35, kTwist42}) {
    widen_with(s, drill, 4.95e-3);
    EXPECT_NEAR(s.depth(), 5e-3, 0.1e-3) << drill;
  }
  const Hole hole = hole_at(s.steps.carver().volume(), 3e-3);
  EXPECT_NEAR(hole.mean, 2.10e-3, 0.02e-3);
  EXPECT_LT(hole.greatest - hole.least, 0.05e-3);
}

TEST(ImplantModel, AGaugeThatIsTooWideDoesNotEnterAtTenNewton) {
  ImplantSession s;
  pilot(s, 6);
  s.withdraw();
  s.land_with(kGauge28);
  for (int i = 0; i < 3000; ++i) s.push(10);
  EXPECT_LT(s.depth(), 0.1e-3);
  EXPECT_EQ(s.tick.level, kHigh);
}

TEST(ImplantModel, BoneAboveTheDrillsGreatestGreyValueStopsTheDrill) {
  std::vector<Tool> tools = implant_tools();
  tools[kPilot] = implant_tool("pilot", 2.2, 10, drill_block(0, 1, 1000));  // cortical bone has 1650 HU
  ImplantSession s(bone_block(), implant_settings(R"("implant")", tools));
  s.land_with(kPilot);
  for (int i = 0; i < 3000; ++i) s.push(5, 1);
  EXPECT_EQ(s.removed_mm3(), 0);
}

TEST(ImplantModel, WithOneLayerOfToolVoxelsTheForceNeverVanishesInTenSecondsOfDrilling) {
  // Tool voxels smaller and larger than those of bone (0.15 mm).
  for (const double tool_voxel_mm : {0.04, 0.06, 0.2}) {
    ServoSettings settings = implant_settings(fmt::format(R"({{"implant": {{"tool_voxel_mm": {}}}}})", tool_voxel_mm));
    for (Material& m : settings.materials) m.specific_energy *= 5;
    ImplantSession s(bone_block(), settings);
    s.land_with(kPilot);
    for (int i = 0; i < 300; ++i) s.push(3, 1);
    double least = 1e9;
    for (int i = 0; i < 10000; ++i) {
      s.push(3, 1);
      least = std::min(least, glm::length(s.tick.f_T_W));
    }
    EXPECT_GT(least, 1.0) << tool_voxel_mm;
    EXPECT_GT(s.depth(), 0.5e-3) << tool_voxel_mm;
  }
}

TEST(ImplantModel, OnBreakingThroughTheFarCortexTheForceFallsBy90PercentWithin20Milliseconds) {
  struct Case {
    double push, rate, drill_mm;  // N, Hz, mm
  };
  for (const Case& c : {Case{1.3, 1000, 2.2}, Case{2.6, 500, 1.8}, Case{4.5, 500, 2.2}, Case{4.5, 4000, 2.7},
                        Case{6.3, 1000, 1.8}, Case{7.7, 2000, 2.2}, Case{9, 500, 2.7}, Case{9, 1000, 2.2}}) {
    std::vector<Tool> tools = implant_tools();
    tools[kPilot] = implant_tool("pilot", c.drill_mm, 10, drill_block(0, 1));
    ServoSettings settings = implant_settings(R"("implant")", tools);
    settings.tick = 1 / c.rate, settings.damping = 3, settings.passivity = true;
    ImplantSession s(bone_block(1, 0.5, 3), settings);
    s.land_with(kPilot);
    // A hand that pushes with `push`, and moves on the faster the less the bone resists.
    double z = 0, before = 0, after = 0, through = -1;
    for (double t = 0; t < 30 && (through < 0 || t < through + 20e-3); t += s.period) {
      z -= std::max(0.0, c.push - s.tick.f_T_W.z) / 100 * s.period;
      const double force = s.tick.f_T_W.z;
      s.tip_at({0, 0, z / kMillimetre}, 1);
      if (through < 0 && s.tick.level == static_cast<std::uint32_t>(Motion::kPerforating)) through = t, before = force;
      after = s.tick.f_T_W.z;
    }
    EXPECT_GT(before, 0.4 * c.push) << c.push << " N";
    EXPECT_LT(after, 0.1 * before) << c.push << " N, " << c.rate << " Hz, " << c.drill_mm << " mm";
  }
}

TEST(ImplantModel, ATapAdvancesByItsPitchAndCannotBePulledOutWithoutTurning) {
  ImplantSession s;
  pilot(s, 5);
  for (const std::uint32_t drill : {kTwist28, kTwist35, kTwist42}) widen_with(s, drill, 4.95e-3);
  s.withdraw();
  s.land_with(kTap);
  for (int i = 0; i < 3000 && s.depth() < 0.5e-3; ++i) s.push(2, 1);
  ASSERT_GT(s.depth(), 0.4e-3);
  for (int i = 0; i < 500; ++i) s.push(1, 1);
  // One turn per second.
  const double from = s.depth();
  for (int i = 0; i < 2000; ++i) s.push(1, 1);
  EXPECT_NEAR(s.depth() - from, 1.6e-3, 0.01 * 1.6e-3);
  for (int i = 0; i < 300; ++i) s.push(0, 0);  // the spindle is at rest
  const double stands = s.depth();
  for (int i = 0; i < 1000; ++i) s.push(-10 * std::min(1.0, i / 500.0), 0);
  EXPECT_LT(std::abs(s.depth() - stands), 0.15e-3);
  EXPECT_GT(glm::length(s.tick.f_T_W), 4.5) << "10 N in bone half as hard";
  for (int i = 0; i < 1000; ++i) s.push(0, -1);  // backwards
  EXPECT_NEAR(stands - s.depth(), 0.8e-3, 0.02e-3);
}

/// Screws the implant in until it is placed. Returns the largest torque, N·m.
double place_implant(ImplantSession& s) {
  s.land_with(kImplant);
  double torque = 0;
  for (int i = 0; i < 15000 && (i < 100 || s.cut.fill_radius == 0); ++i) {
    s.push(1.5, 1);
    torque = std::max(torque, glm::length(s.tick.tau_T_W));
  }
  return torque;
}

TEST(ImplantModel, AnImplantStaysInItsBedAndLaterToolsCollideWithIt) {
  ImplantSession s;
  pilot(s, 6.1);
  for (const std::uint32_t drill : {kTwist28, kTwist35, kTwist42}) widen_with(s, drill, 6.05e-3);
  s.withdraw();
  const double torque = place_implant(s);
  ASSERT_GT(s.cut.fill_radius, 0) << "it was placed; depth " << s.depth();
  EXPECT_GT(torque, 0.02) << "insertion torque";
  // The gauge of 2.2 mm rests on the implant's platform.
  for (double z = -6; z < 8; z += 0.02) s.tip_at({0, 0, z});
  s.land_with(kGauge22);
  for (int i = 0; i < 500; ++i) s.push(3);
  EXPECT_NEAR(s.depth(), 0.0, 0.2e-3);
  EXPECT_EQ(s.tick.tissue, kPlacedTissue);
  // The implant's screw goes into the implant.
  for (double z = 0; z < 8; z += 0.02) s.tip_at({0, 0, z});
  s.land_with(kScrew);
  for (int i = 0; i < 8000 && s.cut.tool != kScrew; ++i) s.push(1.5, 1);
  EXPECT_EQ(s.cut.tool, static_cast<std::uint32_t>(kScrew)) << "depth " << s.depth();
}

TEST(ImplantModel, InABedNarrowerThanItsCoreAnImplantNeedsTheTorqueOfTheBoneThatItDisplaces) {
  // N·m, largest torque of the implant with a core of 4.2 mm and a thread of 4.8 mm
  const auto insert = [](double bed_mm, double hardness) {
    const std::string solids = fmt::format(
        R"({{"voxel_mm": 0.15, "solids": [{{"tissue": "cancellous_bone", "hardness": {}, "solid": {{"difference": [
          {{"box": {{"center_mm": [0, 0, -4], "size_mm": [9, 9, 8]}}}}, {{"cylinder": {{"radius_mm": {}, "height_mm": 14}}}}]}}}}]}})",
        hardness, bed_mm / 2);
    ImplantSession s(
        TissueVolume(read_solids(Json::parse(solids, "bone"))),
        implant_settings(fmt::format(
            R"({{"implant": {{"beds": [{{"entry_mm": [0, 0, 0], "axis": [0, 0, -1], "depth_mm": 7, "diameter_mm": {}}}]}}}})",
            bed_mm)));
    const double torque = place_implant(s);
    EXPECT_GT(s.cut.fill_radius, 0) << "placed in " << bed_mm << " mm, hardness " << hardness;
    return torque;
  };
  const auto displaced = [](double bed_mm) { return 4.5 * 4.5 - bed_mm * bed_mm; };
  const double full = insert(4.2, 0.5);
  EXPECT_NEAR(full / insert(4.2, 0.25), 4.2, 0.2) << "Braz J Oral Sci 15 (2017): twice the density";
  for (const double bed_mm : {3.9, 3.5}) {
    EXPECT_NEAR(insert(bed_mm, 0.5) / full / (displaced(bed_mm) / displaced(4.2)), 1, 0.03) << bed_mm;
  }
}

TEST(ImplantModel, TheStiffnessFeltInABedFollowsTheGreyValue) {
  double stiffness[2];
  for (const int i : {0, 1}) {
    ImplantSession s(bone_block(0.2, i == 0 ? 0.4 : 0.8));
    pilot(s, 3);
    for (int n = 0; n < 300; ++n) s.push(3, 0);
    for (int n = 0; n < 500; ++n) s.tip_at({0, 0, -s.depth() * 1e3 - 1.0}, 0);
    stiffness[i] = s.tick.f_T_W.z / s.tick.depth;
  }
  EXPECT_NEAR(stiffness[1] / stiffness[0], 2.0, 0.02);
}

TEST(ImplantModel, UndoFillsTheBedAndItIsNoLongerABed) {
  ImplantSession s;
  pilot(s, 3);
  s.withdraw();
  ASSERT_TRUE(s.steps.carver().undo());
  s.land_with(kGauge22);
  for (int i = 0; i < 300; ++i) s.push(2);
  EXPECT_LT(s.depth(), 0.05e-3);
  EXPECT_EQ(s.tick.level, kHigh);
}

TEST(ImplantModel, NoTickAllocates) {
  ImplantSession s;
  s.land_with(kPilot);
  HandSample hand;
  hand.t = s.t, hand.pedal = 1, hand.tool = kPilot;
  int cuts = 0;
  std::size_t allocated = 0;
  for (int i = 0; i < 1500; ++i) {
    hand.t += 1'000'000;
    hand.X_WT.p = s.tick.X_WT.p - dvec3(0, 0, 1e-6);
    test::NoAlloc guard;
    cuts += s.steps.servo().tick(hand, s.tick, s.cut);
    allocated += guard.count();
  }
  EXPECT_EQ(allocated, 0u);
  EXPECT_GT(cuts, 100);
  EXPECT_EQ(s.tick.level, static_cast<std::uint32_t>(Motion::kDrilling));
}

TEST(ImplantModel, ABedOutsideBoneIsRefusedWithItsPosition) {
  const char* const model =
      R"({"implant": {"beds": [{"entry_mm": [30, 0, 0], "axis": [0, 0, -1], "depth_mm": 6, "diameter_mm": 2.2}]}})";
  EXPECT_THAT(test::refusal([&] { ImplantSession s(bone_block(), implant_settings(model)); }),
              testing::AllOf(testing::HasSubstr("beds[0]"), testing::HasSubstr("a bed inside bone")));
}

/// Force (N) by which the hand's motion in one tick may change the force of spring and damper. A rotation of the hand
/// moves the end of the tool.
double effect_of(const ImplantSession& s, const Pose& last, double damping) {
  const double path = glm::length(s.tick.X_WT.p - last.p) + s.half() * rotation_angle(s.tick.X_WT.R, last.R);
  return s.stiffness * path + damping * path / s.period;
}

/// Hands that enter and leave beds in unusual ways. In a tick in which the state switches, the force differs from that
/// of the previous tick by at most the effect of the hand's own motion plus 0.02 N. A tilting tool may hop on the rim
/// before it enters, so the step of the tick before the switch is added.
TEST(ImplantModel, NoSwitchOfStateCausesAForceStep) {
  struct Case {
    std::uint64_t seed;
    double rate, damping;
  };
  for (const Case& c :
       {Case{1, 1000, 0}, Case{2, 1000, 0}, Case{3, 500, 3}, Case{4, 2000, 3}, Case{5, 4000, 3}, Case{6, 4000, 0}}) {
    ServoSettings settings = implant_settings();
    settings.tick = 1 / c.rate, settings.damping = c.damping;
    ImplantSession s(bone_block(), settings);
    s.take(kPilot);
    s.land();
    ASSERT_TRUE(s.drill(4, 3, 300000));
    s.withdraw();
    s.take(c.seed % 2 == 0 ? kGauge22 : kTwist28);
    std::mt19937_64 random(c.seed);
    const auto any = [&](double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random); };
    dvec3 p(0, 0, 3), goal = p, force(0), tilt(0), tilt_goal(0);  // mm, N, rad about x and y
    Pose last = s.tick.X_WT;
    std::uint32_t level = kHigh;
    int switches = 0;
    double before = 0;  // N, step of the force in the last tick
    const int per_goal = static_cast<int>(0.3 * c.rate);
    for (int i = 0; i < 40 * per_goal; ++i) {
      if (i % per_goal == 0) {
        goal = dvec3(any(-0.6, 0.6), any(-0.6, 0.6), i / per_goal % 2 == 0 ? any(-5, -0.5) : any(0.2, 2));
        tilt_goal = 9 * kDegree * dvec3(any(-0.7, 0.7), any(-0.7, 0.7), 0);
      }
      p += 10 / c.rate * (goal - p);
      tilt += 10 / c.rate * (tilt_goal - tilt);
      const double angle = glm::length(tilt);
      const dquat R = angle > 0 ? glm::angleAxis(angle, tilt / angle) : dquat(1, 0, 0, 0);
      s.tip_at(p, std::fmod(i / c.rate, 1) < 0.6 ? 1 : 0, R);
      if ((s.tick.level == kHigh) != (level == kHigh)) {
        ++switches;
        // On a rim, a rotation of the hand lifts the end by more.
        EXPECT_LE(glm::length(s.tick.f_T_W - force), 0.02 + 1.5 * effect_of(s, last, c.damping) + before)
            << "seed " << c.seed << ", " << c.rate << " Hz, tick " << i;
      }
      before = glm::length(s.tick.f_T_W - force);
      level = s.tick.level, force = s.tick.f_T_W, last = s.tick.X_WT;
    }
    EXPECT_GT(switches, 10) << c.seed;
  }
}

TEST(ImplantModel, ASteadyHandFeelsNoStepWhenAGaugeEntersItsBedFromTheRimAndSlidesInIt) {
  for (const auto& [rate, gauge_mm] :
       {std::pair{500.0, 2.35}, {500.0, 1.7}, {1000.0, 2.2}, {2000.0, 1.7}, {4000.0, 2.3}}) {
    {
      std::vector<Tool> tools = implant_tools();
      tools[kGauge22] = implant_tool("gauge", gauge_mm, 10, R"({"kind": "gauge"})");
      ServoSettings settings = implant_settings(R"("implant")", tools);
      settings.tick = 1 / rate, settings.stiffness = 1000, settings.damping = 2;
      ImplantSession s(bone_block(0.2, 0.3), settings);
      s.land_with(kPilot);
      ASSERT_TRUE(s.drill(5, 3, 300000));
      s.withdraw();
      s.take(kGauge22);
      Pose last;
      dvec3 force(0);
      double worst = 0;  // N, largest step beyond the effect of the hand's own motion
      int in_bed = 0;
      for (double t = 0; t < 2.5; t += s.period) {
        const double down = t < 0.4 ? 1 - 3 * t : t < 1.2 ? -0.2 - 4 * (t - 0.4) : -3.4 - std::sin(4 * (t - 1.2));
        s.tip_at({0.08 + (t < 1.2 ? 0 : 0.1 * std::sin(5 * (t - 1.2))), -0.05, down});
        if (t > s.period) {
          worst = std::max(worst, glm::length(s.tick.f_T_W - force) - effect_of(s, last, settings.damping));
        }
        in_bed += s.tick.level != kHigh;
        last = s.tick.X_WT, force = s.tick.f_T_W;
      }
      EXPECT_LT(worst, 0.02) << gauge_mm << " mm, " << rate << " Hz";
      EXPECT_GT(in_bed * s.period, 1.3) << gauge_mm;
    }
  }
}

}  // namespace
}  // namespace typodont::haptics::implant
