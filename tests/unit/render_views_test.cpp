// Tests the views for teaching: what each view shows of a ball of enamel with pulp inside.
#include <gtest/gtest.h>

#include "tests/support/stage.h"
#include "tests/support/tooth_mesh.h"

namespace typodont::test {
namespace {

constexpr glm::ivec2 kSize{160, 128};

struct Views : testing::Test {
  Stage stage{kSize};
  render::Frame frame = frame_of(desk(0.03, 0.024, 0.35, {0, -0.01, 1}));
  void SetUp() override {
    const render::MeshUpdate tooth = ball(1, glm::vec3(0), 5e-3f, Tissue::kEnamel, 40);
    const render::MeshUpdate pulp = ball(1, glm::vec3(0), 2e-3f, Tissue::kPulp, 30);
    stage.renderer->update(render::kWorkingTooth, std::span(&tooth, 1));
    stage.renderer->update(render::kInsidePulp, std::span(&pulp, 1));
  }
  glm::ivec3 middle() {
    const render::Picture picture = stage.eye(0);
    const auto* c = picture.at(kSize.x / 2, kSize.y / 2);
    return {c[0], c[1], c[2]};
  }
};

TEST_F(Views, EveryViewIsCleanUnderTheValidationLayerAndMakesOnlyItsPipelines) {
  frame.background = render::Background::kBlack;
  EXPECT_EQ(stage.draw(frame).pipelines, 3);  // shadow, surface and its depth
  frame.view = render::View::kSection;
  frame.section = {0, 0, -1, 0};
  EXPECT_EQ(stage.draw(frame).pipelines, 2);
  frame.view = render::View::kXray;
  EXPECT_EQ(stage.draw(frame).pipelines, 3);  // solid and glass
  for (const render::View view : {render::View::kDifference, render::View::kTemperature}) {
    frame.view = view;
    EXPECT_EQ(stage.draw(frame).pipelines, 2);
  }
  EXPECT_EQ(stage.device.validation_messages(), 0);
}

TEST_F(Views, ASectionRemovesTissueInFrontOfThePlane) {
  frame.view = render::View::kSection;
  frame.section = {0, 0, -1, -2e-3};  // z < −2 mm stays
  const render::FrameStats cut = stage.draw(frame);
  EXPECT_EQ(cut.bricks_facing_away, 0);
  const render::Picture cut_picture = stage.eye(0);
  frame.section = {0, 0, -1, 1};  // all stays
  stage.draw(frame);
  const render::Picture whole = stage.eye(0);
  const auto covered = [](const render::Picture& p) {
    int n = 0;
    for (int y = 0; y < p.size.y; ++y)
      for (int x = 0; x < p.size.x; ++x) n += p.at(x, y)[0] > 70;
    return n;
  };
  // The plane cuts the ball of 5 mm radius at a height of 2 mm. The remaining disc has a radius of √(25 − 4) mm.
  EXPECT_NEAR(covered(cut_picture) / static_cast<double>(covered(whole)), 21.0 / 25, 0.05);
}

TEST_F(Views, DifferenceIsBlueForTissueToRemoveAndRedForMissingTissue) {
  render::MeshUpdate tooth = ball(1, glm::vec3(0), 5e-3f, Tissue::kEnamel, 40);
  frame.view = render::View::kDifference;
  const auto color_at = [&](float difference) {
    for (render::Vertex& v : tooth.vertices) v.difference = difference;
    stage.renderer->update(render::kWorkingTooth, std::span(&tooth, 1));
    stage.draw(frame);
    return middle();
  };
  const glm::ivec3 more = color_at(1e-3f), right = color_at(0), less = color_at(-1e-3f);
  EXPECT_GT(more.b, more.r + 60);
  EXPECT_GT(less.r, less.b + 60);
  EXPECT_LT(std::abs(right.r - right.b), 40);
}

TEST_F(Views, TheBackOfAnOpenSurfaceIsDullAndBlueGreyAndThatOfAClosedOneIsNotDrawn) {
  frame.background = render::Background::kBlack;
  stage.renderer->remove(render::kInsidePulp);
  // The sheet faces away from the eye, like a bowl whose inside is seen.
  render::MeshUpdate sheet;
  sheet.brick = 1;
  for (const glm::vec3 p : {glm::vec3(-4e-3f, -4e-3f, 0), {4e-3f, -4e-3f, 0}, {4e-3f, 4e-3f, 0}, {-4e-3f, 4e-3f, 0}}) {
    render::Vertex v;
    v.p = p, v.n = {0, 0, -1};
    sheet.vertices.push_back(v);
  }
  sheet.indices = {0, 2, 1, 0, 3, 2};
  const auto drawn = [&](bool two_sided) {
    sheet.two_sided = two_sided;
    stage.renderer->update(render::kWorkingTooth, std::span(&sheet, 1));
    stage.draw(frame);
    return middle();
  };
  const glm::ivec3 hidden = drawn(false), back = drawn(true);
  EXPECT_EQ(hidden, glm::ivec3(0));
  EXPECT_GT(back.b, back.r + 5);
  EXPECT_GT(back.r, 30);
  EXPECT_LT(back.b, 200);
  frame.view = render::View::kDifference;
  EXPECT_EQ(drawn(true), back);
  EXPECT_EQ(stage.device.validation_messages(), 0);
}

}  // namespace
}  // namespace typodont::test
