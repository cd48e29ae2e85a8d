// Tests light between bodies: against analytic cases, and its use in the picture.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

#include "engine/gpu/device.h"
#include "engine/render/light_passes.h"
#include "engine/render/light_scene.h"
#include "engine/render/look.h"
#include "engine/render/shared.h"
#include "engine/render/srgb.h"
#include "tests/support/default_colors.h"
#include "tests/support/lit_box.h"
#include "tests/support/stage.h"
#include "tests/support/tooth_mesh.h"

namespace typodont::test {
namespace {

// These tests cast the rays themselves: no file can be created in this folder.
[[maybe_unused]] const int g_no_cache = setenv("TYPODONT_CACHE", "/proc/self", 1);

using render::LightScene;
using render::LightSources;
using render::LitTriangle;

LightSources room_of(const glm::vec3& radiance) {
  LightSources sources;
  sources.room = [radiance](const glm::vec3&) { return radiance; };
  return sources;
}
LightSources lamp_at(const glm::vec3& toward) {
  LightSources sources = room_of(glm::vec3(0));
  sources.toward_lamp = glm::normalize(toward);
  sources.lamp = glm::vec3(1);
  return sources;
}
const glm::vec3 kUp(0, 0, 1);

TEST(LightScene, WhiteBodiesInAUniformRoomAreAsBrightAsTheRoomAlsoInTheGapBetweenThem) {
  std::vector<LitTriangle> all;
  add_box(all, {0, 0, 0}, {6e-3f, 8e-3f, 5e-3f}, glm::vec3(1));
  add_box(all, {8e-3f, 0, 0}, {14e-3f, 8e-3f, 5e-3f}, glm::vec3(1));
  const LightScene scene(all, {dvec3(-2e-3), dvec3(16e-3, 10e-3, 7e-3)}, 1e-3);
  const glm::vec3 room(0.7f, 0.5f, 0.3f);
  const render::LightGrid grid = scene.light(room_of(room), 40);
  const auto shines = [&](const dvec3& p, const glm::vec3& n) {
    const glm::vec4 light = render::light_at(grid, p, n);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(light[c], room[c], 0.04 * room[c]) << p.x << " " << p.z;
  };
  shines({3e-3, 4e-3, 5e-3}, kUp);
  shines({6e-3, 4e-3, 4e-3}, {1, 0, 0});
  shines({6e-3, 4e-3, 2.5e-3}, {1, 0, 0});
  // Now the bodies are black and hide the room from each other. So the gap between them must be darker.
  for (LitTriangle& t : all) t.color = glm::vec3(0);
  const LightScene dark(all, {dvec3(-2e-3), dvec3(16e-3, 10e-3, 7e-3)}, 1e-3);
  EXPECT_LT(render::light_at(dark.light(room_of(room)), {6e-3, 4e-3, 2.5e-3}, {1, 0, 0}).x, 0.6f * room.x);
}

TEST(LightScene, ALitDiscGivesTheLightOfItsFormFactor) {
  constexpr float kRadius = 10e-3f, kHeight = 10e-3f, kAlbedo = 0.6f;
  constexpr int kParts = 64;
  std::vector<LitTriangle> all;
  for (int i = 0; i < kParts; ++i) {
    const auto rim = [&](int k) {
      const double a = 2 * kPi * k / kParts;
      return glm::vec3(kRadius * std::cos(a), kRadius * std::sin(a), 0);
    };
    all.push_back({{glm::vec3(0), rim(i), rim(i + 1)}, glm::vec3(kAlbedo)});
  }
  // Adds a small black triangle that faces the disc, because the grid has samples only near surfaces.
  const float s = 0.05e-3f;
  all.push_back({{glm::vec3(0, 0, kHeight), {0, s, kHeight}, {s, 0, kHeight}}, glm::vec3(0)});
  all.back().metal = true;  // its samples have mirrored light
  const LightScene scene(all, {dvec3(-2e-3), dvec3(2e-3, 2e-3, 12e-3)}, 0.5e-3);
  const render::LightGrid grid = scene.light(lamp_at(kUp), 1);
  const double height = kHeight - 0.25e-3;  // the samples are read half a cell in front
  const double expected = kAlbedo * kRadius * kRadius / (kRadius * kRadius + height * height);
  EXPECT_NEAR(render::light_at(grid, {0, 0, kHeight}, -kUp).x, expected, 0.05 * expected);
  // Mirrored light is the mean over a narrow lobe, which the disc fills.
  EXPECT_NEAR(render::mirrored_at(grid, {0, 0, kHeight}, -kUp, -kUp).x, kAlbedo, 0.02f * kAlbedo);
}

/// Returns the fraction of unpolarised light that the boundary between two refractive indices reflects at an angle of
/// incidence with this cosine.
double fresnel(double outside, double inside, double cosine) {
  const double sine = outside / inside * std::sqrt(1 - cosine * cosine), inner = std::sqrt(1 - sine * sine);
  const double across = (outside * cosine - inside * inner) / (outside * cosine + inside * inner);
  const double along = (inside * cosine - outside * inner) / (inside * cosine + outside * inner);
  return 0.5 * (across * across + along * along);
}

TEST(Looks, TheSurfaceOfEveryTissueReflectsWhatFresnelsEquationsSay) {
  for (const render::Look& look : render::appearances_of(render::default_colors())) {
    if (look.metal > 0.5) {
      EXPECT_EQ(render::dry_reflectance(look), 1);
      EXPECT_EQ(render::hemispherical_reflectance(look), 0);
      continue;
    }
    EXPECT_NEAR(render::dry_reflectance(look), fresnel(1, look.index, 1), 1e-12);
    const double water = fresnel(1, 1.33, 1), below = fresnel(1.33, look.index, 1);
    const double wet = water + (1 - water) * (1 - water) * below;
    const double normal = glm::mix(fresnel(1, look.index, 1), wet, look.wetness);
    const double index = (1 + std::sqrt(normal)) / (1 - std::sqrt(normal));
    double mean = 0;
    constexpr int kSteps = 2000;
    for (int i = 0; i < kSteps; ++i) mean += fresnel(1, index, std::sqrt((i + 0.5) / kSteps)) / kSteps;
    EXPECT_NEAR(render::hemispherical_reflectance(look), mean, 0.004) << look.index;
  }
}

/// Returns the light of a lamp at 45 degrees on a floor, and on a red wall at its edge that faces +x.
render::LightGrid wall_and_floor(bool metal) {
  constexpr float kLong = 0.4f;
  std::vector<LitTriangle> all;
  add_plate(all, {0, -kLong, 0}, {0, kLong, 0}, {0, kLong, kLong}, {0, -kLong, kLong}, {0.8f, 0, 0});
  const std::size_t wall = all.size();
  add_plate(all, {0, -kLong, 0}, {kLong, -kLong, 0}, {kLong, kLong, 0}, {0, kLong, 0}, glm::vec3(0));
  for (std::size_t i = wall; i < all.size(); ++i) all[i].metal = metal;
  return LightScene(all, {dvec3(-1e-3), dvec3(8e-3, 8e-3, 8e-3)}, 1e-3).light(lamp_at({1, 0, 1}), 3);
}

TEST(LightScene, ARedWallColoursHalfOfTheLightOnABlackFloorBesideIt) {
  const render::LightGrid grid = wall_and_floor(false);
  const glm::vec4 light = render::light_at(grid, {2e-3, 4e-3, 0}, kUp);
  const double expected = 0.5 * 0.8 * std::sqrt(0.5);
  EXPECT_NEAR(light.x, expected, 0.06 * expected);
  EXPECT_EQ(light.y, 0);
  EXPECT_EQ(light.w, 1) << "the lamp is seen";
}

TEST(LightScene, MetalMirrorsAWallUpToItsEdge) {
  const render::LightGrid grid = wall_and_floor(true);
  const auto mirrored = [&](float angle) {  // rad, from the vertical towards the wall
    return render::mirrored_at(grid, {4e-3, 4e-3, 0}, kUp, {-std::sin(angle), 0, std::cos(angle)}).x;
  };
  const float expected = 0.8f * std::sqrt(0.5f);
  EXPECT_NEAR(mirrored(1.2f), expected, 0.03f * expected);
  EXPECT_NEAR(mirrored(0.6f), expected, 0.03f * expected);
  EXPECT_NEAR(mirrored(0), 0.5f * expected, 0.15f * expected);
  EXPECT_NEAR(mirrored(-0.6f), 0, 0.03f * expected);
}

TEST(LightScene, ImagesAreContinuousInAllDirections) {
  render::LightGrid grid{.origin = dvec3(0), .spacing = 1, .size = glm::ivec3(2), .faces = {}, .images = {}};
  constexpr int kSide = render::LightGrid::kImageSide;
  grid.images.resize(grid.samples() * kSide * kSide);
  for (int x = 0; x < kSide; ++x)
    for (int y = 0; y < kSide; ++y)
      for (int i = 0; i < 8; ++i)
        grid.images[grid.image_index({x, y}, {i & 1, (i >> 1) & 1, i >> 2})] = render::image_direction({x, y});
  for (int i = 0; i < 2000; ++i) {
    const float z = 1 - (2 * static_cast<float>(i) + 1) / 2000, a = 2.4f * static_cast<float>(i);
    const glm::vec3 r(std::sqrt(1 - z * z) * std::cos(a), std::sqrt(1 - z * z) * std::sin(a), z);
    EXPECT_LT(glm::length(render::mirrored_at(grid, dvec3(0.3, 0.6, 0.5), kUp, r) - r), 0.06f) << r.x << " " << r.z;
  }
}

TEST(LightScene, TheLampIsNotSeenUnderARoof) {
  std::vector<LitTriangle> all;
  add_box(all, {-20e-3f, -20e-3f, -2e-3f}, {20e-3f, 20e-3f, 0}, glm::vec3(0.5f));
  add_box(all, {-6e-3f, -6e-3f, 4e-3f}, {6e-3f, 6e-3f, 5e-3f}, glm::vec3(0.5f));
  const LightScene scene(all, {dvec3(-12e-3), dvec3(12e-3)}, 1e-3);
  LightSources sources = lamp_at(kUp);
  sources.lamp_half_angle = 0.1f;
  const render::LightGrid grid = scene.light(sources);
  EXPECT_EQ(render::light_at(grid, {0, 0, 0}, kUp).w, 0);
  EXPECT_EQ(render::light_at(grid, {10e-3, 0, 0}, kUp).w, 1);
}

/// Returns the light of a lamp and a room on a body under a roof. Without `passes`, the CPU casts the rays.
render::LightGrid body_under_roof(std::shared_ptr<render::LightPasses> passes) {
  std::vector<LitTriangle> all;
  add_box(all, {-8e-3f, -8e-3f, -4e-3f}, {8e-3f, 8e-3f, 0}, {0.6f, 0.5f, 0.4f});
  add_box(all, {-6e-3f, -6e-3f, 4e-3f}, {2e-3f, 6e-3f, 5e-3f}, glm::vec3(0.7f));
  add_box(all, {3e-3f, -2e-3f, 0.3e-3f}, {5e-3f, 2e-3f, 6e-3f}, {0.7f, 0.2f, 0.2f});
  all.back().metal = true;
  LightSources sources = lamp_at({0.2f, 0.3f, 1});
  sources.lamp_half_angle = 0.1f;
  sources.room = [](const glm::vec3& d) { return glm::vec3(0.4f + 0.2f * d.z, 0.4f, 0.4f - 0.2f * d.x); };
  const render::BoxInWorld box{dvec3(-10e-3), dvec3(10e-3)};
  return LightScene(all, box, 2e-3, true, {}, std::move(passes)).light(sources);
}

TEST(LightScene, ComputePassesGiveTheLightThatTheProcessorComputes) {
  const render::LightGrid expected = body_under_roof(nullptr);
  const auto passes = std::make_shared<render::LightPasses>(gpu::Device::create({}));
  const render::LightGrid grid = body_under_roof(passes);
  // Rays that touch an edge may meet the triangle at either side.
  const auto compare = [](const auto& a, const auto& b) {
    ASSERT_EQ(a.size(), b.size());
    double sum = 0;
    float most = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
      for (int c = 0; c < a[i].length(); ++c) {
        const float apart = std::abs(a[i][c] - b[i][c]);
        sum += double{apart}, most = std::max(most, apart);
      }
    EXPECT_LT(sum / static_cast<double>(a.size()), 1e-5);
    EXPECT_LT(most, 0.02f);
  };
  compare(grid.faces, expected.faces);
  compare(grid.images, expected.images);
}

TEST(LightScene, TheProcessorContinuesIfTheDeviceOfThePassesIsLost) {
  gpu::Device device = gpu::Device::create({});
  device.lose();
  const render::LightGrid grid = body_under_roof(std::make_shared<render::LightPasses>(std::move(device)));
  const render::LightGrid expected = body_under_roof(nullptr);
  EXPECT_EQ(grid.faces, expected.faces);
  EXPECT_EQ(grid.images, expected.images);
}

TEST(LightScene, ASurfaceHasTheSameLightWhereverItLiesBetweenTheSamples) {
  for (const float offset : {0.0f, 0.1e-3f, 0.35e-3f, 0.5e-3f, 0.8e-3f}) {
    std::vector<LitTriangle> all;
    add_box(all, {-8e-3f, -8e-3f, -4e-3f}, {8e-3f, 8e-3f, offset}, glm::vec3(0.6f));
    const LightScene scene(all, {dvec3(-10e-3), dvec3(10e-3)}, 1e-3);
    const render::LightGrid grid = scene.light(room_of(glm::vec3(0.4f)));
    for (const glm::vec3& n : {kUp, glm::normalize(glm::vec3(0.3f, -0.2f, 0.9f))})
      EXPECT_NEAR(render::light_at(grid, {1.3e-3, 0.4e-3, offset}, n).x, 0.4, 0.05) << offset;
    EXPECT_EQ(grid.faces, LightScene(all, {dvec3(-10e-3), dvec3(10e-3)}, 1e-3).light(room_of(glm::vec3(0.4f))).faces);
  }
}

TEST(LightOfTheFrame, AGridOfRedLightColoursTheTissueAtEveryQualityAndLeavesNoTraceWhenItIsGone) {
  for (const std::size_t step : {std::size_t{0}, std::size_t{2}, std::size(render::kQualityLadder) - 1}) {
    const render::Quality& quality = render::kQualityLadder[step];
    Stage stage({160, 128}, quality);
    stage.renderer->update(0, tooth_mesh(0, 0.5e-3));
    const render::Frame frame = frame_of(desk(0.03, 0.024, 0.35));
    stage.draw(frame);
    const render::Picture plain = stage.eye(0);
    render::LightGrid red{.origin = dvec3(-10e-3), .spacing = 5e-3, .size = glm::ivec3(5), .faces = {}, .images = {}};
    red.faces.assign(render::LightGrid::kFaces * red.samples(), glm::vec4(0.9f, 0.1f, 0.1f, 1));
    constexpr int kSide = render::LightGrid::kImageSide;
    red.images.assign(red.samples() * kSide * kSide, glm::vec3(0.9f, 0.1f, 0.1f));
    render::TissueLightGrid inside{.origin = dvec3(-10e-3), .spacing = 5e-3, .size = glm::ivec3(5), .values = {}};
    inside.values.assign(red.samples(), glm::vec4(0.9f, 0.1f, 0.1f, 0));
    stage.renderer->set_light(red, inside);
    stage.draw(frame);
    const render::Picture coloured = stage.eye(0);
    int redder = 0, bluer = 0;
    for (int y = 0; y < plain.size.y; ++y)
      for (int x = 0; x < plain.size.x; ++x) {
        const std::uint8_t *a = plain.at(x, y), *b = coloured.at(x, y);
        const int change = (b[0] - b[2]) - (a[0] - a[2]);
        redder += change > 10;
        bluer += change < -10;
      }
    EXPECT_GT(redder, plain.size.x * plain.size.y / 20) << quality.name;
    EXPECT_EQ(bluer, 0) << quality.name;
    EXPECT_FALSE(stage.draw(frame).drawn) << "nothing has changed";
    stage.renderer->set_light({}, {});
    stage.draw(frame);
    EXPECT_EQ(compare(stage.eye(0), plain, 0).pixels, 0) << quality.name;
    EXPECT_EQ(stage.device.validation_messages(), 0) << quality.name;
  }
}

TEST(HighlightOfTheLamp, HasTheSizeOfTheLampsMirrorImageOnASmoothBall) {
  // The best quality level draws fine structures of enamel, which make the highlight uneven.
  for (const std::size_t step : {std::size_t{1}, std::size_t{2}}) {
    const render::Quality& quality = render::kQualityLadder[step];
    constexpr float kRadius = 4e-3f;
    constexpr double kWidth = 6e-3;
    constexpr int kPixels = 320;
    Stage stage({kPixels, kPixels}, quality);
    render::Frame frame = frame_of(desk(kWidth, kWidth, 0.35));
    frame.lights.ambient = 0;
    frame.lights.key_strength = 0.4;  // the highlight stays darker than white
    const dvec3 lamp = glm::normalize(frame.lights.key), eye = glm::normalize(frame.eyes[0].position);
    const dvec3 half_way = glm::normalize(lamp + eye);
    const std::array<render::MeshUpdate, 1> enamel{
        ball(0, -kRadius * glm::vec3(half_way), kRadius, Tissue::kEnamel, 400)};
    stage.renderer->update(0, enamel);
    stage.draw(frame);
    const render::Picture picture = stage.eye(0);
    const auto light = [&](int x, int y) { return render::linear_light(dvec3(picture.at(x, y)[1] / 255.0)).x; };
    const double middle = light(kPixels / 2, kPixels / 2), beside = light(kPixels / 2, kPixels / 5);
    int bright = 0;
    for (int y = 0; y < kPixels; ++y)
      for (int x = 0; x < kPixels; ++x) bright += light(x, y) > 0.5 * (middle + beside);
    // The ball mirrors the lamp's disc where the angle between its normal and the half-way direction is less than this.
    const double angle = render::shared::kLampHalfAngle / (2 * std::sqrt(glm::dot(lamp, half_way)));
    const double area = std::numbers::pi * std::pow(double{kRadius} * std::sin(angle), 2) * glm::dot(half_way, eye);
    EXPECT_GT(middle, 1.5 * beside) << quality.name;
    EXPECT_NEAR(bright * std::pow(kWidth / kPixels, 2), area, 0.12 * area) << quality.name;
  }
}

TEST(ShadowOfTheFrame, IsWholeAfterAChangeOfTheQuality) {
  const render::Quality &high = render::kQualityLadder[0], &low = render::kQualityLadder[2];
  const render::Frame frame = frame_of(desk(0.03, 0.024, 0.35));
  const auto drawn = [&](const render::Quality& quality, std::span<const render::Quality> changes) {
    Stage stage({160, 128}, quality);
    stage.renderer->update(0, tooth_mesh(0, 0.5e-3));
    const std::array<render::MeshUpdate, 1> above{ball(0, {-4e-3f, 2e-3f, 10e-3f}, 2e-3f, Tissue::kEnamel)};
    stage.renderer->update(1, above);  // shades the tooth
    stage.draw(frame);
    for (const render::Quality& change : changes) {
      stage.renderer->set_quality(change);
      stage.draw(frame);
    }
    return stage.eye(0);
  };
  const render::Picture fresh = drawn(low, {});
  const std::array<render::Quality, 2> down_and_up{high, low};
  EXPECT_EQ(compare(drawn(low, down_and_up), fresh, 0).pixels, 0);
  EXPECT_EQ(compare(drawn(high, {&low, 1}), fresh, 0).pixels, 0);
  render::Quality unshaded = low;
  unshaded.shadow_map = 0;
  EXPECT_GT(compare(drawn(unshaded, {}), fresh, 10).pixels, 200) << "the scene has a shadow";
}

}  // namespace
}  // namespace typodont::test
