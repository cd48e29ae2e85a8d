#include <gmock/gmock.h>

#include <chrono>
#include <cmath>
#include <set>
#include <thread>

#include "engine/base/units.h"
#include "engine/render/sight.h"
#include "tests/support/default_colors.h"
#include "tests/support/folder.h"
#include "tests/support/stage.h"
#include "tests/support/tooth_mesh.h"

namespace typodont::test {
namespace {

render::Frame full_frame(const display::DisplayRig& rig, std::span<const render::Particle> particles) {
  render::Frame frame = frame_of(rig);
  frame.tool = {.visible = true,
                .X_WG = {dvec3(0, 0, 2e-3), rotation_between({0, 0, 1}, glm::normalize(dvec3(-.3, -.2, 1)))}};
  frame.particles = particles;
  return frame;
}

TEST(Frame, AFullFrameIsCleanUnderTheValidationLayer) {
  for (const render::Quality& quality : render::kQualityLadder) {
    Stage stage({320, 256}, quality);
    stage.renderer->update(0, tooth_mesh(2e-3, 0.5e-3));
    stage.renderer->set_tool(round_bur(1.4e-3));
    const std::vector<render::Particle> particles(50, {{0, 0, 4e-3f}, 1e-4f, {1, 1, 1}, 1});
    const render::FrameStats stats = stage.draw(full_frame(desk(0.03, 0.024, 0.35), particles));
    EXPECT_TRUE(stats.drawn);
    EXPECT_GT(stats.bricks_drawn, 0);
    // One pass draws the lamp's shadow map; one or two draw the eyes' pictures. If a picture has one sample per pixel,
    // a further pass per eye draws what lies over the scene.
    const int shadow = quality.shadow_map > 0 ? 1 : 0, over = stage.device.multiview || quality.samples > 1 ? 0 : 2;
    EXPECT_EQ(stats.passes, shadow + (stage.device.multiview ? 1 : 2) + over) << quality.name;
    // two for the surface (sound tissue, with decay), one more for its depth where light is per pixel
    EXPECT_EQ(stats.pipelines, 5 + shadow + (quality.light_per_vertex ? 0 : 1)) << quality.name;
    EXPECT_EQ(stage.device.validation_messages(), 0) << quality.name;
  }
}

TEST(Frame, ARendererUsesThePipelinesOfAnEarlierOneOnTheSameDevice) {
  Stage stage({160, 128});
  const auto draw = [&] {
    stage.renderer->update(0, tooth_mesh(0, 0.6e-3));
    stage.renderer->set_tool(round_bur(1.4e-3));
    EXPECT_TRUE(stage.draw(full_frame(desk(0.03, 0.024, 0.35), {})).drawn);
    return stage.eye(0);
  };
  const render::Picture first = draw();
  const std::size_t created = stage.device.created_pipelines.size();
  EXPECT_GT(created, 3u);
  stage.renderer.emplace(stage.device, stage.size, render::kQualityLadder[0], render::default_colors());
  EXPECT_EQ(compare(draw(), first, 0).pixels, 0);
  EXPECT_EQ(stage.device.created_pipelines.size(), created);
  EXPECT_EQ(stage.device.validation_messages(), 0);
}

TEST(Frame, APreparedFrameWaitsForNoPipelineInAnyView) {
  for (const render::Quality& quality : {render::kQualityLadder.front(), render::kQualityLadder.back()}) {
    Stage stage({160, 128}, quality);
    stage.renderer->update(0, tooth_mesh(2e-3, 0.5e-3));
    stage.renderer->set_tool(round_bur(1.4e-3));
    const std::vector<render::Particle> particles{{{0, 0, 4e-3f}, 1e-4f, {1, 1, 1}, 1},
                                                  {{0, 0, 4e-3f}, 1e-4f, {1, 1, 1}, 1, {0, 0, 1e-3f}}};
    render::Frame frame = full_frame(desk(0.03, 0.024, 0.35), particles);
    frame.cursor = {.visible = true, .p = {0, 0, 4e-3}};
    frame.mirror = {{dvec3(0, 0, -3e-3), rotation_between({0, 0, 1}, glm::normalize(dvec3(0.4, -0.6, 0.8)))}, 16e-3};
    frame.suction = {.X_WS = {dvec3(4e-3, 2e-3, 8e-3), {1, 0, 0, 0}}, .opening = 3e-3};
    for (const render::View view : {render::View::kLook, render::View::kSection, render::View::kXray}) {
      frame.view = view;
      while (!stage.renderer->prepare(frame)) std::this_thread::sleep_for(std::chrono::milliseconds(1));
      EXPECT_TRUE(stage.draw(frame).drawn);
      EXPECT_EQ(stage.device.unprepared_pipelines, 0) << quality.name << ", view " << static_cast<int>(view);
    }
    EXPECT_EQ(stage.device.validation_messages(), 0);
  }
}

TEST(Frame, ARendererMayEndOrDrawWhileItsPipelinesAreCreated) {
  Stage stage({160, 128});
  const render::Frame frame = full_frame(desk(0.03, 0.024, 0.35), {});
  for (int i = 0; i < 2; ++i) {
    stage.renderer.emplace(stage.device, stage.size, render::kQualityLadder[0], render::default_colors());
    stage.renderer->update(0, tooth_mesh(0, 0.6e-3));
    EXPECT_FALSE(stage.renderer->prepare(frame));
  }
  EXPECT_TRUE(stage.draw(frame).drawn);
  EXPECT_EQ(stage.device.unprepared_pipelines, 0);
  EXPECT_EQ(stage.device.validation_messages(), 0);
}

TEST(Frame, InvisibleMotionCausesNoNewFrameUntilItBecomesVisible) {
  Stage stage({160, 128}, render::kQualityLadder[0], Passes::kTwo);
  stage.renderer->update(0, tooth_mesh(0, 0.6e-3));
  stage.renderer->set_tool(round_bur(1.4e-3));
  render::Frame frame = full_frame(desk(0.03, 0.024, 0.35), {});
  const double seen = frame.tool.X_WG.p.x;
  EXPECT_TRUE(stage.draw(frame).drawn);
  const render::Picture with = stage.eye(0);
  frame.tool.X_WG.p.x = seen + 0.5;
  EXPECT_TRUE(stage.draw(frame).drawn) << "it is gone";
  const render::Picture without = stage.eye(0);
  EXPECT_GT(compare(with, without, 8).pixels, 100);
  for (int i = 1; i < 5; ++i) {
    frame.tool.X_WG.p.x = seen + 0.5 + 0.01 * i;
    const render::FrameStats stats = stage.draw(frame);
    EXPECT_FALSE(stats.drawn);
    EXPECT_EQ(stats.commands, 0);
  }
  frame.tool.X_WG.p.x = seen;
  EXPECT_TRUE(stage.draw(frame).drawn) << "it is back";
  EXPECT_EQ(compare(stage.eye(0), with, 0).pixels, 0);
}

TEST(Frame, InvisibleChangesOfTissueCauseNoNewFrameAndAppearWhenVisible) {
  constexpr render::MeshId kOther = 1;  // beside the picture
  const Pose X_WM{dvec3(30e-3, 0, 0), {1, 0, 0, 0}};
  const auto tooth = tooth_mesh(0, 0.4e-3);
  for (const Passes passes : {Passes::kTwo, Passes::kOne}) {
    Stage stage({160, 128}, render::kQualityLadder[0], passes), fresh({160, 128}, render::kQualityLadder[0], passes);
    std::vector<render::MeshUpdate> left;  // of the other
    for (Stage* s : {&stage, &fresh}) {
      s->renderer->update(0, tooth);
      s->renderer->place(kOther, X_WM);
    }
    stage.renderer->update(kOther, tooth);
    const render::Frame close = frame_of(desk(0.02, 0.016, 0.35));
    ASSERT_TRUE(stage.draw(close).drawn);
    const render::Picture before = stage.eye(0);
    for (const render::MeshUpdate& brick : tooth) {
      const render::MeshUpdate gone{brick.brick, {}, {}};
      stage.renderer->update(kOther, std::span(&gone, 1));
      const render::FrameStats stats = stage.draw(close);
      EXPECT_EQ(stats.commands > 0, stats.drawn);
      if (!stats.drawn) continue;
      stage.renderer->update(kOther, std::span(&brick, 1));  // without it the lamp's map lies elsewhere
      left.push_back(brick);
    }
    EXPECT_LT(2 * left.size(), tooth.size());
    stage.draw(close);
    EXPECT_LE(compare(stage.eye(0), before, 1).pixels, 0);
    const render::Frame wide = frame_of(desk(0.1, 0.08, 0.35));
    fresh.renderer->update(kOther, left);
    stage.draw(wide);
    fresh.draw(wide);
    for (int e = 0; e < 2; ++e) EXPECT_EQ(compare(stage.eye(e), fresh.eye(e), 0).pixels, 0);
  }
}

TEST(Frame, ABodyIsVisibleDirectlyInAMirrorOrByItsShadow) {
  const auto at = [](const dvec3& middle) { return render::BoxInWorld{middle - 5e-3, middle + 5e-3}; };
  render::Frame frame = frame_of(desk(0.03, 0.024, 0.35));
  const dvec3 toward = glm::normalize(dvec3(0, -0.6, 0.8)), beside(0.2, 0, 0);
  EXPECT_TRUE(render::in_sight(frame, at(dvec3(0))));
  EXPECT_TRUE(render::in_sight(frame, at({18e-3, 0, 0}))) << "a corner of it";
  EXPECT_FALSE(render::in_sight(frame, at(beside)));
  EXPECT_FALSE(render::in_sight(frame, at(0.5 * toward))) << "behind the eyes";
  // Between the lamp and what is seen.
  EXPECT_TRUE(render::in_sight(frame, at(30e-3 * frame.lights.key)));
  EXPECT_FALSE(render::in_sight(frame, at(beside + 30e-3 * frame.lights.key)));
  // A mirror in the middle of the picture shows what is to the right of the picture. Then the mirror is turned, so that
  // the picture shows its back.
  const dvec3 half_way = glm::normalize(toward + dvec3(1, 0, 0));
  frame.mirror = {{dvec3(0), rotation_between({0, 0, 1}, half_way)}, 16e-3, 0};
  EXPECT_TRUE(render::in_sight(frame, at(beside)));
  EXPECT_FALSE(render::in_sight(frame, at(-beside)));
  frame.mirror.X_WM.R = rotation_between({0, 0, 1}, -half_way);
  EXPECT_FALSE(render::in_sight(frame, at(beside)));
  // One eye is enough.
  frame.mirror = {};
  frame.eyes[0] = frame_of(desk(0.03, 0.024, 0.35, {0, 0.6, -0.8})).eyes[0];
  EXPECT_TRUE(render::in_sight(frame, at(dvec3(0))));
  frame.views = 1;
  frame.eyes[0] = frame_of([&] {
                    display::DisplayRig other = desk(0.03, 0.024, 0.35);
                    for (dvec3* p : {&other.screen.lower_left, &other.screen.lower_right, &other.screen.upper_left,
                                     &other.head.eye_center})
                      *p -= beside;
                    return other;
                  }())
                      .eyes[0];
  EXPECT_FALSE(render::in_sight(frame, at(dvec3(0)))) << "mono: the second does not count";
}

TEST(Frame, OnlyChangedBricksAreUploadedAndOnlyTheyHaveTheShadowMapRedrawn) {
  Stage stage({160, 128});
  const auto tooth = tooth_mesh(0, 0.6e-3);
  stage.renderer->update(0, tooth);
  stage.renderer->set_tool(round_bur(1.4e-3));
  render::Frame frame = full_frame(desk(0.03, 0.024, 0.35), {});
  const int eyes = stage.device.multiview ? 1 : 2;
  const render::FrameStats first = stage.draw(frame);
  EXPECT_EQ(first.passes, eyes + 1);
  EXPECT_EQ(first.bricks_uploaded, static_cast<int>(tooth.size()));
  frame.tool.X_WG.p.x += 1e-4;
  EXPECT_EQ(stage.draw(frame).passes, eyes);
  stage.renderer->update(0, std::span(tooth).first(1));
  const render::FrameStats changed = stage.draw(frame);
  EXPECT_EQ(changed.passes, eyes + 1);
  EXPECT_EQ(changed.bricks_uploaded, 1);
  EXPECT_LT(changed.bytes_uploaded, first.bytes_uploaded);
}

TEST(Frame, RemovedBricksGiveTheirMemoryBack) {
  Stage stage({64, 64});
  const auto tooth = tooth_mesh(0, 0.5e-3);
  render::Frame frame = frame_of(desk(0.03, 0.024, 0.35));
  for (int i = 0; i < 4; ++i) {  // until every frame in flight has its buffers
    stage.renderer->update(0, tooth);
    stage.draw(frame);
  }
  const std::uint64_t used = stage.device.memory_used();
  for (int i = 0; i < 60; ++i) {
    stage.renderer->update(0, tooth);
    frame.lights.ambient += 0.001;
    stage.draw(frame);
  }
  EXPECT_EQ(stage.device.memory_used(), used);
}

TEST(Frame, BricksOutOfViewOrFacingAwayAreNotDrawn) {
  Stage stage({160, 128});
  stage.renderer->update(0, tooth_mesh(0, 0.4e-3));
  const render::FrameStats near = stage.draw(frame_of(desk(0.03, 0.024, 0.35)));
  EXPECT_GT(near.bricks_facing_away, 0);
  display::DisplayRig small = desk(0.004, 0.003, 0.35);
  const render::FrameStats close = stage.draw(frame_of(small));
  EXPECT_GT(close.bricks_culled, 0);
  EXPECT_LT(close.bricks_drawn, near.bricks_drawn);
}

TEST(Frame, CoveredBricksAreDrawnOnlyAfterTheyChange) {
  Stage stage({160, 128});
  const auto tooth = tooth_mesh(0, 0.4e-3);
  stage.renderer->cover(0, {0, 0, 1, 3e-3});  // all below −3 mm
  stage.renderer->update(0, tooth);
  render::Frame frame = frame_of(desk(0.03, 0.024, 0.35));
  const render::FrameStats first = stage.draw(frame);
  EXPECT_GT(first.bricks_covered, 0);
  for (const auto& brick : tooth) stage.renderer->update(0, std::span(&brick, 1));
  const render::FrameStats changed = stage.draw(frame);
  EXPECT_EQ(changed.bricks_covered, 0);
  EXPECT_GT(changed.triangles, first.triangles);
  stage.renderer->remove(0);
  stage.renderer->update(0, tooth);
  frame.view = render::View::kXray;
  EXPECT_EQ(stage.draw(frame).bricks_covered, 0);
}

TEST(Frame, CullingChangesNoPixel) {
  // The same tooth as a single brick, which is always drawn.
  const auto bricks = tooth_mesh(2e-3, 0.4e-3);
  render::MeshUpdate whole{.brick = 1, .vertices = {}, .indices = {}};
  for (const auto& b : bricks) {
    const auto first = static_cast<std::uint32_t>(whole.vertices.size());
    whole.vertices.insert(whole.vertices.end(), b.vertices.begin(), b.vertices.end());
    for (const std::uint32_t i : b.indices) whole.indices.push_back(first + i);
  }
  const render::Frame frame = frame_of(desk(0.012, 0.01, 0.35));
  Stage in_bricks({200, 160}), in_one({200, 160});
  in_bricks.renderer->update(0, bricks);
  in_one.renderer->update(0, std::span(&whole, 1));
  const render::FrameStats stats = in_bricks.draw(frame);
  EXPECT_GT(stats.bricks_culled + stats.bricks_facing_away, 0);
  in_one.draw(frame);
  for (int e = 0; e < 2; ++e) EXPECT_LE(compare(in_bricks.eye(e), in_one.eye(e), 1).pixels, 6);
}

TEST(Frame, TheNeckJoinsHeadAndShankHoweverLargeAPixelIs) {
  for (const render::Quality& quality : render::kQualityLadder) {
    Stage stage({320, 256}, quality);
    stage.renderer->set_tool(round_bur(0.8e-3));
    for (int i = 0; i < 6; ++i) {
      // A pixel is as large as a third of the neck's width up to three times this width. The tool is at any position
      // between pixels.
      const double width = 0.02 * std::pow(2, i);
      render::Frame frame = frame_of(desk(width, 0.8 * width, 0.35));
      frame.background = render::Background::kBlack;
      frame.tool = {
          .visible = true,
          .X_WG = {dvec3(0.13e-3 * i, 0.11e-3 * i, 0), rotation_between({0, 0, 1}, glm::normalize(dvec3(-.3, .5, 1)))}};
      stage.draw(frame);
      const render::Picture picture = stage.eye(0);
      const auto lit = [&](const glm::ivec2& p) {
        return p.x >= 0 && p.y >= 0 && p.x < picture.size.x && p.y < picture.size.y && picture.at(p.x, p.y)[1] > 12;
      };
      // All bright pixels are connected.
      std::set<std::pair<int, int>> left;
      for (int y = 0; y < picture.size.y; ++y)
        for (int x = 0; x < picture.size.x; ++x)
          if (lit({x, y})) left.insert({x, y});
      ASSERT_FALSE(left.empty());
      std::vector<std::pair<int, int>> next{*left.begin()};
      left.erase(left.begin());
      while (!next.empty()) {
        const auto [x, y] = next.back();
        next.pop_back();
        for (int dx = -1; dx <= 1; ++dx)
          for (int dy = -1; dy <= 1; ++dy)
            if (left.erase({x + dx, y + dy}) > 0) next.push_back({x + dx, y + dy});
      }
      EXPECT_TRUE(left.empty()) << quality.name << ", a picture of " << 1e3 * width << " mm: " << left.size()
                                << " pixels apart from the others";
      // The tool's head must be among the bright pixels.
      const glm::dvec4 c = frame.eyes[0].projection * frame.eyes[0].view * glm::dvec4(frame.tool.X_WG.p, 1);
      const glm::ivec2 head((0.5 + 0.5 * glm::dvec2(c) / c.w) * glm::dvec2(picture.size));
      bool there = false;
      for (int dx = -1; dx <= 1; ++dx)
        for (int dy = -1; dy <= 1; ++dy) there = there || lit(head + glm::ivec2(dx, dy));
      EXPECT_TRUE(there) << quality.name << ", a picture of " << 1e3 * width << " mm";
    }
  }
}

TEST(Frame, TheCursorsRingIsDrawnOnTheFirstSurfaceAlongItsLine) {
  for (const std::size_t step : {0u, 4u}) {
    Stage stage({320, 256}, render::kQualityLadder[step]);
    stage.renderer->update(0, tooth_mesh(0, 0.4e-3));
    render::Frame frame = frame_of(desk(0.02, 0.016, 0.35));
    frame.views = 1;
    stage.draw(frame);
    const render::Picture without = stage.eye(0);
    // Along the line of sight, the ring must be a circle, whatever shape the surface has.
    const dvec3 eye = frame.eyes[0].position, toward = glm::normalize(eye);
    frame.cursor = {true, 8e-3 * toward, glm::normalize(8e-3 * toward - eye), 2e-3};
    EXPECT_TRUE(stage.draw(frame).drawn);
    const render::Picture with = stage.eye(0);
    const auto pixel = [&](const dvec3& p) {
      const glm::dvec4 c = frame.eyes[0].projection * frame.eyes[0].view * glm::dvec4(p, 1);
      return (0.5 + 0.5 * glm::dvec2(c) / c.w) * glm::dvec2(with.size);
    };
    const dvec3 side = glm::normalize(glm::cross(toward, dvec3(0, 0, 1)));
    const glm::dvec2 middle = pixel(frame.cursor.p);
    const double radius = glm::length(pixel(frame.cursor.p + 2e-3 * side) - middle);
    std::set<int> octants;
    for (int y = 0; y < with.size.y; ++y)
      for (int x = 0; x < with.size.x; ++x) {
        int differs = 0;
        for (int c = 0; c < 3; ++c) differs = std::max(differs, std::abs(with.at(x, y)[c] - without.at(x, y)[c]));
        if (differs <= 8) continue;
        const glm::dvec2 d = glm::dvec2(x + 0.5, y + 0.5) - middle;
        EXPECT_NEAR(glm::length(d), radius, 0.35 * radius + 2) << x << " " << y;
        octants.insert(static_cast<int>(std::floor((std::atan2(d.y, d.x) + kPi) / (kPi / 4))) % 8);
      }
    EXPECT_EQ(octants.size(), 8u) << "all round";
    // If the cursor is inside or behind the body, its line does not enter the body. Then no ring may be drawn.
    frame.cursor.p = -8e-3 * toward;
    frame.cursor.down = toward;
    stage.draw(frame);
    EXPECT_EQ(compare(stage.eye(0), without, 0).pixels, 0);
  }
}

TEST(Frame, AbsentPartsHaveNoPipeline) {
  Stage stage({64, 64});
  render::Frame frame = frame_of(desk(0.03, 0.024, 0.35));
  frame.background = render::Background::kBlack;
  EXPECT_EQ(stage.draw(frame).pipelines, 0);
  stage.renderer->update(0, tooth_mesh(0, 0.8e-3));
  EXPECT_EQ(stage.draw(frame).pipelines, 3);  // surface, sound all over, its depth and its shadow
}

TEST(Frame, BothEyesTogetherEqualEachEyeAlone) {
  // The camera is so close that triangles cross every edge of the picture.
  for (const render::Quality& quality : {render::kQualityLadder[0], render::kQualityLadder[2]}) {
    Stage stage({200, 160}, quality);
    stage.renderer->update(0, tooth_mesh(2e-3, 0.8e-3));
    stage.renderer->set_tool(round_bur(1.4e-3));
    const std::vector<render::Particle> particles(1, {{0, 0, 4e-3f}, 2e-3f, {1, 1, 1}, 1});
    render::Frame frame = full_frame(desk(0.007, 0.0056, 0.35), particles);
    stage.draw(frame);
    const render::Picture both[2] = {stage.eye(0), stage.eye(1)};
    const std::array<render::Eye, 2> eyes = frame.eyes;
    frame.views = 1;
    for (std::size_t e = 0; e < 2; ++e) {
      frame.eyes[0] = eyes[e];
      stage.draw(frame);
      const Difference d = compare(both[e], stage.eye(0), 2);
      EXPECT_EQ(d.pixels, 0) << quality.name << ", eye " << e << ", worst " << d.worst;
    }
  }
}

TEST(Frame, OnePassForBothEyesDrawsWhatTwoPassesDraw) {
  // If nothing crosses the picture's edge and there is no multisampling, multiview is right on every driver.
  render::Picture pictures[2][2];
  for (int one_pass = 0; one_pass < 2; ++one_pass) {
    Stage stage({200, 160}, render::kQualityLadder[2], one_pass ? test::Passes::kOne : test::Passes::kTwo);
    stage.renderer->update(0, tooth_mesh(2e-3, 0.8e-3));
    render::Frame frame = frame_of(desk(0.04, 0.032, 0.35));
    frame.background = render::Background::kBlack;
    EXPECT_EQ(stage.draw(frame).passes, one_pass ? 2 : 3);
    for (int e = 0; e < 2; ++e) pictures[one_pass][e] = stage.eye(e);
    EXPECT_EQ(stage.device.validation_messages(), 0);
  }
  for (int e = 0; e < 2; ++e) EXPECT_EQ(compare(pictures[0][e], pictures[1][e], 0).pixels, 0);
  EXPECT_GT(compare(pictures[0][0], pictures[0][1], 8).pixels, 100) << "the eyes see the same";
}

TEST(Device, AMissingDeviceIsAClearError) {
  EXPECT_THAT(test::refusal([&] { (void)gpu::Device::create({.prefer = "no such device"}); }),
              testing::HasSubstr("Vulkan 1.3"));
}

}  // namespace
}  // namespace typodont::test
