// Tests pictures that a person inspected once and that must not change. Other processors differ by up to 2/255 in a few
// pixels; other drivers (a GPU) differ more. The tolerance is a difference that a person would see.
#include <gtest/gtest.h>

#include "tests/support/stage.h"
#include "tests/support/tooth_mesh.h"

namespace typodont::test {
namespace {

constexpr int kTolerance = 6, kPixels = 60;
constexpr glm::ivec2 kSize{320, 256};

render::Frame drilling(const display::DisplayRig& rig) {
  render::Frame frame = frame_of(rig);
  frame.tool = {
      .visible = true,
      .X_WG = {dvec3(-0.6e-3, -0.3e-3, 2.2e-3), rotation_between({0, 0, 1}, glm::normalize(dvec3(-.35, -.1, 1)))},
      .angle = 0.3};
  return frame;
}

struct Golden : testing::Test {
  Stage stage{kSize};
  std::string message;
  void SetUp() override {
    stage.renderer->update(0, tooth_mesh(2e-3));
    stage.renderer->set_tool(round_bur(1.6e-3));
  }
  /// Returns the left eye's half of the screen, with the text in it.
  render::Picture left_half(const render::Frame& frame) {
    stage.draw(frame, display::Layout::kSideBySide);
    render::Picture left{kSize, {}};
    for (int y = 0; y < kSize.y; ++y)
      left.rgba.insert(left.rgba.end(), stage.screen.at(0, y), stage.screen.at(0, y) + 4 * kSize.x);
    return left;
  }
};

TEST_F(Golden, AToothWithCavityAndBurLooksAsApproved) {
  stage.draw(drilling(desk(0.022, 0.0176, 0.35)));
  EXPECT_TRUE(matches_golden(stage.eye(0), "tooth_left", kTolerance, kPixels, message)) << message;
  EXPECT_TRUE(matches_golden(stage.eye(1), "tooth_right", kTolerance, kPixels, message)) << message;
}

TEST_F(Golden, ASpinningBurWithDebrisAndTextLooksAsApproved) {
  render::Frame frame = drilling(desk(0.022, 0.0176, 0.35));
  frame.tool.spindle = 31416;
  std::vector<render::Particle> particles;
  for (int i = 0; i < 60; ++i) {
    const float a = 2.4f * static_cast<float>(i), r = 1e-4f * static_cast<float>(i % 24 + 4);
    particles.push_back({{-0.6e-3f + r * std::cos(a), -0.3e-3f + r * std::sin(a), 2.6e-3f + 0.6f * r},
                         i % 4 ? 5e-5f : 2.5e-4f,
                         {0.93f, 0.88f, 0.76f},
                         i % 4 ? 1.0f : 0.25f});
  }
  frame.particles = particles;
  stage.hud = {
      .visible = true, .tool = "round 1.6 mm", .speed_krpm = 300, .force = 3.1, .hint = "Keep 0.2 mm from the pulp"};
  EXPECT_TRUE(matches_golden(left_half(frame), "drilling_left", kTolerance, kPixels, message)) << message;
}

TEST_F(Golden, TheToothInAMirrorLooksAsApprovedAndTextIsReadable) {
  display::DisplayRig rig = desk(0.022, 0.0176, 0.35);
  const display::Mirror mirror{glm::normalize(dvec3(0, 1, 0)), 0.1};
  const dvec3 up = rig.screen.upper_left - rig.screen.lower_left;
  const display::Screen upright = rig.screen;
  rig.screen.lower_left = display::reflect(mirror, upright.lower_right);
  rig.screen.lower_right = display::reflect(mirror, upright.lower_left);
  rig.screen.upper_left = display::reflect(mirror, upright.lower_right + up);
  rig.mirror = mirror;
  render::Frame frame = drilling(rig);
  frame.background = render::Background::kBlack;
  stage.hud = {.visible = true, .tool = "round 1.6 mm", .speed_krpm = 300, .force = 3.1};
  stage.hud.upright = display::upright(rig);
  EXPECT_TRUE(matches_golden(left_half(frame), "mirror_left", kTolerance, kPixels, message)) << message;
}

}  // namespace
}  // namespace typodont::test
