// Tests filling: composite is put into a cavity, felt while it grows, and removed again.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <tuple>

#include "engine/base/units.h"
#include "engine/base/voxels.h"
#include "haptics/cutting/carve.h"
#include "tests/support/campaign.h"
#include "tests/support/folder.h"
#include "tests/support/haptic_bench.h"
#include "tests/support/no_alloc.h"

namespace typodont {
namespace {

using namespace literals;
using haptics::Fill;
using haptics::HeadShape;
using haptics::ServoSettings;
using haptics::Sweep;
using haptics::Tool;
using test::HapticBench;

constexpr std::size_t kFilled = static_cast<std::size_t>(Tissue::kComposite);

/// A block of dentin with a round cavity, 3 mm wide and 2.5 mm deep. Its opening is at z = 2 mm.
constexpr const char* kCavity = R"({"voxel_mm": 0.1, "solids": [{"tissue": "dentin", "solid": {"difference": [
  {"box": {"size_mm": [7,7,4]}}, {"cylinder": {"center_mm": [0,0,1.5], "axis": [0,0,1], "radius_mm": 1.5, "height_mm": 4}}]}}]})";

Tool condenser(double rate_mm3 = 2) {
  Tool tool;
  tool.shape = HeadShape::kRoundEndCylinder;
  tool.diameter = 1.0_mm;
  tool.length = 3.0_mm;
  tool.cuts = false;
  tool.fill = Tissue::kComposite;
  tool.fill_rate = rate_mm3 * kCubicMillimetre;
  tool.fill_reach = 0.6_mm;
  return tool;
}

ServoSettings filling() {
  ServoSettings s;
  Tool bur;
  bur.diameter = bur.length = 1.2_mm;
  s.tools = {condenser(), bur};
  s.tool = s.tools[0];
  s.friction = false;
  s.spindle.free_speed = 300.0_krpm;
  return s;
}

/// Returns the pose of the instrument whose end is at height z in the cavity. The cavity's floor is at -0.5 mm.
Pose end_at(double x, double z) {
  return {{x, 0, z + 1.5_mm}, {1, 0, 0, 0}};
}

void hold(HapticBench& bench, int ticks, const Pose& X_WT, double pedal, std::uint32_t tool = 0) {
  for (int i = 0; i < ticks; ++i) bench.tick(X_WT, pedal, tool);
}

TEST(Filling, TheVolumeThatThePedalRequestsIsAddedWithEveryInstrumentAtRestOrMoving) {
  std::mt19937_64 random(23);
  const auto uniform = [&](double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random); };
  for (int round = 0; round < test::campaign(12); ++round) {
    ServoSettings s = filling();
    Tool& tool = s.tools[0];
    constexpr HeadShape kShapes[] = {HeadShape::kRoundEndCylinder, HeadShape::kCylinder, HeadShape::kSphere};
    tool.shape = kShapes[round % 3];
    tool.diameter = uniform(0.5, 1.4) * kMillimetre;
    if (tool.shape == HeadShape::kSphere) tool.length = tool.diameter;
    tool.fill_reach = uniform(0.3, 1.2) * kMillimetre;
    tool.fill_rate = uniform(1, 8) * kCubicMillimetre;
    s.tool = tool;
    s.tick = round % 2 ? 1e-3 : 2.5e-4;
    HapticBench bench(kCavity, s);
    const double aside = 1.4_mm - tool.radius(), speed = round % 4 ? uniform(0.1, 2) * 1e-3 : 0, turned = uniform(0, 6);
    const double z = -0.5_mm + uniform(0.02_mm, 0.6 * tool.fill_reach) + tool.half();
    const double seconds = std::min(0.5, 6.0 * kCubicMillimetre / tool.fill_rate);  // of 18 mm³ that the cavity holds
    const auto at = [&](double t) {
      return Pose{{aside * std::cos(turned + speed * t / 1e-3), aside * std::sin(turned + speed * t / 1e-3), z}};
    };
    for (int i = 0; i < 20; ++i) bench.tick(at(0), 0);
    EXPECT_EQ(bench.last.removed[kFilled], 0) << round;
    const double pedal = round % 3 ? 1 : 0.5;
    double asked = 0;
    std::uint32_t faults = 0;
    for (double t = 0; t < seconds; t += s.tick) {
      faults |= bench.tick(at(t), pedal).faults;
      asked += pedal * s.tick * tool.fill_rate;
    }
    double put = 0;
    for (const double v : bench.last.removed) put -= v;
    EXPECT_NEAR(put / asked, 1, 0.02) << round;
    EXPECT_EQ(faults & bits(Fault::kNoRoom), 0u) << round;
    const double there = bench.last.removed[kFilled];
    hold(bench, 50, at(seconds), 0);
    EXPECT_EQ(bench.last.removed[kFilled], there) << round;
  }
}

TEST(Filling, MaterialWithoutRoomIsReportedAndCrossesNoWall) {
  // The instrument nearly fills the pit. The sides of the block are two millimetres away.
  ServoSettings s = filling();
  s.tools[0].fill_within = s.tool.fill_within =
      haptics::read_solid(Json::parse(R"({"box": {"center_mm": [0, 0, -5], "size_mm": [40, 40, 14]}})", "within"));
  HapticBench bench(
      R"({"voxel_mm": 0.1, "domain_mm": [[-4,-4,-4],[4,4,4]], "solids": [{"tissue": "dentin", "solid": {"difference": [
    {"box": {"size_mm": [5,5,4]}}, {"cylinder": {"center_mm": [0,0,1.5], "axis": [0,0,1], "radius_mm": 0.9, "height_mm": 3}}]}}]})",
      s);
  std::uint32_t faults = 0;
  for (int i = 0; i < 3000; ++i) faults |= bench.tick(end_at(0, 0.3_mm), 1).faults;
  const double pit = kPi * 0.81 * 2;  // mm³
  EXPECT_TRUE(faults & bits(Fault::kNoRoom));
  EXPECT_TRUE(bench.last.faults & bits(Fault::kNoRoom));
  EXPECT_LT(-bench.last.removed[kFilled] / kCubicMillimetre, pit - kPi * 0.25 * 1.5);
  EXPECT_GT(-bench.last.removed[kFilled] / kCubicMillimetre, 0.6 * (pit - kPi * 0.25 * 1.7));
  hold(bench, 3, end_at(0, 0.3_mm), 0);
  EXPECT_EQ(bench.last.faults, 0u);
}

TEST(Filling, AnInstrumentMovedInItsOwnFillingFeelsNoForceStep) {
  std::mt19937_64 random(31);
  const auto uniform = [&](double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random); };
  double felt = 0;
  for (int round = 0; round < test::campaign(8); ++round) {
    ServoSettings s = filling();
    Tool& tool = s.tools[0];
    tool.shape = round % 2 ? HeadShape::kCylinder : HeadShape::kRoundEndCylinder;
    tool.diameter = uniform(0.8, 1.5) * kMillimetre;
    tool.fill_reach = uniform(0.6, 1.2) * kMillimetre;
    tool.fill_rate = uniform(3, 8) * kCubicMillimetre;
    s.tool = tool;
    s.tick = round % 4 < 2 ? 1e-3 : 2.5e-4;
    s.friction = true;
    HapticBench bench(kCavity, s);
    const double aside = uniform(0.3, 0.9) * (1.45_mm - tool.radius()), turned = uniform(0, 6),
                 speed = uniform(0.5, 2) * kMillimetre;
    const double z = -0.5_mm + uniform(0.05, 0.5) * tool.fill_reach + tool.half();
    const auto at = [&](double t) {
      const double a = turned + speed * t / aside;
      return Pose{{aside * std::cos(a), aside * std::sin(a), z}};
    };
    for (int i = 0; i < 20; ++i) bench.tick(at(0), 0);
    for (double t = 0; t < 0.6; t += s.tick) {
      const dvec3 before = bench.last.f_T_W;
      bench.tick(at(t), 1);
      ASSERT_LT(glm::length(bench.last.f_T_W - before), 0.02) << round << " at " << t;
      felt = std::max(felt, glm::length(bench.last.f_T_W));
    }
    EXPECT_LT(bench.last.removed[kFilled], 0) << round;
  }
  EXPECT_GT(felt, 0.1);
}

TEST(Filling, NothingIsAddedAwayFromTissue) {
  HapticBench bench(kCavity, filling());
  hold(bench, 200, end_at(0, 1.2_mm), 1);  // in the middle of the cavity, 1.5 mm from every wall
  EXPECT_EQ(bench.last.removed[kFilled], 0);
  EXPECT_EQ(bench.last.cuts, 0u);
  EXPECT_TRUE(bench.last.faults & bits(Fault::kNoRoom));
}

TEST(Filling, ReleasesEveryHeadAlongItsAxisAfterAnyTime) {
  for (const auto& [shape, diameter, length] :
       {std::tuple(HeadShape::kSphere, 0.8_mm, 0.8_mm), std::tuple(HeadShape::kPear, 0.9_mm, 1.8_mm),
        std::tuple(HeadShape::kInvertedCone, 1.0_mm, 1.0_mm), std::tuple(HeadShape::kFlame, 1.0_mm, 2.4_mm)}) {
    ServoSettings s = filling();
    s.tool.shape = s.tools[0].shape = shape;
    s.tool.diameter = s.tools[0].diameter = diameter;
    s.tool.length = s.tools[0].length = length;
    s.tool.fill_rate = s.tools[0].fill_rate = 6 * kCubicMillimetre;
    HapticBench bench(kCavity, s);
    double z = -0.4_mm + length / 2;
    hold(bench, 800, {{0.3_mm, 0.1_mm, z}}, 1);
    EXPECT_LT(bench.last.removed[kFilled], -0.03_mm3);
    for (int i = 0; i < 600; ++i) {
      z += 5e-6;
      bench.tick({{0.3_mm, 0.1_mm, z}}, 0);
      ASSERT_LT(glm::length(bench.last.f_T_W), 0.03) << static_cast<int>(shape) << " " << i;
    }
  }
}

TEST(Filling, NeverLeavesItsBoundingSolid) {
  ServoSettings s = filling();
  // The rim of the cavity is half a millimetre above the tool's end. Filling does not flow over the rim.
  s.tools[0].fill_within = s.tool.fill_within =
      haptics::read_solid(Json::parse(R"({"box": {"center_mm": [0, 0, -5], "size_mm": [40, 40, 10.2]}})", "within"));
  HapticBench bench(kCavity, s), free_bench(kCavity, filling());
  const auto highest = [](const HapticBench& b) {
    const haptics::TissuePatch& patch = b.patch();
    double top = -1;
    for_each_voxel(glm::ivec3(patch.n), [&](int x, int y, int z) {
      const glm::ivec3 p(x, y, z);
      const std::size_t i = patch.at(p.x, p.y, p.z);
      if (patch.distance[i] < 0 && haptics::shown(patch.tissue[i]) == static_cast<Tissue>(kFilled))
        top = std::max(top, b.settings.frame.to_world(dvec3(patch.lo + p)).z);
    });
    return top;
  };
  hold(bench, 800, end_at(0.5_mm, 0.0_mm), 1);
  hold(free_bench, 800, end_at(0.5_mm, 0.0_mm), 1);
  EXPECT_LE(highest(bench), 0.1_mm);
  EXPECT_GT(highest(free_bench), 0.2_mm);
  EXPECT_LT(bench.last.removed[kFilled], 0) << "but inside it does";
}

TEST(Filling, IsFeltWithItsOwnStiffness) {
  ServoSettings s = filling();
  HapticBench bench(kCavity, s);
  hold(bench, 1000, end_at(0.4_mm, 0.0_mm), 1);
  hold(bench, 20, end_at(0.4_mm, 0.0_mm), 0);
  for (int i = 0; i < 300; ++i) bench.tick(end_at(0.4_mm, -i * 1e-6), 0);  // 0.3 mm down, onto the filling
  hold(bench, 100, end_at(0.4_mm, -0.3_mm), 0);
  EXPECT_EQ(bench.last.tissue, Tissue::kComposite);
  EXPECT_NEAR(glm::length(bench.last.f_T_W),
              1000 * bench.settings.materials[kFilled].stiffness / 1000 * bench.last.depth,
              0.05 * glm::length(bench.last.f_T_W));
  EXPECT_GT(glm::length(bench.last.f_T_W), 0.1);
}

TEST(Filling, CanBeCutOutAgainByTheWorkOfABursMotor) {
  HapticBench bench(kCavity, filling());
  hold(bench, 1000, end_at(0.2_mm, 0.0_mm), 1);
  hold(bench, 20, end_at(0.2_mm, 0.0_mm), 0);
  const double filled = -bench.last.removed[kFilled];
  for (int i = 0; i < 200; ++i) bench.tick({{0, 0, 1.5_mm + 0.02_mm * i}, {1, 0, 0, 0}}, 0, 1);
  ASSERT_EQ(bench.last.tool, 1u);
  double work = 0;  // J
  for (int i = 0; i < 3000; ++i) {
    bench.tick({{0.2_mm, 0, std::max(5.4_mm - i * 5e-6, -0.3_mm)}, {1, 0, 0, 0}}, 1, 1);
    work += bench.last.cutting_power * bench.settings.tick;
  }
  const double removed = bench.last.removed[kFilled] + filled;
  EXPECT_GT(removed, 0.08 * filled);
  EXPECT_NEAR(removed, work / bench.settings.materials[kFilled].specific_energy, 0.02 * removed);
}

TEST(Filling, TheWallOfAFilledAndEmptiedCavityFeelsUnchanged) {
  const auto feel = [](bool filled, const dvec3& toward) {
    ServoSettings s = filling();
    Tool probe;
    probe.diameter = probe.length = 0.6_mm;
    probe.cuts = false;
    s.tools.push_back(probe);
    s.damping = 0;
    HapticBench bench(kCavity, s);
    std::uint64_t index = 0;
    const auto drill = [&](double to) {  // a pit in the floor, 1.2 mm wide
      bench.carver.apply(
          {++index, 0, static_cast<Nanos>(index), {{0.3_mm, 0, 2.0_mm}}, {{0.3_mm, 0, to}}, 1, {}, {}, 0});
    };
    drill(-0.1_mm);
    if (filled) {
      for (int i = 0; i < 3; ++i) {
        bench.carver.apply({++index,
                            0,
                            static_cast<Nanos>(index),
                            {{0.3_mm, 0, -0.6_mm + i * 0.2_mm}},
                            end_at(0.3_mm, 1.0_mm),
                            0,
                            {},
                            {},
                            0,
                            0.4_mm});
      }
      EXPECT_GT(bench.carver.volume().volumes()[kFilled], 0.2_mm3);
    }
    drill(-0.13_mm);
    const dvec3 start(0.3_mm, 0, 0.1_mm);
    bench.tick({start}, 0, 2);
    EXPECT_EQ(bench.last.tool, 2u);
    for (int i = 0; i < 400; ++i) bench.tick({start + i * 2e-6 * toward}, 0, 2);
    EXPECT_EQ(bench.last.tissue, Tissue::kDentin);
    EXPECT_GT(glm::length(bench.last.f_T_W), 0.02);
    return glm::length(bench.last.f_T_W) / bench.last.depth;
  };
  for (const dvec3& toward : {dvec3(0, 0, -1), dvec3(0.6, 0, -0.8), dvec3(-0.5, 0.5, -0.7)}) {
    EXPECT_NEAR(feel(true, toward), 500, 0.01);
    EXPECT_NEAR(feel(false, toward), 500, 0.01);
  }
}

TEST(Filling, FillingAndEmptyingRestoresTheLabelsAlsoAfterUndoAndFromAFile) {
  const Tool plugger = condenser();
  Tool bur;
  std::mt19937_64 random(11);
  const auto uniform = [&](double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random); };
  const auto everything = [](const haptics::TissueVolume& volume) {
    glm::ivec3 lo, hi;
    volume.bounds(lo, hi);
    std::vector<Tissue> labels(static_cast<std::size_t>((hi.x - lo.x + 1) * (hi.y - lo.y + 1) * (hi.z - lo.z + 1)));
    volume.copy_for_patch(lo, hi - lo + 1, nullptr, labels.data());
    return labels;
  };
  // A block of enamel over dentin, with a pocket that reaches into both.
  constexpr const char* kLayers =
      R"({"voxel_mm": 0.1, "solids": [{"tissue": "enamel", "solid": {"box": {"size_mm": [4,4,3]}}},
    {"tissue": "dentin", "solid": {"box": {"center_mm": [0,0,-0.5], "size_mm": [4,4,2]}}}]})";
  for (int round = 0; round < 6; ++round) {
    haptics::TissueVolume volume(haptics::read_solids(Json::parse(kLayers, "layers")));
    bur.diameter = bur.length = uniform(0.8, 1.4) * kMillimetre;
    const Pose a{dvec3(uniform(-1, 1), uniform(-1, 1), 1.2) * kMillimetre},
        b{dvec3(uniform(-1, 1), uniform(-1, 1), 0.1) * kMillimetre};
    const Sweep pocket(bur, a, b, volume.frame());
    volume.begin_stroke();
    volume.carve(pocket);
    const std::vector<Tissue> cavity = everything(volume);
    const PerTissue left = volume.volumes();
    volume.begin_stroke();
    for (int i = 0; i < 12; ++i) {
      const dvec3 at = glm::mix(a.p, b.p, uniform(0, 1)) + uniform(-0.3, 0.3) * dvec3(1e-3, 1e-3, 0);
      volume.fill(Fill(plugger, at, uniform(0.05, 0.6) * kMillimetre, {{0, 0, 9.0_mm}}, volume.frame()));
    }
    const std::vector<Tissue> filled = everything(volume);
    ASSERT_GT(volume.volumes()[kFilled], 0);
    ASSERT_NE(filled, cavity);

    const test::Folder folder;
    volume.save(folder / "filled.vdb");
    haptics::TissueVolume loaded = haptics::TissueVolume::load(folder / "filled.vdb");
    EXPECT_TRUE(everything(loaded) == filled);
    loaded.begin_stroke();
    // All filling is removed, together with some of the surrounding tissue.
    bur.diameter = bur.length = bur.diameter + 0.02_mm;
    const Sweep wider(bur, a, b, volume.frame());
    haptics::TissueVolume never(haptics::read_solids(Json::parse(kLayers, "layers")));
    never.carve(pocket);
    never.carve(wider);
    const auto empty = [&](haptics::TissueVolume& v) {
      v.begin_stroke();
      for (int i = 0; i < 20; ++i) {  // filling above the pocket or beside it
        for (int k = 0; k < 20; ++k) {
          bur.diameter = bur.length = 1.6_mm;
          const Pose p{dvec3(-1.9 + 0.2 * i, -1.9 + 0.2 * k, 2.2) * kMillimetre};
          v.carve(Sweep(bur, p, p, v.frame()));
        }
      }
      v.carve(pocket);
      v.carve(wider);
      v.end_stroke();
    };
    empty(volume), empty(loaded), empty(never);
    EXPECT_TRUE(everything(volume) == everything(never)) << round;
    EXPECT_TRUE(everything(loaded) == everything(never)) << round;
    EXPECT_EQ(volume.volumes()[kFilled], 0) << round;
    ASSERT_TRUE(volume.undo());
    EXPECT_TRUE(everything(volume) == filled);
    ASSERT_TRUE(volume.undo());
    EXPECT_TRUE(everything(volume) == cavity);
    EXPECT_EQ(volume.volumes(), left);
  }
}

TEST(Filling, ATickAllocatesNothing) {
  HapticBench bench(kCavity, filling());
  hold(bench, 20, end_at(0.2_mm, 0), 1);
  ServoTick out;
  Cut cut;
  test::NoAlloc guard;
  for (int i = 0; i < 50; ++i) bench.servo.tick({bench.t + i * 1000000, end_at(0.2_mm, 0), 1.0}, out, cut);
  EXPECT_EQ(guard.count(), 0u);
  EXPECT_GT(out.cuts, 30u);
}

}  // namespace
}  // namespace typodont
