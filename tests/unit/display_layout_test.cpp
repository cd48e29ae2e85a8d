// Every layout is decoded back into the two eyes.
#include <gtest/gtest.h>

#include "tests/support/stage.h"
#include "tests/support/tooth_mesh.h"

namespace typodont::test {
namespace {

using display::Layout;

struct Layouts : testing::Test {
  static constexpr int kWidth = 160, kHeight = 120;
  Stage stage{{kWidth, kHeight}};
  render::Frame frame = frame_of(desk(0.03, 0.0225, 0.35));

  void SetUp() override {
    stage.renderer->update(0, tooth_mesh(2e-3, 0.6e-3));
    frame.hud = {.visible = true, .tool = "round 1.2 mm", .speed_krpm = 300};
  }
  void TearDown() override { EXPECT_EQ(stage.device.validation_messages(), 0); }
  render::Picture part(int x0, int y0) const {
    render::Picture p{{kWidth, kHeight}, {}};
    for (int y = 0; y < kHeight; ++y)
      p.rgba.insert(p.rgba.end(), stage.screen.at(x0, y0 + y), stage.screen.at(x0, y0 + y) + 4 * kWidth);
    return p;
  }
};

TEST_F(Layouts, SideBySideAndTwoOutputsHoldTheEyesSideBySide) {
  for (const Layout layout : {Layout::kSideBySide, Layout::kTwoOutputs}) {
    stage.draw(frame, layout);
    EXPECT_EQ(compare(part(0, 0), stage.eye(0), 0).pixels, 0);
    EXPECT_EQ(compare(part(kWidth, 0), stage.eye(1), 0).pixels, 0);
  }
  EXPECT_GT(compare(stage.eye(0), stage.eye(1), 8).pixels, 100) << "the eyes see the same";
}

TEST_F(Layouts, TopBottomAndFrameSequentialHoldTheEyesOneAboveTheOther) {
  for (const Layout layout : {Layout::kTopBottom, Layout::kFrameSequential}) {
    stage.draw(frame, layout);
    EXPECT_EQ(compare(part(0, 0), stage.eye(0), 0).pixels, 0);
    EXPECT_EQ(compare(part(0, kHeight), stage.eye(1), 0).pixels, 0);
  }
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

TEST_F(Layouts, MonoIsTheOneEye) {
  frame.views = 1;
  stage.draw(frame, Layout::kMono);
  EXPECT_EQ(compare(stage.screen, stage.eye(0), 0).pixels, 0);
}

}  // namespace
}  // namespace typodont::test
