// Tests the appearance of cut tissue on a flat plate: the sheen of dentin's tubules, and water on cut enamel.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/support/stage.h"

namespace typodont::test {
namespace {

/// Returns a square plate in the plane y = 0 that faces −y. Its middle is the origin, and the tooth's axis z lies in
/// it.
std::vector<render::MeshUpdate> plate(Tissue tissue, float cut) {
  constexpr int kSteps = 40;
  constexpr float kSide = 20e-3f;  // m
  render::MeshUpdate brick;
  for (int i = 0; i <= kSteps; ++i)
    for (int j = 0; j <= kSteps; ++j) {
      render::Vertex v;
      v.p = {kSide * (static_cast<float>(i) / kSteps - 0.5f), 0, kSide * (static_cast<float>(j) / kSteps - 0.5f)};
      v.n = {0, -1, 0};
      v.tissue = {tissue, tissue};
      v.cut = cut;
      brick.vertices.push_back(v);
    }
  const auto at = [](int i, int j) { return static_cast<std::uint32_t>(i * (kSteps + 1) + j); };
  for (int i = 0; i < kSteps; ++i)
    for (int j = 0; j < kSteps; ++j)
      for (const std::uint32_t index :
           {at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j), at(i + 1, j + 1), at(i, j + 1)})
        brick.indices.push_back(index);
  return {brick};
}

/// Returns the mean of the green channel over the middle of the picture.
double brightness(const render::Picture& picture) {
  double sum = 0;
  int count = 0;
  for (int y = picture.size.y / 4; y < 3 * picture.size.y / 4; ++y)
    for (int x = picture.size.x / 4; x < 3 * picture.size.x / 4; ++x, ++count) sum += picture.at(x, y)[1];
  return sum / count;
}

/// Returns a view along the normal of the plate, without light from the room.
render::Frame front_view() {
  render::Frame frame = frame_of(desk(12e-3, 9e-3, 0.35, {0, -1, 0}));
  frame.lights.ambient = 0;
  return frame;
}

/// Returns how much brighter the plate is when the lamp is beside it, across the tooth's axis, than when the lamp is
/// above or below it, along the axis. All lamps have the same angle to the normal. The eye is beside the normal, so the
/// mean of two opposite lamps is taken.
double across_over_along(Stage& stage) {
  render::Frame frame = front_view();
  const auto lit_by = [&](const dvec3& lamp) {
    frame.lights.key = glm::normalize(lamp);
    stage.draw(frame);
    return brightness(stage.eye(0));
  };
  return (lit_by({1, -1, 0}) + lit_by({-1, -1, 0})) / (lit_by({0, -1, 1}) + lit_by({0, -1, -1}));
}

TEST(CutDentin, ShinesAcrossItsTubulesWhereLightIsComputedPerPixel) {
  for (const std::size_t step : {std::size_t{0}, std::size_t{1}}) {
    const render::Quality& quality = render::kQualityLadder[step];
    Stage stage({200, 150}, quality);
    stage.renderer->update(0, plate(Tissue::kDentin, 0));
    EXPECT_NEAR(across_over_along(stage), 1, 0.01) << quality.name << ": a root has no sheen";
    stage.renderer->update(0, plate(Tissue::kDentin, 1));
    if (quality.light_per_vertex)
      EXPECT_NEAR(across_over_along(stage), 1, 0.01) << quality.name;
    else
      EXPECT_GT(across_over_along(stage), 1.03) << quality.name;
    EXPECT_EQ(stage.device.validation_messages(), 0) << quality.name;
  }
}

TEST(CutEnamel, LosesItsFrostBelowWater) {
  for (const std::size_t step : {std::size_t{0}, std::size_t{2}}) {
    const render::Quality& quality = render::kQualityLadder[step];
    // Returns how much bluer than red the plate is, relative to its red; frost is whiter than enamel.
    const auto blue = [&](float cut, bool wet) {
      Stage stage({200, 150}, quality);
      stage.renderer->update(0, plate(Tissue::kEnamel, cut));
      if (wet) {
        const render::FilmGrid grid{.origin = dvec3(-20e-3), .spacing = 5e-3, .size = glm::ivec3(9)};
        stage.renderer->set_film(grid);
        const std::vector<render::FilmTexel> water(9 * 9 * 9, {.water = 150, .cover = 0, .colour = 0, .blood = 0});
        const render::CellBox all{glm::ivec3(0), glm::ivec3(8)};
        stage.renderer->update_film(water, {&all, 1});
      }
      render::Frame frame = front_view();
      frame.lights.key = glm::normalize(dvec3(1, -1, 0));
      stage.draw(frame);
      const render::Picture picture = stage.eye(0);
      const std::uint8_t* pixel = picture.at(picture.size.x / 2, picture.size.y / 2);
      return static_cast<double>(pixel[2]) / pixel[0];
    };
    const double dry = blue(1, false) - blue(0, false), wet = blue(1, true) - blue(0, true);
    EXPECT_GT(dry, 0.02) << quality.name << ": cut enamel is whiter than natural enamel";
    EXPECT_LT(std::abs(wet), 0.3 * dry) << quality.name;
  }
}

}  // namespace
}  // namespace typodont::test
