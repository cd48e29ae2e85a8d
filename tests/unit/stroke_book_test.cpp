// Tests that the displays of a session change back when its strokes are undone.
#include "engine/app/tissue/stroke_book.h"

#include <gtest/gtest.h>

#include "engine/app/picture/look.h"
#include "engine/app/recording/resume.h"
#include "engine/app/scene.h"
#include "engine/base/units.h"

namespace typodont {
namespace {

haptics::TissueVolume block() {
  return load_tissue(parse_scene(Json::parse(R"({"name": "block", "tissue": {"voxel_mm": 0.2, "solids": [
    {"tissue": "enamel", "solid": {"box": {"center_mm": [0, 0, 0], "size_mm": [4, 4, 4]}}}]}, "tool": "round_012"})",
                                             "b"),
                                 "b"));
}
Cut cut_of(double mm3) {
  Cut cut;
  cut.removed[static_cast<std::size_t>(Tissue::kEnamel)] = mm3 * kCubicMillimetre;
  return cut;
}

TEST(StrokeHistory, RemovalAndPaintAreUndoneAndRedoneWithTheStrokes) {
  haptics::TissueVolume volume = block();
  StrokeHistory book;
  const auto removed = [&] {
    return book.state(volume.strokes()).removed[static_cast<std::size_t>(Tissue::kEnamel)] / kCubicMillimetre;
  };
  const PaintStroke stroke{Tissue::kCaries, {0, 0, 2e-3}, {0, 0, 2e-3}, 1e-3};
  const auto brush = [&] {
    paint(volume, {stroke});
    book.painted(stroke, volume.strokes());
  };
  const auto cut = [&](double mm3) {
    paint(
        volume,
        {{Tissue::kDentin, {mm3 * 1e-4, 0, 0}, {mm3 * 1e-4, 0, 0}, 0.5e-3}});  // a stroke that changes nothing is none
    book.cut(cut_of(mm3), volume.strokes());
  };
  volume.begin_stroke();
  cut(1);
  cut(2);
  volume.begin_stroke();
  brush();
  brush();
  volume.begin_stroke();
  cut(4);
  EXPECT_NEAR(removed(), 7, 1e-9);
  EXPECT_EQ(book.paint(volume.strokes()).size(), 2u);

  const std::uint64_t version = book.state(volume.strokes()).version;
  ASSERT_TRUE(volume.undo());
  book.edited(false, volume.strokes());
  EXPECT_NEAR(removed(), 3, 1e-9);
  ASSERT_TRUE(volume.undo());
  book.edited(false, volume.strokes());
  EXPECT_TRUE(book.paint(volume.strokes()).empty());
  EXPECT_EQ(book.state(volume.strokes()).painted, 0u);
  ASSERT_TRUE(volume.redo());
  book.edited(true, volume.strokes());
  EXPECT_EQ(book.paint(volume.strokes()).size(), 2u);
  EXPECT_NEAR(removed(), 3, 1e-9);
  EXPECT_EQ(book.state(volume.strokes()).undone, 2u);
  EXPECT_EQ(book.state(volume.strokes()).redone, 1u);
  EXPECT_GT(book.state(volume.strokes()).version, version);

  // After a new stroke, the strokes that were undone cannot be redone.
  volume.begin_stroke();
  cut(8);
  EXPECT_NEAR(removed(), 11, 1e-9);
}

TEST(Look, TheSectionKeepsTheSideBehindThePlaneForEveryViewer) {
  Look look;
  look.section_axis = 1;
  look.section = 1e-3;
  const dvec3 middle(0, 5e-3, 0);
  for (const double side : {-1.0, 1.0}) {
    const dvec3 eye(0, side * 0.3, 0.1);
    const glm::dvec4 plane = section_plane(look, middle, eye);
    const auto kept = [&](const dvec3& p) { return glm::dot(dvec3(plane), p) + plane.w > 0; };
    EXPECT_FALSE(kept(dvec3(0, 6e-3 + side * 1e-3, 0))) << "before the plane";
    EXPECT_TRUE(kept(dvec3(0, 6e-3 - side * 1e-3, 0))) << "behind it";
  }
}

TEST(Viewpoint, OfARigIsTheEyesOfItsUserAndShowsTheCentreUpright) {
  display::DisplayRig rig;
  rig.head.eye_center = {0.1, -0.3, 0.25};
  const dvec3 middle(6.8e-3, 6e-3, 18e-3);
  const Viewpoint from = viewpoint_of(rig, middle);
  const display::DisplayRig made = rig_of(from, middle, {800, 600});
  EXPECT_LT(glm::length(glm::normalize(made.head.eye_center - middle) - glm::normalize(rig.head.eye_center - middle)),
            1e-9);
  const display::EyeView eye = display::eye_views(made)[0];
  const glm::dvec4 seen = eye.projection * eye.view * glm::dvec4(middle, 1);
  EXPECT_NEAR(seen.x / seen.w, 0, 1e-9);
  EXPECT_NEAR(seen.y / seen.w, 0, 1e-9);
  const glm::dvec4 above = eye.projection * eye.view * glm::dvec4(middle + dvec3(0, 0, 1e-3), 1);
  EXPECT_LT(above.y / above.w, 0) << "Vulkan's y points down";
  EXPECT_LT(clamped({.elevation = 3}).elevation, 1.58);
  EXPECT_GT(clamped({.distance = 0}).distance, 0.01);
}

}  // namespace
}  // namespace typodont
