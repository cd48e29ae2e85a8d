// Tests that a picture of which only the changed parts were drawn again equals a picture that was drawn completely.
#include <gtest/gtest.h>

#include <random>

#include "tests/support/stage.h"
#include "tests/support/tooth_mesh.h"

namespace typodont::test {
namespace {

struct Scene {
  Stage stage;
  Scene(const render::Quality& quality, const std::vector<render::MeshUpdate>& tooth, bool validation)
      : stage({320, 256}, quality, Passes::kTwo, validation) {
    stage.renderer->update(0, tooth);
    Handpiece handpiece;
    HandpiecePart head, body;
    head.rings = {{0, 3e-3, 1.5e-3}, {0, 5e-3, 1.5e-3}};
    body.rings = {{1e-3, 4e-3, 0.7e-3}, {9e-3, 6e-3, 1e-3}};
    body.knurl = {3e-3, 7e-3};
    handpiece.parts = {head, body};
    stage.renderer->set_tool(round_bur(1.4e-3), handpiece);
  }
};

class ChangedPixels : public testing::TestWithParam<int> {};

TEST_P(ChangedPixels, OnlyChangedTilesAreDrawnAndThePictureEqualsAFullRedraw) {
  const render::Quality& quality = render::kQualityLadder[static_cast<std::size_t>(GetParam())];
  const auto sound = tooth_mesh(0, 0.6e-3), cut = tooth_mesh(2e-3, 0.6e-3);
  Scene changing(quality, sound, true);
  const glm::ivec2 screen = display::screen_pixels(display::Layout::kSideBySide, changing.stage.size);
  const auto output = display::make_offscreen(changing.stage.device, screen);
  std::mt19937 random(static_cast<unsigned>(GetParam()));
  std::uniform_real_distribution<double> uniform(-1, 1);
  render::Frame frame = frame_of(desk(0.03, 0.024, 0.35));
  frame.tool = {.visible = true,
                .X_WG = {dvec3(0, 0, 3e-3), rotation_between({0, 0, 1}, glm::normalize(dvec3(-.3, -.2, 1)))}};
  display::Hud hud{.visible = true, .tool = "round 1.4 mm", .hint = "hint"};
  changing.stage.draw(frame);
  std::vector<render::MeshUpdate> now = sound;
  std::vector<render::Particle> particles;
  double least = 1;
  for (int step = 0; step < 12; ++step) {
    frame.tool.X_WG.p += 0.5e-3 * dvec3(uniform(random), uniform(random), 0.5 * uniform(random));
    frame.tool.visible = step != 5;
    frame.cursor = {step % 4 != 3, frame.tool.X_WG.p, frame.tool.X_WG.R * dvec3(0, 0, -1), 0.9e-3};
    frame.tool.spindle = step % 3 ? 3000 : 0;
    if (step % 4 == 1) hud.force = 0.3 * step;
    if (step == 8) hud.hint = "another, longer hint";
    particles.clear();
    for (int i = 0; i < (step % 5) * 4; ++i)
      particles.push_back({glm::vec3(4e-3 * uniform(random), 4e-3 * uniform(random), 3e-3),
                           8e-5f,
                           {1, 0.9f, 0.8f},
                           i % 2 ? 1.0f : 0.3f});
    frame.particles = particles;
    frame.background = step > 10 ? render::Background::kBlack : render::Background::kGradient;
    // Some bricks change to their state after the cut, or back.
    std::vector<render::MeshUpdate> changed;
    for (int i = 0; i < step % 3; ++i) {
      const auto& from = step % 2 ? cut : sound;
      const render::MeshUpdate& b = from[random() % from.size()];
      changed.push_back(b);
      const auto place = std::find_if(now.begin(), now.end(), [&](const auto& n) { return n.brick == b.brick; });
      if (place == now.end())
        now.push_back(b);
      else
        *place = b;
    }
    changing.stage.renderer->update(0, changed);
    const render::FrameStats stats = changing.stage.draw(frame);
    ASSERT_TRUE(stats.drawn);
    least = std::min(least, stats.redrawn);

    Scene fresh(quality, now, false);
    ASSERT_EQ(fresh.stage.draw(frame).redrawn, 1.0);
    for (int e = 0; e < 2; ++e) {
      const Difference d = compare(changing.stage.eye(e), fresh.stage.eye(e), 0);
      ASSERT_EQ(d.pixels, 0) << "step " << step << " eye " << e << " worst " << d.worst;
    }
    // Composing only the changed parts must also equal composing everything.
    std::array<std::vector<display::Part>, 2> parts;
    for (int e = 0; e < 2; ++e)
      for (const render::PixelBox& b : changing.stage.renderer->redrawn(e))
        parts[static_cast<std::size_t>(e)].push_back({b.x, b.y, b.width, b.height});
    gpu::run_once(changing.stage.device, [&](VkCommandBuffer commands) {
      changing.stage.compositor->record(commands, changing.stage.renderer->pictures(), display::Layout::kSideBySide,
                                        *output->acquire(), 0, 0, &parts, {&hud, &hud});
    });
    fresh.stage.hud = hud;
    fresh.stage.draw(frame, display::Layout::kSideBySide);
    const Difference composed = compare({screen, output->read()}, fresh.stage.screen, 0);
    ASSERT_EQ(composed.pixels, 0) << "composed, step " << step;
    EXPECT_EQ(changing.stage.device.validation_messages(), 0);
  }
  EXPECT_LT(least, 0.6) << "so little was ever enough";
}

TEST(ChangedFog, RedrawsTheGlassAloneAndThePictureEqualsAFullRedraw) {
  const render::Quality& quality = render::kQualityLadder[4];
  const auto tooth = tooth_mesh(0, 0.6e-3);
  Scene changing(quality, tooth, true);
  render::Frame frame = frame_of(desk(0.03, 0.024, 0.35));
  frame.mirror = {{dvec3(0, 2e-3, 3e-3), rotation_between({0, 0, 1}, glm::normalize(dvec3(0.4, -0.6, 0.8)))}, 8e-3, 0};
  changing.stage.draw(frame);
  for (const double fog : {0.3, 0.8, 0.1}) {
    frame.mirror.fog = fog;
    const render::FrameStats stats = changing.stage.draw(frame);
    EXPECT_TRUE(stats.drawn);
    EXPECT_LT(stats.redrawn, 0.5);
    Scene fresh(quality, tooth, false);
    fresh.stage.draw(frame);
    for (int e = 0; e < 2; ++e) EXPECT_EQ(compare(changing.stage.eye(e), fresh.stage.eye(e), 0).pixels, 0) << fog;
  }
  EXPECT_EQ(changing.stage.device.validation_messages(), 0);
}

INSTANTIATE_TEST_SUITE_P(Steps, ChangedPixels, testing::Values(1, 4, 6));

}  // namespace
}  // namespace typodont::test
