// Test of table S2 with scenes: reaming the shipped socket with 200 N at 1 kHz and layers 1.5 : 1 : 0.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <vector>

#include "engine/base/units.h"
#include "engine/base/voxels.h"
#include "haptics/contact_method.h"
#include "haptics/import/mesh_solid.h"
#include "tests/support/haptic_bench.h"

namespace typodont::haptics {
namespace {

using namespace literals;

using test::HapticBench;

ServoSettings settings(const char* model, double diameter) {
  ServoSettings s;
  s.tool.diameter = s.tool.length = diameter;
  s.spindle.free_speed = 300.0_krpm;
  s.friction = false;
  for (Material& m : s.materials) m.stiffness = 1000, m.specific_energy = 8e9;
  s.method = read_contact_method(Json::parse(model, "model"));
  return s;
}

/// Distance field of a whole volume, in voxels.
struct Field {
  glm::ivec3 lo, size;
  std::vector<float> distance;
  explicit Field(const TissueVolume& volume) {
    glm::ivec3 hi;
    volume.bounds(lo, hi);
    *this = Field(volume, lo, hi - lo + 1);
  }
  Field(const TissueVolume& volume, const glm::ivec3& from, const glm::ivec3& extent) : lo(from), size(extent) {
    distance.resize(static_cast<std::size_t>(size.x) * size.y * size.z);
    volume.copy(lo, size, distance.data(), nullptr);
  }
};

TEST(Reaming, TheReamedSocketDiffersFromAnAnalyticCupByAtMostTwoPercentOfItsVolume) {
  SolidFiles files;
  files.read_mesh = [](const std::filesystem::path& file, double unit) { return read_mesh_solid(file, unit); };
  TissueVolume tissue(read_solids(
      Json::parse(R"({"voxel_mm": 1, "band_mm": 4, "solids": [{"tissue": "cancellous_bone", "solid": {"mesh": {"file":
      "assets/hip/acetabulum.ply", "scale": 1}}}]})",
                  "assets"),
      files));
  const VoxelFrame frame = tissue.frame();
  const Field before(tissue);
  const ServoSettings reamer = settings(R"({"packing": {"spheres": 20000, "speed_mm_per_s": 20}})", 56.0_mm);
  HapticBench run(std::move(tissue), reamer, reamer.materials);
  const dvec3 end(0, 0, -3.0_mm);
  for (int i = 0; i < 700; ++i) run.tick({end + dvec3(0, 0, std::max(0.0, 8.0_mm - i * 0.03_mm)), {1, 0, 0, 0}}, 1);
  const Field after(run.carver.volume(), before.lo, before.size);
  // The cup that should be removed is a ball of 28 mm, swept along the path on which the reamer is withdrawn.
  double wanted = 0, over = 0, under = 0;
  const auto fraction = [](double d) { return std::clamp(0.5 - d, 0.0, 1.0); };
  std::size_t i = 0;
  for_each_voxel(before.size, [&](int x, int y, int z) {
    const glm::ivec3 voxel(x, y, z);
    const dvec3 p = frame.to_world(dvec3(before.lo + voxel));
    const dvec3 axis(0, 0, std::max(p.z, end.z));
    const double cup = (28.0_mm - glm::distance(p, axis)) / frame.voxel;
    const double had = fraction(static_cast<double>(before.distance[i])),
                 has = fraction(static_cast<double>(after.distance[i]));
    const double ideal = fraction(std::max(static_cast<double>(before.distance[i]), cup));
    wanted += had - ideal;
    over += std::max(0.0, ideal - has);
    under += std::max(0.0, has - ideal);
    ++i;
  });
  const double voxel = std::pow(frame.voxel, 3);
  EXPECT_GT(wanted * voxel, 2500.0_mm3);
  EXPECT_LT(over / wanted, 0.02);
  EXPECT_LT(under / wanted, 0.02);
}

TEST(Reaming, At200NewtonsAnd1KilohertzTheLedgerNeverFallsBelowANanojoule) {
  ServoSettings s = settings(R"({"packing": {"spheres": 6000}})", 44.0_mm);
  s.stiffness = 60e3, s.damping = 20;
  s.force_limit = 250, s.torque_limit = 10;
  s.spindle.free_speed = 0.3_krpm;
  for (Material& m : s.materials) m.specific_energy = 1e9;
  for (const bool reams : {false, true}) {
    HapticBench run(
        R"({"voxel_mm": 1, "band_mm": 4, "solids": [{"tissue": "cancellous_bone", "solid": {"box": {"size_mm": [40, 40, 24]}}}]})",
        s, s.materials);
    double most = 0;
    for (int i = 0; i < 4000; ++i) {
      // Presses and releases three times, with a tremor of 9 Hz.
      const double deep = 3.3_mm * std::pow(std::sin(kPi * i / 1333.0), 2) + 0.1_mm * std::sin(2 * kPi * 9 * i * 1e-3);
      run.tick({dvec3(0, 0, std::max(34.5_mm - i * 0.01_mm, 34.0_mm - deep)), {1, 0, 0, 0}}, reams ? 1 : 0);
      ASSERT_GE(run.last.energy, -1e-9) << reams << " " << i;
      ASSERT_TRUE(is_finite(run.last.f_T_W));
      most = std::max(most, glm::length(run.last.f_T_W));
    }
    if (!reams) {
      EXPECT_GT(most, 180);
    }
    EXPECT_LE(most, 250 * (1 + 1e-9));
  }
}

/// A hand of 3 kg presses a reamer with 180 N into a socket.
struct Reaming {
  double removed = 0;   // m³
  double paid = 0;      // m³, volume for which the work of the blades pays (Preston)
  double max_jump = 0;  // N, of the force from tick to tick, after the first half second
  int cuts = 0;         // ticks in which spheres changed
};
Reaming ream(double specific_energy, double push) {
  ServoSettings s = settings(R"({"packing": {"spheres": 6000}})", 44.0_mm);
  s.stiffness = 60e3, s.damping = 20;
  s.force_limit = 250, s.torque_limit = 10;
  s.spindle.free_speed = 0.3_krpm;
  for (Material& m : s.materials) m.specific_energy = specific_energy;
  HapticBench run(R"({"voxel_mm": 0.8, "band_mm": 4, "solids": [
      {"tissue": "cancellous_bone", "solid": {"difference": [{"box": {"size_mm": [56, 56, 32]}},
      {"sphere": {"center_mm": [0, 0, 16], "radius_mm": 22.1}}]}}]})",
                  s, s.materials);
  Reaming result;
  dvec3 x(0, 0, 15.95_mm), v(0);
  for (int i = 0; i < 2000; ++i) {
    const dvec3 pull(-20e3 * x.x, -20e3 * x.y, -push);
    v += 1e-3 * (pull - 1000.0 * v + run.last.f_T_W) / 3.0;
    x += 1e-3 * v;
    run.tick({x, {1, 0, 0, 0}}, 1);
    result.cuts += run.did_cut;
    const double pressing = glm::length(run.last.f_T_W);
    result.paid += s.tool.cutting_coefficient * s.tool.end_efficiency * pressing * s.tool.radius() *
                   std::abs(run.last.spindle) * 1e-3 / specific_energy;
    if (i < 500) run.max_step = 0;
  }
  result.removed = total(run.last.removed);
  result.max_jump = run.max_step;
  return result;
}

TEST(Reaming, AReamerThatPostponesItsCutsRemovesWhatItsBladesPayForAndTheForceDoesNotJump) {
  // J/m³ and N: hard bone, and cancellous bone
  for (const auto& [specific_energy, push] : {std::pair(6e9, 180.0), std::pair(0.4e9, 140.0)}) {
    const Reaming reaming = ream(specific_energy, push);
    EXPECT_LT(reaming.cuts, 500) << "of 2,000 ticks";
    EXPECT_GT(reaming.removed, 10.0_mm3);
    EXPECT_NEAR(reaming.removed / reaming.paid, 1, 5e-3);
    EXPECT_LT(reaming.max_jump, 0.025);
  }
}

TEST(RootCanal, AtEqualFeedEnamelResistsOneAndAHalfTimesAsMuchAsDentinAndPulpNotAtAll) {
  const auto force = [](const char* tissue) {
    ServoSettings stiff =
        settings(R"({"packing": {"spheres": 12000, "density": {"enamel": 1.5, "dentin": 1, "pulp": 0}}})", 1.2_mm);
    stiff.stiffness = 1e4;  // so that the force is constant after a quarter of a second
    HapticBench run(fmt::format(R"({{"voxel_mm": 0.1, "solids": [{{"tissue": "{}", "solid": {{"box": {{"size_mm":
                    [4, 4, 4]}}}}}}]}})",
                                tissue),
                    stiff, stiff.materials);
    double sum = 0;
    for (int i = 0; i < 3000; ++i) {
      run.tick({dvec3(0, 0, 2.62_mm - i * 0.4e-6), {1, 0, 0, 0}}, 1);  // 0.4 mm/s
      if (i >= 2200) sum += run.last.depth * stiff.stiffness / 800;
    }
    return sum;
  };
  const double enamel = force("enamel"), dentin = force("dentin"), pulp = force("pulp");
  EXPECT_GT(dentin, 0.05);
  EXPECT_NEAR(enamel / dentin, 1.5, 0.05 * 1.5);
  EXPECT_LT(pulp, 0.05 * dentin);
}

}  // namespace
}  // namespace typodont::haptics
