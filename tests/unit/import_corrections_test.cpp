// Tests corrections of imported tissue by hand, against analytic solids.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "engine/base/error.h"
#include "engine/base/units.h"
#include "engine/base/voxels.h"
#include "haptics/import/corrections.h"
#include "haptics/import/import.h"

namespace typodont::haptics {
namespace {

constexpr double kVoxel = 0.2e-3, kBall = 4e-3, kCore = 2e-3;  // m
constexpr double kCoreGrey = 2000, kShellGrey = 1000;

/// A ball of cancellous bone with a core of cortical bone, both recognised by their grey values.
Imported ball() {
  Imported made;
  DenseTissue& t = made.tissue;
  t.size = glm::ivec3(56);
  t.frame = {dvec3(-27.5 * kVoxel), kVoxel};
  for_each_voxel(t.size, [&](int x, int y, int z) {
    const double r = glm::length(t.frame.to_world(dvec3(x, y, z)));
    t.distance.push_back(static_cast<float>(std::clamp(r - kBall, -t.band, t.band)));
    t.tissue.push_back(r < kCore                  ? Tissue::kCorticalBone
                       : r < kBall + 2.5 * kVoxel ? Tissue::kCancellousBone
                                                  : Tissue::kAir);
    made.grey.push_back(static_cast<float>(r < kCore ? kCoreGrey : r < kBall ? kShellGrey : 0));
  });
  made.report.outside_grey = 0;
  made.report.soft_grey = kShellGrey;
  made.report.kinds = {1500, 1500, 0, kShellGrey, kCoreGrey};
  return made;
}

PerTissue volumes(const Imported& made) {
  return volumes_in(made.tissue, {glm::ivec3(0), made.tissue.size - 1});
}
double volume(const Imported& made, Tissue tissue) {
  return volumes(made)[static_cast<std::size_t>(tissue)];
}
double ball_volume(double r) {
  return 4.0 / 3 * kPi * r * r * r;
}
double distance_at(const Imported& made, const dvec3& p) {
  const glm::ivec3 i(glm::round(made.tissue.frame.to_voxels(p)));
  return made.tissue.distance[made.tissue.at(i.x, i.y, i.z)];
}

TEST(Corrections, TheBrushRelabelsTheTissueUnderItAndLeavesTheSurface) {
  Imported made = ball();
  const std::vector<float> before = made.tissue.distance;
  LabelStroke stroke{LabelKind::kMetal, {dvec3(-1e-3, 0, 0), dvec3(1e-3, 0, 0)}, 1e-3, true};
  correct(made, stroke);
  const double capsule = ball_volume(1e-3) + kPi * 1e-6 * 2e-3;
  EXPECT_NEAR(volume(made, Tissue::kAmalgam), capsule, 0.05 * capsule);
  EXPECT_EQ(made.tissue.distance, before);
  // If the brush crosses the surface, only the half inside is relabelled.
  made = ball();
  stroke.path = {dvec3(kBall, 0, 0)};
  correct(made, stroke);
  EXPECT_EQ(made.tissue.distance, before);
  EXPECT_LT(volume(made, Tissue::kAmalgam), 0.55 * ball_volume(1e-3));
}

TEST(Corrections, TheGreyValueChoosesBetweenTheTissuesOfAKind) {
  Imported made = ball();
  correct(made, LabelStroke{LabelKind::kTooth, {dvec3(0)}, 3e-3, true});
  EXPECT_NEAR(volume(made, Tissue::kEnamel), ball_volume(kCore), 0.02 * ball_volume(kCore));
  const double dentin = ball_volume(3e-3) - ball_volume(kCore);
  EXPECT_NEAR(volume(made, Tissue::kDentin), dentin, 0.02 * dentin);
}

TEST(Corrections, TheBrushOfNothingRemovesItsVolume) {
  Imported made = ball();
  correct(made, LabelStroke{LabelKind::kNothing, {dvec3(0)}, 1e-3, true});
  EXPECT_NEAR(total(volumes(made)), ball_volume(kBall) - ball_volume(1e-3), 1e-3 * ball_volume(kBall));
  for (const int k : {28, 30, 32, 34, 36}) {
    const double r = glm::length(made.tissue.frame.to_world(dvec3(k, 28, 28)));
    EXPECT_NEAR(made.tissue.distance[made.tissue.at(k, 28, 28)], 1e-3 - r, 1e-9) << k;
  }
}

TEST(Corrections, TheBrushAddsTissueWhereItMay) {
  Imported made = ball();
  LabelStroke stroke{LabelKind::kBone, {dvec3(kBall, 0, 0)}, 1e-3, false};
  correct(made, stroke);
  EXPECT_LT(distance_at(made, {kBall + 0.7e-3, 0, 0}), 0);
  EXPECT_GT(distance_at(made, {kBall + 1.3e-3, 0, 0}), 0);
  EXPECT_GT(total(volumes(made)), ball_volume(kBall) + 0.4 * ball_volume(1e-3));
  // Outside the box nothing may be added, and the tissue must end at the walls of the box.
  stroke.path = {dvec3(5.4e-3, 0, 0)};
  correct(made, stroke);
  const DenseTissue& t = made.tissue;
  for (int y = 0; y < t.size.y; ++y)
    for (int z = 0; z < t.size.z; ++z) EXPECT_GT(t.distance[t.at(t.size.x - 1, y, z)], 0);
}

TEST(Corrections, ASeedSpreadsThroughSimilarGreyValuesOnly) {
  Imported made = ball();
  correct(made, LabelSeed{LabelKind::kTooth, dvec3(0.5e-3, 0, 0), 8e-3, 0.3});
  EXPECT_NEAR(volume(made, Tissue::kEnamel), ball_volume(kCore), 0.05 * ball_volume(kCore));
  EXPECT_NEAR(volume(made, Tissue::kCancellousBone), ball_volume(kBall) - ball_volume(kCore),
              0.02 * ball_volume(kBall));
  // The label may not change beyond the reach of 1 mm.
  made = ball();
  correct(made, LabelSeed{LabelKind::kMetal, dvec3(0, 0, 0), 1e-3, 0.3});
  EXPECT_NEAR(volume(made, Tissue::kAmalgam), ball_volume(1e-3), 0.15 * ball_volume(1e-3));
  // Outside the tissue it does nothing.
  EXPECT_TRUE(correct(made, LabelSeed{LabelKind::kMetal, dvec3(5e-3, 0, 0), 1e-3, 0.3}).box.empty());
}

TEST(Corrections, ASeedOfNothingRemovesItsPart) {
  Imported made = ball();
  correct(made, LabelSeed{LabelKind::kNothing, dvec3(0), 8e-3, 0.3});
  const double left = ball_volume(kBall) - ball_volume(kCore);
  EXPECT_NEAR(total(volumes(made)), left, 0.05 * left);
  EXPECT_GT(distance_at(made, dvec3(0)), 1e-3);
}

TEST(Corrections, UndoingRestoresEverySampleAndRepeatingEveryCorrection) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-5e-3, 5e-3), size(0.3e-3, 3e-3);
  std::uniform_int_distribution<int> kind(0, kLabelKinds - 1), coin(0, 1);
  Imported made = ball();
  made.tissue.hardness.assign(made.tissue.tissue.size(), 200);
  std::vector<DenseTissue> states{made.tissue};
  std::vector<BoxContent> contents;
  for (int i = 0; i < 12; ++i) {
    const auto point = [&] { return dvec3(place(random), place(random), place(random)); };
    const auto what = static_cast<LabelKind>(kind(random));
    const Correction one = coin(random) ? Correction(LabelSeed{what, point(), size(random), 0.5})
                                        : LabelStroke{what, {point(), point()}, size(random), coin(random) == 1};
    contents.push_back(correct(made, one));
    states.push_back(made.tissue);
  }
  const auto expect_state = [&](std::size_t i) {
    EXPECT_EQ(made.tissue.distance, states[i].distance);
    EXPECT_EQ(made.tissue.tissue, states[i].tissue);
    EXPECT_EQ(made.tissue.hardness, states[i].hardness);
  };
  for (std::size_t i = contents.size(); i-- > 0;) exchange(made, contents[i]), expect_state(i);
  for (std::size_t i = 0; i < contents.size(); ++i) exchange(made, contents[i]), expect_state(i + 1);
}

TEST(Corrections, ABrushThinnerThanAVoxelIsRefused) {
  Imported made = ball();
  EXPECT_THROW(correct(made, LabelStroke{LabelKind::kBone, {dvec3(0)}, 0.05e-3, true}), Error);
}

}  // namespace
}  // namespace typodont::haptics
