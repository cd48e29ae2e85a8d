// Tests colour per voxel: where it is stored, what keeps and what removes it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "engine/base/units.h"
#include "haptics/carver.h"
#include "haptics/solid.h"
#include "haptics/sweep.h"
#include "haptics/tissue_volume.h"
#include "tests/support/program.h"

namespace typodont {
namespace {

using namespace literals;
using haptics::TissueVolume;

constexpr dvec3 kRed(0.8, 0.1, 0.1);

/// A block of dentin with its top at z = 2.5 mm.
TissueVolume block(const std::string& more = "") {
  const std::string json = fmt::format(
      R"({{"voxel_mm": 0.1, "band_mm": 0.4, "solids": [
          {{"tissue": "dentin", "solid": {{"box": {{"size_mm": [5, 5, 5]}}}}}}{}]}})",
      more);
  return TissueVolume(haptics::read_solids(Json::parse(json, "tissue")));
}

/// Colours of all voxels up to 3 mm from the centre.
std::vector<VoxelColor> colors_of(const TissueVolume& volume) {
  const glm::ivec3 lo(glm::round(volume.frame().to_voxels(dvec3(-3.0_mm)))), size(61);
  std::vector<VoxelColor> colors(static_cast<std::size_t>(size.x * size.y * size.z));
  volume.copy_colors(lo, size, colors.data());
  return colors;
}

bool paint_ball(TissueVolume& volume, const dvec3& at, double radius, VoxelColor color) {
  return volume.paint(Tissue::kCaries, *haptics::capsule(at, at, radius), haptics::kOwnHardness, color);
}

TEST(VoxelColors, RoundToOneOf31LevelsAndAreNeverTheTissuesOwn) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> level(0, 1);
  for (int i = 0; i < 1000; ++i) {
    const dvec3 srgb(level(random), level(random), level(random));
    const VoxelColor color = voxel_color(srgb);
    EXPECT_LE(glm::length(glm::max(glm::abs(srgb_of(color) - srgb) - dvec3(0.5 / 31, 0.5 / 63, 0.5 / 31), 0.0)), 1e-9);
    EXPECT_EQ(voxel_color(srgb_of(color)), color);
  }
  EXPECT_NE(voxel_color(dvec3(0)), kTissueColor);
  EXPECT_LT(glm::length(srgb_of(voxel_color(dvec3(0)))), 0.04);
}

TEST(VoxelColors, ChangeOnlyWhereTissueIsPaintedAndNotItsHardness) {
  TissueVolume volume = block();
  EXPECT_FALSE(volume.colored());
  EXPECT_EQ(volume.color_at(volume.frame().to_voxels({0, 0, 2.5_mm})), glm::vec4(0));
  const VoxelColor red = voxel_color(kRed);
  ASSERT_TRUE(paint_ball(volume, {0, 0, 2.5_mm}, 1.0_mm, red));
  EXPECT_TRUE(volume.colored());
  EXPECT_FALSE(volume.graded());
  const auto at = [&](double x) { return volume.color_at(volume.frame().to_voxels({x, 0, 2.5_mm})); };
  EXPECT_EQ(at(0), glm::vec4(srgb_of(red), 1));
  EXPECT_EQ(at(1.5_mm), glm::vec4(0));
  // Between a coloured voxel and one without, the fraction changes in proportion to the way.
  for (const double part : {0.25, 0.5, 0.75}) {
    EXPECT_NEAR(static_cast<double>(at(1.0_mm + part * 0.1_mm).w), 1 - part, 1e-4);
    EXPECT_LT(glm::length(dvec3(at(1.0_mm + part * 0.1_mm)) - srgb_of(red)), 1e-6);
  }
  // A colour counts only if its tissue does.
  EXPECT_EQ(volume.color_at(volume.frame().to_voxels({0, 0, 2.5_mm}), 1u << static_cast<int>(Tissue::kDentin)),
            glm::vec4(0));
}

TEST(VoxelColors, OfFilesAreThoseThatWereSavedAlsoDeepInside) {
  const test::Folder folder;
  const std::filesystem::path file = folder / "block.vdb";
  // The first block is a tile of the volume, with leaves of other colours and hardness in it.
  TissueVolume volume = block(R"(,
    {"tissue": "dentin", "color": [0.2, 0.9, 0.4], "hardness": 0.4, "solid": {"box": {"size_mm": [4, 4, 4]}}})");
  for (int i = 0; i < 8; ++i)
    paint_ball(volume, dvec3(0.3_mm * i, 0, 2.2_mm), 0.5_mm, voxel_color(dvec3(1 - 0.1 * i, 0.1 * i, 0)));
  volume.save(file);
  const TissueVolume loaded = TissueVolume::load(file);
  EXPECT_TRUE(loaded.colored() && loaded.graded());
  EXPECT_TRUE(colors_of(loaded) == colors_of(volume));
  EXPECT_EQ(loaded.hardness_volumes(), volume.hardness_volumes());
  EXPECT_EQ(loaded.color_at(loaded.frame().to_voxels(dvec3(0))), glm::vec4(srgb_of(voxel_color({0.2, 0.9, 0.4})), 1));
  block().save(file);
  EXPECT_EQ(test::read_text(file).find("color"), std::string::npos) << "tissue without colours names none";
  EXPECT_NE(TissueVolume::load(file).hash(), volume.hash());
}

}  // namespace
}  // namespace typodont
