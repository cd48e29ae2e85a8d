// Tests the view of temperature: a session's cells of heat, as the picture shows them.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "engine/app/picture/picture_stage.h"
#include "engine/app/picture/teaching_views.h"
#include "engine/app/picture/temperature_picture.h"
#include "engine/app/picture/tissue_view.h"
#include "engine/app/recording/resume.h"
#include "engine/base/units.h"
#include "engine/render/shared.h"
#include "tests/support/color_vision.h"

namespace typodont {
namespace {

using namespace literals;

constexpr glm::ivec2 kPicture{320, 320};
constexpr double kRate = 1000;  // Hz

/// Colour of a temperature (°C) on the face of the section, sRGB 0..1, as shaders/temperature.glsl computes it.
glm::vec3 temperature_color(double celsius) {
  namespace shared = render::shared;
  const double warming = celsius - shared::kBody;
  const double half = (warming < 0 ? shared::kBody - shared::kColdest : shared::kHottest - shared::kBody) / 2;
  const auto s = static_cast<float>(std::min(std::abs(warming) / half, 2.0));
  const glm::vec3 middle = warming < 0 ? shared::kColdColor : shared::kWarmColor,
                  end = warming < 0 ? shared::kColdestColor : shared::kHottestColor;
  return s < 1 ? glm::mix(shared::kBodyColor, middle, s) : glm::mix(middle, end, s - 1);
}

Scene scene_of(const char* heat) {
  return parse_scene(Json::parse(fmt::format(R"({{"tissue": {{"voxel_mm": 0.2, "solids": [
    {{"tissue": "dentin", "solid": {{"box": {{"size_mm": [8, 8, 8], "center_mm": [0, 0, -4]}}}}}},
    {{"tissue": "pulp", "solid": {{"box": {{"size_mm": [2, 2, 2], "center_mm": [0, 0, -5]}}}}}}]}},
    "tool": {{"shape": "sphere", "diameter_mm": 1.4}}, "spindle": "air_turbine", "spray": {{"flow_ml_per_min": 30}},
    "parts": ["haptics", "render", "debris"]{}}})",
                                             heat),
                                 "scene.json"),
                     "scene.json");
}

struct TemperatureView : testing::Test {
  Scene scene = scene_of(R"(, "heat": {})");
  haptics::TissueVolume tissue = load_tissue(scene);
  World world{scene};
  PictureStage stage{rig_of({.elevation = 0.1, .distance = 0.06}, {0, 0, -4.0_mm}, kPicture),
                     scene.servo,
                     {.validation = true, .embedded = true, .hud = false}};
  int layer = 0;  // y of the cells in the plane of the section
  std::uint64_t ticks = 0;

  TemperatureView() {
    world.add_debris(tissue);
    world.add_heat(tissue, kRate);
    const session::HeatGrid& grid = world.heat()->grid();
    layer = grid.size().y / 2;
    const glm::dvec4 plane{0, 1, 0, -grid.frame().to_world(dvec3(0, layer, 0)).y};
    TissueView view;
    stage.show(view.update(tissue), tissue.frame().origin);
    for (const ViewBody& body : view_bodies(render::View::kTemperature, plane, 0, tissue))
      stage.show_inside(body.mesh, body.bricks, tissue.frame().origin);
    stage.show_as(render::View::kTemperature, plane);
  }
  /// A ball turns in a pit of 0.5 mm in the middle of the top. `power`: W.
  void cut(double seconds, double power, bool sprays) {
    world.apply(WaterSwitch{0, sprays, false});
    for (const std::uint64_t end = ticks + static_cast<std::uint64_t>(seconds * kRate); ticks < end; ++ticks) {
      ServoTick tick;
      tick.index = ticks;
      tick.t = from_seconds(static_cast<double>(ticks) / kRate);
      tick.X_WG.p = {0, 0, 0.2_mm};
      tick.n_C_W = {0, 0, 1};
      tick.spindle = 1000;
      tick.cutting_power = power;
      world.apply(tick);
    }
  }
  render::FrameStats draw() { return stage.draw(world, {.tool = false, .debris = false}); }
  glm::dvec2 pixel_of(const dvec3& p_W) const {
    const display::EyeView eye = display::eye_views(stage.rig())[0];
    const glm::dvec4 clip = eye.projection * eye.view * glm::dvec4(p_W, 1);
    return (0.5 + 0.5 * glm::dvec2(clip) / clip.w) * glm::dvec2(kPicture);
  }
  /// The temperature (°C) whose colour the picture has at a point; fails if the scale does not contain the colour.
  double shown(const render::Picture& picture, const dvec3& p_W) {
    const glm::dvec2 at = pixel_of(p_W);
    const std::uint8_t* const c = picture.at(static_cast<int>(at.x), static_cast<int>(at.y));
    double best = 1e9, temperature = 0;
    for (double t = 10; t <= 60; t += 0.05) {
      const double away = glm::length(255.0f * temperature_color(t) - glm::vec3(c[0], c[1], c[2]));
      if (away < best) best = away, temperature = t;
    }
    EXPECT_LT(best, 4) << p_W.x << " " << p_W.z << ": " << int{c[0]} << " " << int{c[1]} << " " << int{c[2]};
    return temperature;
  }
  /// Compares the picture with all dentin cells in the section. Returns the temperature of the cell below the pit.
  double compare() {
    draw();
    const render::Picture picture = stage.eye(0);
    const session::HeatGrid& grid = world.heat()->grid();
    const auto tissue_at = [&](int x, int z) { return grid.tissue(grid.at(x, layer, z)); };
    EXPECT_GT(glm::distance(pixel_of({0, 0, -4.0_mm}), pixel_of({grid.frame().voxel, 0, -4.0_mm})),
              7.1);  // pixels a cell
    int cells = 0, beside_air = 0;
    double floor = 0, warmest = 0;
    for (int x = 1; x + 1 < grid.size().x; ++x)
      for (int z = 1; z + 1 < grid.size().z; ++z) {
        const double temperature = grid.temperature(grid.at(x, layer, z));
        bool near_pulp = false;
        double steepest = 0;  // K, largest difference from a cell around
        for (int i = 0; i < 9; ++i) {
          const int near_x = x - 1 + i / 3, near_z = z - 1 + i % 3;
          near_pulp |= tissue_at(near_x, near_z) == Tissue::kPulp;
          if (tissue_at(near_x, near_z) != Tissue::kAir)
            steepest = std::max(steepest, std::abs(grid.temperature(grid.at(near_x, layer, near_z)) - temperature));
        }
        if (tissue_at(x, z) != Tissue::kDentin || near_pulp) continue;
        const dvec3 p_W = grid.frame().to_world(dvec3(x, layer, z));
        // The middle of a pixel is up to a tenth of a cell from the cell's centre.
        EXPECT_NEAR(shown(picture, p_W), std::clamp(temperature, 10.0, 60.0), 0.3 + 0.1 * steepest) << x << " " << z;
        ++cells;
        if (std::abs(p_W.x) < 0.3_mm && std::abs(temperature - 37) > std::abs(warmest)) {
          warmest = temperature - 37;
          floor = shown(picture, p_W);
        }
        if (tissue_at(x, z + 1) == Tissue::kAir && std::abs(p_W.x) > 2.0_mm) {
          EXPECT_NEAR(shown(picture, p_W + dvec3(0, 0, 0.2_mm)), temperature, 1) << "air does not bleed in";
          ++beside_air;
        }
      }
    EXPECT_GT(cells, 200);
    EXPECT_GT(beside_air, 5);
    EXPECT_NEAR(shown(picture, {3.0_mm, grid.frame().to_world(dvec3(0, layer, 0)).y, -7.2_mm}), 37, 0.5) << "far away";
    return floor;
  }
};

TEST_F(TemperatureView, ADryCutIsWarmAtTheFloorSprayCoolsItAndFarTissueIsNeutral) {
  draw();
  cut(5, 10, false);
  EXPECT_GT(compare(), 40);
  cut(5, 0.2, true);
  EXPECT_LT(compare(), 36);
  EXPECT_EQ(stage.validation_messages(), 0);
}

TEST_F(TemperatureView, OnlyThisViewUploadsTemperaturesAndOnlyAfterTheyChanged) {
  cut(0.1, 1, false);
  EXPECT_GT(draw().temperature_bytes, 0u);
  EXPECT_FALSE(draw().drawn);
  for (const render::View view : {render::View::kLook, render::View::kSection, render::View::kXray}) {
    stage.show_as(view, {0, 1, 0, 0});
    cut(0.1, 1, false);
    EXPECT_EQ(draw().temperature_bytes, 0u);
  }
}

TEST(Temperatures, ThePictureMarksTheTemperaturesThatHarm) {
  EXPECT_EQ(render::shared::kBody, HeatMeter::kBody);
  EXPECT_EQ(render::shared::kPulpHarm, HeatMeter::kPulpHarm);
  EXPECT_EQ(render::shared::kBody + render::shared::kBoneHarm, HeatMeter::kBoneHarm);
}

TEST(Temperatures, ColdNeutralAndWarmStayApartInEveryColourBlindnessAndLightnessFallsToBothSides) {
  const auto scale = [](double celsius) { return glm::dvec3(255.0f * temperature_color(celsius)); };
  const auto lightness = [](const glm::dvec3& c) { return glm::dot(c, glm::dvec3(0.2126, 0.7152, 0.0722)); };
  for (double away = 0; away < 23; ++away) {
    EXPECT_LT(lightness(scale(37 + away + 1)), lightness(scale(37 + away)));
    EXPECT_LT(lightness(scale(37 - away - 1)), lightness(scale(37 - away)));
  }
  for (const test::Vision vision : test::kVisions) {
    for (double away = 3; away <= 23; away += 2) {
      EXPECT_GT(test::difference(vision, scale(37 + away), scale(37 - away)), 7) << away;
      EXPECT_GT(test::difference(vision, scale(37 + away), scale(37)), 2) << away;
      EXPECT_GT(test::difference(vision, scale(37 - away), scale(37)), 2) << away;
    }
  }
}

TEST(Temperatures, ASceneWithoutHeatHasNone) {
  const Scene scene = scene_of("");
  World world(scene);
  world.add_heat(load_tissue(scene), kRate);
  EXPECT_EQ(world.heat(), nullptr);
}

}  // namespace
}  // namespace typodont
