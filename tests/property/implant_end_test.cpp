// Tests of the cutting law over the voxels in front of a tool's end, at one pose.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "engine/base/units.h"
#include "engine/base/voxels.h"
#include "haptics/contact/implant/end_voxels.h"
#include "haptics/dense_tissue.h"
#include "tests/support/implant_bench.h"

namespace typodont::haptics::implant {
namespace {

constexpr double kVoxel = 0.15e-3;  // m
constexpr int kEdge = 64;           // voxels

/// Computes the sums of scan_end() voxel by voxel, with the volume's sampler and the rounding of the standard
/// library.
EndScan summed_one_by_one(const ToolVoxels& voxels, const TissuePatch& patch, const EndLaw& law, const dvec3& center,
                          const dquat& R_WT) {
  EndScan scan;
  const double h = law.voxel, per_voxel = 1 / h;
  const glm::dmat3 R = glm::mat3_cast(R_WT) * per_voxel;
  const dvec3 ahead = R_WT * dvec3(0, 0, -1);
  double drag = 0, turning = 0, rim = 0;
  const auto radius = [](const ToolVoxel& v) { return static_cast<double>(std::hypot(v.p.x, v.p.y)); };
  for (std::size_t i = 0; i < voxels.ahead; ++i) rim = std::max(rim, radius(voxels.outer[i]) - voxels.edge);
  for (std::size_t i = 0; i < voxels.ahead; ++i) {
    const ToolVoxel& v = voxels.outer[i];
    const dvec3 p = center + R * dvec3(v.p);
    const double field = sample_linear(patch, p), gap = field * h + static_cast<double>(v.outside);
    if (!(gap < h)) continue;
    const glm::ivec3 beyond = glm::ivec3(glm::round(p + 1.5 * ahead)) - patch.lo;
    const std::size_t at = patch.at(beyond.x, beyond.y, beyond.z);
    const Tissue tissue = shown(patch.tissue[at]);
    const double in_bone = radius(v) > rim ? -0.05 : 0;
    if (sample_linear(patch, p + 1.5 * ahead) >= in_bone || tissue == Tissue::kAir) continue;
    const double hardness = patch.hardness.empty() ? 1 : hardness_fraction(felt_hardness(patch, at));
    const auto t = static_cast<std::size_t>(tissue);
    const double grey = law.grey[t] + law.grey_per_hardness[t] * hardness;
    const double area = static_cast<double>(v.area) * (1 - std::pow(std::max(gap * per_voxel, 0.0), 2));
    scan.engaged += area;
    scan.max_grey = std::max(scan.max_grey, grey);
    scan.tissue[t] += area;
    scan.hardness[t] += area * hardness;
    if (law.cuts && v.ability > 0 && grey <= law.max_grey) {
      const double u = law.energy[t] * hardness / static_cast<double>(v.ability);
      const double facing = -static_cast<double>(v.n.z), cut = u * facing * area * (1 / std::abs(law.speed));
      drag += cut * facing * static_cast<double>(v.inverse_r);
      turning += cut;
    } else if (std::hypot(v.p.x, v.p.y) <= static_cast<float>(law.width)) {
      scan.free = std::min(scan.free, std::max(gap, 0.0));
      if (gap <= 0.25 * h) scan.collided += area;
    }
  }
  scan.wrench.force.z = drag / law.thrust_ratio;
  scan.wrench.torque.z = law.speed < 0 ? turning : -turning;
  return scan;
}

/// Returns a rough floor of bone at about z = `height` (voxels). If `mixed` is true, tissues, fillings and hardness
/// vary from voxel to voxel.
TissuePatch floor_of_bone(double height, bool graded, bool mixed, std::mt19937& random) {
  std::uniform_real_distribution<float> rough(-0.3f, 0.3f);
  std::uniform_int_distribution<int> any(0, 255);
  TissuePatch patch;
  patch.resize(kEdge);
  patch.lo = {-40, -30, -50};
  if (graded) patch.grade();
  for_each_voxel(glm::ivec3(kEdge), [&](int x, int y, int z) {
    const std::size_t at = patch.at(x, y, z);
    patch.distance[at] = static_cast<float>(z + patch.lo.z - height) + rough(random);
    Tissue tissue = mixed && any(random) % 4 == 0 ? Tissue::kCorticalBone : Tissue::kCancellousBone;
    if (mixed && any(random) % 16 == 0) tissue = filled(tissue, Tissue::kAmalgam);
    patch.tissue[at] = patch.distance[at] > 1 ? Tissue::kAir : tissue;
    if (graded) patch.hardness[at] = static_cast<std::uint8_t>(mixed ? std::max(any(random), 1) : 204);
  });
  return patch;
}

EndLaw law_of(const Tool& tool, bool cuts) {
  EndLaw law;
  law.voxel = kVoxel;
  law.width = tool.radius() - kVoxel;
  law.cuts = cuts;
  law.max_grey = tool.implant->max_grey;
  law.speed = 80;
  law.thrust_ratio = 12;
  for (std::size_t t = 1; t < law.energy.size(); ++t) law.energy[t] = 1e8 * static_cast<double>(t);
  law.grey_per_hardness.fill(1250);
  law.grey_per_hardness[static_cast<std::size_t>(Tissue::kCorticalBone)] = 1650;
  law.grey[static_cast<std::size_t>(Tissue::kAmalgam)] = 10000;
  law.grey_per_hardness[static_cast<std::size_t>(Tissue::kAmalgam)] = 0;
  return law;
}

TEST(ImplantEnd, BlocksOfVoxelsInFloatsGiveTheSumVoxelByVoxelWithinAThousandth) {
  std::mt19937 random(28);
  std::uniform_real_distribution<double> unit(-1, 1);
  const Tool tools[] = {
      test::implant_tool("drill", 4.2, 5, test::drill_block(0, 1)),
      test::implant_tool("widening drill", 3.5, 5, test::drill_block(2.6, 0, 1300)),
      test::implant_tool("gauge", 2.2, 5, R"({"kind": "gauge"})"),
      test::implant_tool("round", 2.3, 0, R"({"kind": "round", "ability": {"end": 1, "side": 1}})", "sphere")};
  int in_contact = 0, stopped = 0;
  for (const Tool& tool : tools) {
    const ToolVoxels voxels = make_tool_voxels(tool, 0.06e-3);
    const EndVoxels end(voxels);
    for (int round = 0; round < 24; ++round) {
      const TissuePatch patch = floor_of_bone(-35, round % 2 == 0, round % 4 >= 2, random);
      EndLaw law = law_of(tool, round % 3 != 0);
      if (round % 5 == 0) law.speed = -law.speed;
      const dvec3 center(unit(random) * 4 - 8, unit(random) * 4 + 2, -35 + tool.half() / kVoxel + 1.5 * unit(random));
      const dquat R = glm::normalize(dquat(1, 0.1 * unit(random), 0.1 * unit(random), unit(random)));
      const EndScan slow = summed_one_by_one(voxels, patch, law, center, R);
      // A voxel may count differently if rounding decides its contact or its nearest sample. Here this is one voxel in
      // a thousand.
      const EndScan floats = scan_end(end, patch, law, center, R);
      const auto near = [&](double a, double b, double whole) {
        EXPECT_NEAR(a, b, 1e-3 * whole + 1e-15) << tool.name << ", round " << round;
      };
      near(floats.engaged, slow.engaged, slow.engaged);
      near(floats.collided, slow.collided, slow.engaged);
      near(floats.max_grey, slow.max_grey, slow.max_grey);
      if (slow.free < 1) near(floats.free, slow.free, kVoxel);
      for (std::size_t t = 0; t < kTissueCount; ++t) {
        near(floats.tissue[t], slow.tissue[t], slow.engaged);
        near(floats.hardness[t], slow.hardness[t], slow.engaged);
      }
      near(floats.wrench.force.z, slow.wrench.force.z, glm::length(slow.wrench.force));
      near(floats.wrench.torque.z, slow.wrench.torque.z, glm::length(slow.wrench.torque));
      in_contact += floats.engaged > 0;
      stopped += floats.collided > 0;
    }
  }
  EXPECT_GT(in_contact, 60);
  EXPECT_GT(stopped, 20);
}

TEST(ImplantEnd, AnEndOfMergedVoxelsKeepsItsAreaAndThrustAndIsEvaluatedWithinOnePercent) {
  std::mt19937 random(282);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (const double diameter : {2.2, 2.8, 4.2}) {
    const Tool tool =
        test::implant_tool("drill", diameter, 5, test::drill_block(diameter > 4 ? 3.3 : 0, diameter <= 4));
    const ToolVoxels voxels = make_tool_voxels(tool, 0.06e-3);
    const EndVoxels fine(voxels), merged(voxels, kVoxel), as_fine(voxels, 0.1e-3);
    EXPECT_LT(merged.count, fine.count / 2) << diameter;
    EXPECT_EQ(as_fine.x, fine.x) << "merged voxels of 0.12 mm would be coarser than the tissue's";
    for (int round = 0; round < 24; ++round) {
      TissuePatch patch = floor_of_bone(-35, true, false, random);
      // rad per voxel of a wave in the hardness; the wave's amplitude is two fifths
      const double wave = 0.2 + 0.3 * std::abs(unit(random));
      for_each_voxel(glm::ivec3(kEdge), [&](int x, int y, int z) {
        patch.hardness[patch.at(x, y, z)] =
            static_cast<std::uint8_t>(150 + 60 * std::sin(wave * x) * std::cos(wave * (y + z)));
      });
      const EndLaw law = law_of(tool, true);
      const dvec3 center(unit(random) * 4 - 8, unit(random) * 4 + 2, -35.3 + tool.half() / kVoxel + 0.2 * unit(random));
      const dquat R = glm::normalize(dquat(1, 0.02 * unit(random), 0.02 * unit(random), unit(random)));
      const EndScan a = scan_end(fine, patch, law, center, R), b = scan_end(merged, patch, law, center, R);
      ASSERT_GT(a.engaged, 0);
      EXPECT_NEAR(b.engaged / a.engaged, 1, 5e-3) << diameter << " mm, round " << round;
      EXPECT_NEAR(b.wrench.force.z / a.wrench.force.z, 1, 1e-2) << diameter << " mm, round " << round;
      EXPECT_NEAR(b.wrench.torque.z / a.wrench.torque.z, 1, 1e-2) << diameter << " mm, round " << round;
      EXPECT_NEAR(b.max_grey / a.max_grey, 1, 2e-2) << diameter << " mm, round " << round;
    }
  }
}

}  // namespace
}  // namespace typodont::haptics::implant
