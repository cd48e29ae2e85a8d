// Tests pictures that pass through the whole OpenXR path: the real loader, the test runtime and its swapchain. They are
// read back as the program submitted them.
#include <gtest/gtest.h>

#include <cstring>
#include <optional>
#include <utility>

#include "engine/app/assets.h"
#include "engine/app/live/xr_stage.h"
#include "engine/app/scene.h"
#include "engine/app/surroundings/soft_gum.h"
#include "tests/support/default_colors.h"
#include "tests/support/stage.h"
#include "tests/support/tooth_mesh.h"
#include "tests/support/xr_fixture.h"

namespace typodont::test {
namespace {

constexpr int kFrame = 8;  // captured
constexpr int kTolerance = 6, kPixels = 60;

// The views are turned outwards by 5 degrees, and are wider on the outer side than towards the nose. The head looks
// down at the work.
const std::string kHeadset = R"("view_size": [320, 256], "capture": [8],
  "views": [{"p": [-0.032, 0.002, 0], "q": [0.99905, 0, 0.04362, 0], "fov": [-0.62, 0.45, 0.40, -0.52]},
            {"p": [0.032, -0.002, 0], "q": [0.99905, 0, -0.04362, 0], "fov": [-0.45, 0.62, 0.40, -0.52]}],
  "head": [{"frame": 0, "p": [0.1, 1.5, -0.2], "q": [0.9624, -0.2715, 0, 0]}])";

struct Shot {
  render::Picture left, right;
  std::vector<float> depth_left;
  display::HmdFrame frame;
};

struct XrGolden : testing::Test {
  XrFixture xr;
  display::DisplayRig rig;
  Scene scene;
  std::optional<World> world;  // of the scene; made by shoot() if it is empty
  render::Quality quality = render::kQualityLadder[0];
  bool hud = false;
  MouthMirror mirror;
  std::vector<render::MeshUpdate> mesh = tooth_mesh(2e-3);
  dvec3 work{0, 0, 4e-3};  // m, frame W, point that is in front of the user
  std::string message;

  void SetUp() override {
    rig.kind = display::DisplayKind::kHmd;
    rig.hmd.magnify = 14;
    scene.servo.materials = render::default_colors();
    scene.servo.tool.shape = haptics::HeadShape::kSphere;
    scene.servo.tool.diameter = 1.6e-3;
  }

  Shot shoot(const std::string& more = "", double opacity = 1) {
    xr.script(kHeadset + (more.empty() ? "" : ", " + more));
    Shot shot;
    if (!world) {
      ServoTick tick;
      tick.X_WG = {dvec3(-0.6e-3, -0.3e-3, 2.2e-3), rotation_between({0, 0, 1}, glm::normalize(dvec3(-.35, -.1, 1)))};
      world.emplace(scene).place(tick);
    }
    world->hold(mirror);
    display::RuntimeGate gate;
    {
      XrStage stage(rig, scene.servo, work, gate,
                    {.quality = quality, .validation = true, .handpieces = {.shown = false}, .hud = hud});
      stage.surround(world->surroundings());
      stage.show(mesh, {0, 0, 0});
      stage.hmd().wake();
      for (int i = 1; i <= kFrame; ++i) {
        EXPECT_TRUE(stage.hmd().poll());
        shot.frame = stage.hmd().wait();
        stage.draw(shot.frame, *world, opacity);
      }
      EXPECT_TRUE(shot.frame.draw);
      EXPECT_EQ(stage.validation_messages(), 0);
    }
    EXPECT_EQ(xr.violations(), "");
    shot.left = render::read_png(xr.path("frame8_left.png"));
    shot.right = render::read_png(xr.path("frame8_right.png"));
    const std::string depth = read_text(xr.path("frame8_left.depth"));
    shot.depth_left.resize(depth.size() / 4);
    std::memcpy(shot.depth_left.data(), depth.data(), shot.depth_left.size() * 4);
    return shot;
  }

  /// The same views drawn without OpenXR.
  void draw_offscreen(const Shot& shot, Stage& stage) {
    stage.renderer->update(0, mesh);
    stage.renderer->set_tool(drawn_tool(world->tool(), {}, {.shown = false}).tool);
    stage.draw(XrStage::picture(shot.frame, *world, 1, false));
  }
};

TEST_F(XrGolden, AToothInAHeadsetWithCantedAsymmetricViewsLooksAsApproved) {
  const Shot shot = shoot();
  EXPECT_TRUE(matches_golden(shot.left, "xr_left", kTolerance, kPixels, message)) << message;
  EXPECT_TRUE(matches_golden(shot.right, "xr_right", kTolerance, kPixels, message)) << message;
}

TEST_F(XrGolden, TheCompositorGetsTheSamePictureAsTheOffscreenRenderer) {
  const Shot shot = shoot();
  Stage stage({320, 256}, quality);
  draw_offscreen(shot, stage);
  for (const auto& [eye, picture] : {std::pair{0, &shot.left}, std::pair{1, &shot.right}}) {
    const Difference d = compare(*picture, stage.eye(eye), 1);
    EXPECT_EQ(d.pixels, 0) << "eye " << eye << ", worst " << d.worst;
  }
}

TEST_F(XrGolden, AMouthMirrorLooksAsOffscreenAndDoesNotChangeTheDepth) {
  const Shot without = shoot();
  mirror = {{dvec3(6e-3, 4e-3, 3e-3), rotation_between({0, 0, 1}, glm::normalize(dvec3(-0.5, -0.8, 0.4)))}, 12e-3, 0};
  const Shot shot = shoot();
  EXPECT_GT(compare(shot.left, without.left, 20).pixels, 1000);
  EXPECT_NE(shot.depth_left, without.depth_left);
  Stage stage({320, 256}, quality);
  draw_offscreen(shot, stage);
  EXPECT_EQ(compare(shot.left, stage.eye(0), 1).pixels, 0);
  EXPECT_EQ(compare(shot.right, stage.eye(1), 1).pixels, 0);
  // Far from the mirror, the depth of the picture must not change.
  for (int y = 0; y < 20; ++y)
    for (int x = 0; x < 60; ++x) {
      const auto i = static_cast<std::size_t>(320 * y + x);
      ASSERT_EQ(shot.depth_left[i], without.depth_left[i]);
    }
}

TEST_F(XrGolden, SoftGumIsDrawnInItsPresentShape) {
  scene = read_scene(assets_folder() / "scenes/class-2-cavity.json");
  const auto surface = soft_gum(scene.surroundings);
  ASSERT_TRUE(surface);
  mesh.clear();
  quality = render::kQualityLadder[2];
  work = scene.surroundings->margin;
  ServoTick tick;
  world.emplace(scene).apply(tick);
  const Shot rest = shoot();
  const auto press = [&](float inward) {
    for (std::uint32_t i = 0; i < surface->points().size(); ++i) {
      GumMoves moves{.count = 1};
      moves.points[0] = {i, inward};
      world->apply(ServoEvent(moves));
    }
    tick.t += 2 * World::kStep;
    world->apply(tick);
  };
  press(0.4e-3f);
  EXPECT_GT(compare(shoot().left, rest.left, 20).pixels, 300);
  press(0);
  EXPECT_LT(compare(shoot().left, rest.left, 20).pixels, 30) << "the gum returns to its shape";
}

TEST_F(XrGolden, ThePictureIsTheSameInEverySwapchainFormat) {
  const Shot first = shoot();
  const Shot swapped = shoot(R"("formats": ["D16_UNORM", "B8G8R8A8_UNORM", "B8G8R8A8_SRGB"], "images": 2)");
  EXPECT_EQ(compare(first.left, swapped.left, 1).pixels, 0);
  EXPECT_TRUE(swapped.depth_left.empty()) << "no D32 was offered, so no depth is handed over";
}

TEST_F(XrGolden, TheSubmittedDepthIsTheDistanceOfTheVisibleSurface) {
  mesh = {ball(1, {0, 0, 0}, 4e-3f, Tissue::kEnamel, 64)};
  for (const int step : {0, 2}) {  // with and without several samples a pixel
    quality = render::kQualityLadder[static_cast<std::size_t>(step)];
    const Shot shot = shoot();
    ASSERT_EQ(shot.depth_left.size(), 320u * 256u);
    // Computes the pixel of the ball's middle in the left picture.
    const display::EyeView& eye = shot.frame.eyes[0];
    const glm::dvec4 clip = eye.projection * eye.view * glm::dvec4(0, 0, 0, 1);
    const int x = static_cast<int>((clip.x / clip.w + 1) / 2 * 320),
              y = static_cast<int>((clip.y / clip.w + 1) / 2 * 256);
    const double z = shot.depth_left[static_cast<std::size_t>(y * 320 + x)];
    // The runtime was told these depth limits: near 20 mm, far 30 m. They are in the room's metres, which are 14 times
    // those of the workbench.
    const double near = 0.02, far = 30, distance = near * far / (far - z * (far - near));
    const dvec3 p_E(eye.view * glm::dvec4(0, 0, 0, 1));
    const double nearest = (glm::length(p_E) - 4e-3) * rig.hmd.magnify * (-p_E.z / glm::length(p_E));
    EXPECT_NEAR(distance, nearest, 2e-3) << quality.name;
  }
}

TEST_F(XrGolden, NothingIsDrawnBehindTheLensesRim) {
  // The mask hides everything that is more than tan = 0.15 to the right of the view's direction.
  const Shot open = shoot(), masked = shoot(R"("mask": [[0.15, -2], [2, -2], [2, 2], [0.15, -2], [2, 2], [0.15, 2]])");
  int hidden = 0;
  for (int y = 0; y < 256; ++y)
    for (int x = 0; x < 320; ++x) {
      const double tan_l = std::tan(-0.62), tan_r = std::tan(0.45), tan = tan_l + (x + 0.5) / 320 * (tan_r - tan_l);
      const std::uint8_t *a = open.left.at(x, y), *b = masked.left.at(x, y);
      if (tan > 0.16) {
        ASSERT_EQ(b[0] + b[1] + b[2], 0) << x << " " << y;
        hidden += a[0] + a[1] + a[2] > 60;
      }
      if (tan < 0.14) {
        for (int c = 0; c < 3; ++c) ASSERT_NEAR(a[c], b[c], 1) << x << " " << y;
      }
    }
  EXPECT_GT(hidden, 500);
}

TEST_F(XrGolden, InPassThroughTheBackgroundIsTransparentAndTheToothOpaque) {
  rig.hmd.passthrough = true;
  const Shot shot = shoot(R"("blend_modes": ["opaque", "alpha"])");
  EXPECT_EQ(shot.left.at(2, 2)[3], 0);
  int solid = 0;
  for (std::size_t i = 3; i < shot.left.rgba.size(); i += 4) solid += shot.left.rgba[i] == 255;
  EXPECT_GT(solid, 1000);
  EXPECT_GT(xr.count("projection+depth+alpha alpha"), 0);
  // The same must hold if a camera layer shows the room.
  shoot();
  EXPECT_GT(xr.count("passthrough projection+depth+alpha opaque"), 0);
}

TEST_F(XrGolden, ALostToolIsDrawnAsAPatternAndTheToothSolid) {
  const Shot whole = shoot(), half = shoot("", 0.5);
  const Difference d = compare(whole.left, half.left, 30);
  EXPECT_GT(d.pixels, 60);
  EXPECT_LT(d.pixels, 6000);
}

TEST_F(XrGolden, BothEyesReadTheTextsOfThePictureAtOneDistance) {
  const Shot without = shoot();
  hud = true;
  world->say("Keep 0.2 mm from the pulp");
  const Shot shot = shoot();
  // Returns the box of the pixels that the texts changed.
  const auto box = [](const render::Picture& a, const render::Picture& b) {
    glm::ivec2 lo = a.size, hi(0);
    for (int y = 0; y < a.size.y; ++y)
      for (int x = 0; x < a.size.x; ++x)
        if (std::memcmp(a.at(x, y), b.at(x, y), 3) != 0)
          lo = glm::min(lo, glm::ivec2(x, y)), hi = glm::max(hi, glm::ivec2(x, y));
    return std::pair{lo, hi};
  };
  const auto [left_lo, left_hi] = box(shot.left, without.left);
  const auto [right_lo, right_hi] = box(shot.right, without.right);
  ASSERT_GT(left_hi.x - left_lo.x, 60);
  EXPECT_EQ(left_hi - left_lo, right_hi - right_lo) << "the same texts";
  // Rays through the middles of both boxes meet in front of the user, ten times as far away as the eyes are apart.
  const auto ray = [&](int e, const glm::ivec2& lo, const glm::ivec2& hi) {
    const glm::dvec2 ndc = glm::dvec2(lo + hi + 1) / glm::dvec2(shot.left.size) - 1.0;
    const auto& eye = shot.frame.eyes[static_cast<std::size_t>(e)];
    const glm::dvec4 far = glm::inverse(eye.projection * eye.view) * glm::dvec4(ndc, 0.5, 1);
    return glm::normalize(dvec3(far) / far.w - eye.position);
  };
  const dvec3 a = ray(0, left_lo, left_hi), b = ray(1, right_lo, right_hi);
  EXPECT_NEAR(std::acos(glm::dot(a, b)), 0.1, 0.01);
}

}  // namespace
}  // namespace typodont::test
