#include <gtest/gtest.h>

#include <vector>

#include "engine/base/voxels.h"
#include "tests/support/stage.h"
#include "tests/support/tooth_mesh.h"

namespace typodont::test {
namespace {

/// A grid around the tooth, with a texel for each of its cells.
struct Film {
  Film() {
    grid.spacing = 0.5e-3;
    grid.origin = dvec3(-10e-3);
    grid.size = glm::ivec3(41);
    texels.resize(41 * 41 * 41);
  }
  /// Samples lo … hi get this texel.
  render::CellBox put(const glm::ivec3& lo, const glm::ivec3& hi, const render::FilmTexel& texel) {
    for_each_voxel_between(
        lo, hi, [&](int x, int y, int z) { texels[static_cast<std::size_t>((x * 41 + y) * 41 + z)] = texel; });
    return {lo, hi};
  }
  render::FilmGrid grid;
  std::vector<render::FilmTexel> texels;
};

constexpr render::FilmTexel kSlurry{.water = 200, .cover = 220, .colour = 255, .blood = 0};

TEST(FilmOfTheFrame, ChangesTheLookAtEveryQualityAndLeavesNoTraceWhenItIsGone) {
  // Tests three quality levels: with light per pixel, with light per corner, and the lowest level.
  for (const std::size_t step : {std::size_t{0}, std::size_t{2}, std::size(render::kQualityLadder) - 1}) {
    const render::Quality& quality = render::kQualityLadder[step];
    Stage stage({160, 128}, quality);
    stage.renderer->update(0, tooth_mesh(0, 0.5e-3));
    const render::Frame frame = frame_of(desk(0.03, 0.024, 0.35));
    const render::FrameStats first = stage.draw(frame);
    const render::Picture dry = stage.eye(0);
    Film film;
    stage.renderer->set_film(film.grid);
    EXPECT_EQ(stage.draw(frame).film_bytes, 0u);
    EXPECT_EQ(compare(stage.eye(0), dry, 1).pixels, 0) << quality.name << ": an empty film looks dry";
    const render::CellBox all = film.put(glm::ivec3(0), glm::ivec3(40), kSlurry);
    stage.renderer->update_film(film.texels, {&all, 1});
    const render::FrameStats wet = stage.draw(frame);
    EXPECT_EQ(wet.film_bytes, film.texels.size() * sizeof(render::FilmTexel));
    EXPECT_EQ(wet.pipelines, first.pipelines) << "the film needs no pipeline of its own";
    EXPECT_GT(compare(stage.eye(0), dry, 20).pixels, dry.size.x * dry.size.y / 20) << quality.name;
    EXPECT_FALSE(stage.draw(frame).drawn) << "nothing has changed";
    stage.renderer->set_film({});
    stage.draw(frame);
    EXPECT_EQ(compare(stage.eye(0), dry, 0).pixels, 0) << quality.name;
    EXPECT_EQ(stage.device.validation_messages(), 0) << quality.name;
  }
}

TEST(FilmOfTheFrame, AChangedBlockRedrawsItsTilesOnlyAndLooksLikeAFullRedraw) {
  Stage stage({320, 256}, render::kQualityLadder[0], Passes::kTwo),
      fresh({320, 256}, render::kQualityLadder[0], Passes::kTwo);
  const render::Frame frame = frame_of(desk(0.03, 0.024, 0.35));
  Film film;
  for (Stage* s : {&stage, &fresh}) {
    s->renderer->update(0, tooth_mesh(0, 0.5e-3));
    s->renderer->set_film(film.grid);
  }
  stage.draw(frame);
  const render::Picture dry = stage.eye(0);
  const render::CellBox some = film.put({20, 16, 16}, {24, 20, 40}, kSlurry);
  for (Stage* s : {&stage, &fresh}) s->renderer->update_film(film.texels, {&some, 1});
  const render::FrameStats stats = stage.draw(frame);
  EXPECT_TRUE(stats.drawn);
  EXPECT_GT(stats.redrawn, 0);
  EXPECT_LT(stats.redrawn, 0.5);
  fresh.draw(frame);
  for (int e : {0, 1}) EXPECT_EQ(compare(stage.eye(e), fresh.eye(e), 0).pixels, 0);
  EXPECT_GT(compare(stage.eye(0), dry, 20).pixels, 20);
}

TEST(Streak, IsDrawnAlongItsWayByAPipelineOfItsOwn) {
  Stage stage({160, 128}, render::kQualityLadder[0], Passes::kOne);
  render::Frame frame = frame_of(desk(0.03, 0.024, 0.35));
  frame.background = render::Background::kBlack;
  const auto lit = [&](const render::Particle& particle) {
    frame.particles = {&particle, 1};
    const render::FrameStats stats = stage.draw(frame);
    const render::Picture picture = stage.eye(0);
    int count = 0;
    for (int y = 0; y < picture.size.y; ++y)
      for (int x = 0; x < picture.size.x; ++x) count += picture.at(x, y)[0] > 40;
    return std::pair(count, stats.pipelines);
  };
  const auto [round, one] = lit({.p = glm::vec3(0), .radius = 3e-4f, .color = glm::vec3(1), .opacity = 1});
  const auto [streak, two] =
      lit({.p = glm::vec3(0), .radius = 3e-4f, .color = glm::vec3(1), .opacity = 1, .streak = {3e-3f, 0, 0}});
  EXPECT_GT(round, 0);
  EXPECT_GT(streak, 2 * round);
  EXPECT_EQ(two, one + 1);
  EXPECT_EQ(stage.device.validation_messages(), 0);
}

TEST(SuctionTipOfTheFrame, IsDrawnAndFollowsItsHand) {
  Stage stage({160, 128}, render::kQualityLadder[0], Passes::kTwo);
  stage.renderer->update(0, tooth_mesh(0, 0.5e-3));
  render::Frame frame = frame_of(desk(0.03, 0.024, 0.35));
  stage.draw(frame);
  const render::Picture without = stage.eye(0);
  frame.suction = {.X_WS = {dvec3(4e-3, 2e-3, 8e-3), rotation_between({0, 0, 1}, glm::normalize(dvec3(1, 1, 1)))},
                   .opening = 4e-3,
                   .slant = 0.6};
  EXPECT_TRUE(stage.draw(frame).drawn);
  const render::Picture with = stage.eye(0);
  EXPECT_GT(compare(with, without, 8).pixels, 200);
  EXPECT_FALSE(stage.draw(frame).drawn);
  frame.suction.X_WS.p.x += 1e-3;
  EXPECT_TRUE(stage.draw(frame).drawn);
  frame.suction.X_WS.p.x -= 1e-3;
  stage.draw(frame);
  EXPECT_EQ(compare(stage.eye(0), with, 0).pixels, 0) << "it left no trace where it was";
  frame.suction = {};
  stage.draw(frame);
  EXPECT_EQ(compare(stage.eye(0), without, 0).pixels, 0);
  EXPECT_EQ(stage.device.validation_messages(), 0);
}

}  // namespace
}  // namespace typodont::test
