// Tests pictures of the default scene as a user first sees it, and of its views for teaching. A person inspected them
// once. The tolerance is a difference that a person would see, as in render_golden_test.cpp.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <functional>
#include <memory>
#include <thread>

#include "engine/app/assets.h"
#include "engine/app/picture/picture_stage.h"
#include "engine/app/picture/teaching_views.h"
#include "engine/app/picture/tissue_view.h"
#include "engine/app/recording/resume.h"
#include "engine/app/scene.h"
#include "engine/app/surroundings/surroundings.h"
#include "tests/support/stage.h"

namespace typodont::test {
namespace {

constexpr int kTolerance = 6, kPixels = 120;

const render::Quality& kMedium = render::kQualityLadder[1];

display::DisplayRig closeup() {
  display::DisplayRig rig = display::load_rig(assets_folder() / "rigs/closeup.json");
  rig.screen.pixels = {640, 256};
  return rig;
}

TEST(GoldenScene, TheMolarWithNeighboursMouthMirrorSectionAndXrayLooksAsApproved) {
  const Scene scene = read_scene(assets_folder() / "scenes/molar-caries.json");
  haptics::TissueVolume volume = load_tissue(scene);
  const display::DisplayRig rig = closeup();
  PictureStage::Options options;
  options.validation = true;
  options.hud = false;
  // The light inside tissue has the cells of the level `medium`, because those of `high` take more than 20 s.
  options.quality.light_cell = kMedium.light_cell;
  options.quality.light_walks = kMedium.light_walks;
  PictureStage stage(rig, scene.servo, options);
  World world(scene);
  world.hold({});
  stage.surround(world.surroundings());
  TissueView view;
  const dvec3 origin = volume.frame().origin;
  stage.show(view.update(volume), origin);
  ServoTick tick;
  tick.X_WG = {dvec3(7.4e-3, 5.2e-3, 20.2e-3), rotation_between({0, 0, 1}, glm::normalize(dvec3(0.25, -0.35, 1)))};
  tick.spindle = scene.servo.spindle.free_speed;
  world.place(tick);
  std::string message;
  const auto draw = [&](const char* name) {
    stage.draw(world);
    EXPECT_TRUE(matches_golden(stage.eye(0), name, kTolerance, kPixels, message)) << message;
  };
  draw("scene_look");
  world.hold({{dvec3(6.8e-3, 14.5e-3, 17e-3), rotation_between({0, 0, 1}, glm::normalize(dvec3(0, -.916, .402)))},
              14e-3,
              0.0});
  draw("scene_mirror");
  world.hold({});
  const glm::dvec4 plane{0, 1, 0, -5.8e-3};
  stage.show_inside(render::kSectionFace, section_face(volume, {0, 1, 0}, 5.8e-3), origin);
  stage.show_inside(render::kSectionFaceAround,
                    surroundings_shape(scene.surroundings)->section_face({0, 1, 0}, 5.8e-3, origin), origin);
  stage.show_as(render::View::kSection, plane);
  draw("scene_section");
  stage.show_inside(render::kInsidePulp, tissue_inside(volume, Tissue::kPulp), origin);
  stage.show_inside(render::kInsideCaries, tissue_inside(volume, Tissue::kCaries), origin);
  stage.show_inside(render::kInsideDentin, tissue_inside(volume, Tissue::kDentin), origin);
  stage.show_as(render::View::kXray);
  draw("scene_xray");
  EXPECT_EQ(stage.validation_messages(), 0);
}

TEST(HalfMirror, ShowsTheSceneAsBrightAsWithoutTheMirror) {
  const Scene scene = read_scene(assets_folder() / "scenes/molar-caries.json");
  haptics::TissueVolume volume = load_tissue(scene);
  const Surroundings around = make_surroundings(scene.surroundings);
  const display::DisplayRig open = closeup();
  // The same picture for a half mirror. Its panel shows the mirror image, with left and right exchanged.
  display::DisplayRig half = open;
  half.kind = display::DisplayKind::kMirror;
  half.mirror = display::Mirror{glm::normalize(dvec3(0, -0.66, 0.75)), 60e-3};
  half.screen.lower_left = display::reflect(*half.mirror, open.screen.lower_right);
  half.screen.lower_right = display::reflect(*half.mirror, open.screen.lower_left);
  half.screen.upper_left =
      display::reflect(*half.mirror, open.screen.lower_right + open.screen.upper_left - open.screen.lower_left);
  const auto picture = [&](const display::DisplayRig& rig) {
    PictureStage::Options options;
    options.hud = false;
    options.quality = render::kQualityLadder[3];
    PictureStage stage(rig, scene.servo, options);
    stage.surround(around);
    TissueView view;
    stage.show(view.update(volume), volume.frame().origin);
    World world(scene);
    stage.draw(world, {.tool = false, .debris = false, .mirror = false});
    return stage.eye(0);
  };
  const render::Picture straight = picture(open), reflected = picture(half);
  ASSERT_EQ(straight.size, reflected.size);
  int shown = 0, other = 0;
  for (int y = 0; y < straight.size.y; ++y)
    for (int x = 0; x < straight.size.x; ++x) {
      const auto at = [&](const render::Picture& p, int column) { return p.rgba.data() + 4 * (y * p.size.x + column); };
      const auto *a = at(straight, x), *b = at(reflected, straight.size.x - 1 - x);
      if (b[0] + b[1] + b[2] < 60) continue;  // black where the hand shows through
      ++shown;
      for (int c = 0; c < 3; ++c)
        if (std::abs(a[c] - b[c]) > 4) {
          ++other;
          break;
        }
    }
  EXPECT_GT(shown, 20000);
  EXPECT_LT(other, shown / 40);  // samples of a pixel are not mirrored: outlines differ a little
}

TEST(MouthLight, OfTheBackgroundArrivesAfterThePictureWhichThenEqualsThatOfAWaitingStageAlsoAfterACut) {
  const Scene scene = read_scene(assets_folder() / "scenes/molar-caries.json");
  haptics::TissueVolume volume = load_tissue(scene);
  const Surroundings around = make_surroundings(scene.surroundings);
  const display::DisplayRig rig = closeup();
  TissueView view;
  const std::vector<render::MeshUpdate> tooth = view.update(volume);
  World world(scene);
  const auto stage_with = [&](MouthLight::When light) {
    PictureStage::Options options;
    options.hud = false;
    options.quality = render::kQualityLadder[3];
    options.light = light;
    auto stage = std::make_unique<PictureStage>(rig, scene.servo, options);
    stage->surround(around);
    stage->show(tooth, volume.frame().origin);
    return stage;
  };
  const auto picture = [&](PictureStage& stage) {
    stage.draw(world);
    return stage.eye(0).rgba;
  };
  const auto quick = stage_with(MouthLight::When::kInBackground);
  const std::vector<std::uint8_t> first = picture(*quick);
  quick->show(tooth, volume.frame().origin);                 // while the light is computed
  stage_with(MouthLight::When::kInBackground)->draw(world);  // ends at once with its stage
  const auto waiting = stage_with(MouthLight::When::kAtOnce);
  const std::vector<std::uint8_t> lit = picture(*waiting);
  EXPECT_NE(first, lit);
  while (picture(*quick) != lit) std::this_thread::sleep_for(std::chrono::milliseconds(10));

  std::vector<render::MeshUpdate> cut = tooth;  // the two highest bricks, 0.3 mm lower
  const auto top = [](const render::MeshUpdate& brick) {
    float z = -1;
    for (const render::Vertex& v : brick.vertices) z = std::max(z, v.p.z);
    return z;
  };
  std::ranges::partial_sort(cut, cut.begin() + 2, std::greater(), top);
  cut.resize(2);
  for (render::MeshUpdate& brick : cut)
    for (render::Vertex& v : brick.vertices) v.p.z -= 0.3e-3f;
  for (const auto* const stage : {&quick, &waiting}) (*stage)->show(cut, volume.frame().origin);
  EXPECT_NE(picture(*waiting), lit);
  while (picture(*quick) != picture(*waiting)) std::this_thread::sleep_for(std::chrono::milliseconds(10));
}

}  // namespace
}  // namespace typodont::test
