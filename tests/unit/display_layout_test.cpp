// Tests that every layout can be decoded into the pictures of the two eyes.
#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

#include "tests/support/stage.h"
#include "tests/support/tooth_mesh.h"

namespace typodont::test {
namespace {

using display::Layout;
using Parts = std::array<std::vector<display::Part>, 2>;  // per panel

struct Layouts : testing::Test {
  static constexpr int kWidth = 160, kHeight = 120;
  Stage stage{{kWidth, kHeight}};
  render::Frame frame = frame_of(desk(0.03, 0.0225, 0.35));

  void SetUp() override { stage.renderer->update(0, tooth_mesh(2e-3, 0.6e-3)); }
  void TearDown() override { EXPECT_EQ(stage.device.validation_messages(), 0); }
  render::Picture part(int x0, int y0) const {
    render::Picture p{{kWidth, kHeight}, {}};
    for (int y = 0; y < kHeight; ++y)
      p.rgba.insert(p.rgba.end(), stage.screen.at(x0, y0 + y), stage.screen.at(x0, y0 + y) + 4 * kWidth);
    return p;
  }

  std::vector<std::uint8_t> memory;  // BGRA, the screen as the CPU composes it
  /// Composes the screen on the CPU. `changed`: only these parts.
  void compose(Layout layout, const Parts* changed = nullptr) {
    display::Target target;
    target.memory = {memory.data(), 4 * static_cast<std::size_t>(stage.screen.size.x)};
    target.size = stage.screen.size;
    target.kept = changed != nullptr;
    gpu::run_once(stage.device, [&](VkCommandBuffer commands) {
      stage.compositor->record(commands, stage.renderer->pictures(), layout, target, 0, 0, changed,
                               {&stage.hud, &stage.hud});
    });
    stage.compositor->compose(0);
  }
  void expect_the_shaders_picture(int tolerance, Layout layout) {
    render::Picture composed{stage.screen.size, memory};
    for (std::size_t i = 0; i < memory.size(); i += 4) std::swap(composed.rgba[i], composed.rgba[i + 2]);
    const Difference d = compare(composed, stage.screen, tolerance);
    EXPECT_EQ(d.pixels, 0) << "layout " << static_cast<int>(layout) << " worst " << d.worst;
  }
};

TEST_F(Layouts, ThatShowTheWholePicturesPlaceThemSideBySideOrOneAboveTheOther) {
  for (const auto& [layout, second] : {std::pair(Layout::kSideBySide, glm::ivec2(kWidth, 0)),
                                       {Layout::kTwoOutputs, {kWidth, 0}},
                                       {Layout::kTopBottom, {0, kHeight}},
                                       {Layout::kFrameSequential, {0, kHeight}}}) {
    stage.draw(frame, layout);
    EXPECT_EQ(compare(part(0, 0), stage.eye(0), 0).pixels, 0);
    EXPECT_EQ(compare(part(second.x, second.y), stage.eye(1), 0).pixels, 0);
  }
  EXPECT_GT(compare(stage.eye(0), stage.eye(1), 8).pixels, 100) << "the eyes see the same";
}

TEST_F(Layouts, RowInterleavedGivesEvenRowsToTheLeftEye) {
  stage.draw(frame, Layout::kRowInterleaved);
  const render::Picture eyes[2] = {stage.eye(0), stage.eye(1)};
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      for (int c = 0; c < 3; ++c) ASSERT_EQ(stage.screen.at(x, y)[c], eyes[y & 1].at(x, y)[c]) << x << "," << y;
}

TEST_F(Layouts, AnaglyphGivesRedToTheLeftEyeAndCyanToTheRight) {
  stage.draw(frame, Layout::kAnaglyph);
  const render::Picture left = stage.eye(0), right = stage.eye(1);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      ASSERT_EQ(stage.screen.at(x, y)[0], left.at(x, y)[0]);
      ASSERT_EQ(stage.screen.at(x, y)[1], right.at(x, y)[1]);
      ASSERT_EQ(stage.screen.at(x, y)[2], right.at(x, y)[2]);
    }
}

TEST_F(Layouts, MonoDrawsAndShowsOneView) {
  frame.views = 1;
  EXPECT_EQ(stage.draw(frame, Layout::kMono).views, 1);
  EXPECT_EQ(stage.renderer->pictures().options.layers, 1u);
  EXPECT_EQ(compare(stage.screen, stage.eye(0), 0).pixels, 0);
}

// The CPU and the shader must compose the same picture: in every layout, with pictures that fit or are stretched, whole
// and in parts.
TEST_F(Layouts, CpuAndShaderComposeTheSamePicture) {
  for (const double scale : {1.0, 0.4, 0.73}) {
    SCOPED_TRACE(scale);
    render::Quality quality = render::kQualityLadder[2];
    quality.scale = scale;
    stage.renderer->set_quality(quality);
    for (const Layout layout : {Layout::kMono, Layout::kSideBySide, Layout::kTopBottom, Layout::kRowInterleaved,
                                Layout::kAnaglyph, Layout::kTwoOutputs, Layout::kFrameSequential}) {
      stage.hud = {.visible = true, .tool = "round 1.2 mm", .speed_krpm = stage.hud.speed_krpm + 1, .hint = "hint"};
      frame.views = layout == Layout::kMono ? 1 : 2;
      stage.draw(frame, layout);
      memory.assign(stage.screen.rgba.size(), 77);
      compose(layout);
      expect_the_shaders_picture(scale == 1.0 ? 0 : 2, layout);
      // Only the given parts may be composed again; the rest of the screen must stay as it was.
      const Parts none, some{{{{3, 5, 31, 17}, {20, 40, 9, 5}}, {{7, 11, 13, 23}}}};
      const std::vector<std::uint8_t> old = memory;
      compose(layout, &none);
      EXPECT_EQ(memory, old);
      std::fill(memory.begin(), memory.end(), std::uint8_t{77});
      compose(layout, &some);
      int written = 0;
      for (std::size_t i = 0; i < memory.size(); ++i) {
        if (memory[i] == 77) continue;
        ++written;
        ASSERT_EQ(memory[i], old[i]) << "layout " << static_cast<int>(layout) << " byte " << i;
      }
      EXPECT_GT(written, 1000);
      // If a part touches a panel, the whole panel is written. All other panels must not be written.
      EXPECT_LT(written, static_cast<int>(memory.size()) * 2 / 3);
    }
  }
}

TEST_F(Layouts, CpuAndShaderWarpThePicturesOfABentPanelAlike) {
  display::DisplayRig rig;
  rig.screen.bow = {8e-3, -6e-3, 5e-3};
  const auto warp = display::warp(rig);
  ASSERT_TRUE(warp);
  stage.hud = {};
  for (const Layout layout : {Layout::kSideBySide, Layout::kRowInterleaved, Layout::kAnaglyph}) {
    stage.compositor->bend({});
    stage.draw(frame, layout);
    const render::Picture plane = stage.screen;
    stage.compositor->bend(warp);
    stage.draw(frame, layout);
    EXPECT_GT(compare(stage.screen, plane, 8).pixels, 100) << static_cast<int>(layout);
    memory.assign(stage.screen.rgba.size(), 77);
    compose(layout);
    expect_the_shaders_picture(2, layout);
  }
}

}  // namespace
}  // namespace typodont::test
