// Tests the mouth mirror: the formulas, where a reflected point appears on the screen, and what is drawn while the
// mirror is not visible.
#include <gtest/gtest.h>

#include <random>

#include "engine/render/mirror.h"
#include "tests/support/stage.h"
#include "tests/support/tooth_mesh.h"

namespace typodont::test {
namespace {

constexpr glm::ivec2 kSize{320, 256};

dquat any_rotation(std::mt19937& random) {
  std::normal_distribution<double> normal;
  const dquat q(normal(random), normal(random), normal(random), normal(random));
  return glm::normalize(q);
}
glm::dvec2 pixel(const render::Eye& eye, const dvec3& p) {
  const glm::dvec4 c = eye.projection * eye.view * glm::dvec4(p, 1);
  return (glm::dvec2(c) / c.w * 0.5 + 0.5) * glm::dvec2(kSize);
}
/// A mirror of 16 mm behind the workspace that faces the eyes of desk() obliquely, and a point in front of it. The
/// point and its reflection are well separated in the picture.
MouthMirror turned_to_the_eyes() {
  return {{dvec3(0, 0, -3e-3), rotation_between({0, 0, 1}, glm::normalize(dvec3(0.4, -0.6, 0.8)))}, 16e-3, 0};
}
const dvec3 kBefore = dvec3(0, 0, -3e-3) + 6e-3 * glm::normalize(dvec3(0.4, -0.6, 0.8));

TEST(Mirror, ReflectionIsItsOwnInverseAndThatOfTheDisplay) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-0.1, 0.1);
  for (int i = 0; i < 200; ++i) {
    const Pose X_WM{dvec3(place(random), place(random), place(random)), any_rotation(random)};
    const dvec3 p(place(random), place(random), place(random));
    const glm::dmat4 m = render::reflection_in(X_WM);
    const dvec3 q(m * glm::dvec4(p, 1));
    const dvec3 n = X_WM.rotate({0, 0, 1});
    EXPECT_LT(glm::length(dvec3(m * glm::dvec4(q, 1)) - p), 1e-9);
    EXPECT_LT(glm::length(q - display::reflect({n, glm::dot(n, X_WM.p)}, p)), 1e-9);
    EXPECT_NEAR(glm::determinant(m), -1, 1e-9);
  }
}

TEST(Mirror, TheReflectedEyeSeesAPointWhereTheEyeSeesItsReflection) {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> place(-0.01, 0.01);
  const render::Frame frame = frame_of(desk(0.03, 0.024, 0.35));
  for (int i = 0; i < 200; ++i) {
    const Pose X_WM{dvec3(place(random), place(random), place(random)), any_rotation(random)};
    const dvec3 p(place(random), place(random), place(random));
    const dvec3 behind(render::reflection_in(X_WM) * glm::dvec4(p, 1));
    for (const render::Eye& eye : frame.eyes) {
      const render::Eye other = render::reflected(eye, X_WM);
      const glm::dvec4 a = other.projection * other.view * glm::dvec4(p, 1);
      const glm::dvec4 b = eye.projection * eye.view * glm::dvec4(behind, 1);
      EXPECT_LT(glm::length(a - b), 1e-9);
      EXPECT_NE(other.flip, eye.flip);
      EXPECT_NEAR(glm::length(other.position - p), glm::length(eye.position - behind), 1e-9);
    }
  }
}

TEST(Mirror, OnlyObjectsBeforeTheGlassAreReflected) {
  const MouthMirror mirror = turned_to_the_eyes();
  const dvec3 n = mirror.X_WM.rotate({0, 0, 1});
  EXPECT_GT(glm::dot(render::before_glass(mirror.X_WM), glm::dvec4(mirror.X_WM.p + 1e-6 * n, 1)), 0);
  EXPECT_LT(glm::dot(render::before_glass(mirror.X_WM), glm::dvec4(mirror.X_WM.p - 1e-6 * n, 1)), 0);
}

TEST(Mirror, TheBoxOfTheGlassHoldsAllOfIt) {
  const render::Frame frame = frame_of(desk(0.03, 0.024, 0.35));
  const MouthMirror mirror = turned_to_the_eyes();
  const auto box = render::glass_in(frame.eyes[0], mirror, kSize);
  ASSERT_TRUE(box);
  for (int i = 0; i < 64; ++i) {
    const double a = 0.1 * i;
    const glm::dvec2 p =
        pixel(frame.eyes[0], mirror.X_WM * (0.5 * mirror.diameter * dvec3(std::cos(a), std::sin(a), 0)));
    EXPECT_GE(p.x, box->x);
    EXPECT_GE(p.y, box->y);
    EXPECT_LE(p.x, box->x + box->width);
    EXPECT_LE(p.y, box->y + box->height);
  }
  MouthMirror away = mirror;
  away.X_WM.R = rotation_between({0, 0, 1}, glm::normalize(dvec3(0, 0.6, -0.8)));
  EXPECT_FALSE(render::glass_in(frame.eyes[0], away, kSize));
  away = mirror;
  away.X_WM.p.x += 0.2;
  EXPECT_FALSE(render::glass_in(frame.eyes[0], away, kSize));
}

TEST(Mirror, AKnownPointAppearsInAPlaneAndInAConcaveGlassWhereTheMirroredCameraAndItsMagnificationPutIt) {
  // A small ball in front of the mirror. Its direct picture and its reflection are separated.
  Stage stage(kSize);
  const render::MeshUpdate body = ball(1, glm::vec3(kBefore), 0.45e-3f, Tissue::kGingiva, 24);
  stage.renderer->update(0, std::span(&body, 1));
  render::Frame frame = frame_of(desk(0.03, 0.024, 0.35));
  frame.background = render::Background::kBlack;
  frame.mirror = turned_to_the_eyes();
  for (const double focal : {0.0, 0.1}) {
    frame.mirror.focal = focal;
    const double magnified = focal > 0 ? 1 / (1 - 0.015 / focal) : 1;
    const render::FrameStats stats = stage.draw(frame);
    EXPECT_EQ(stats.mirror_passes, stage.device.multiview ? 1 : 2);
    EXPECT_EQ(stage.device.validation_messages(), 0);
    for (int e = 0; e < 2; ++e) {
      const auto& eye = frame.eyes[static_cast<std::size_t>(e)];
      const glm::dvec2 middle = pixel(eye, frame.mirror.X_WM.p);
      const glm::dvec2 expected =
          middle + magnified * (pixel(render::reflected(eye, frame.mirror.X_WM), kBefore) - middle);
      ASSERT_GT(glm::length(expected - pixel(eye, kBefore)), 30);
      const render::Picture picture = stage.eye(e);
      double x = 0, y = 0, weight = 0;
      for (int j = static_cast<int>(expected.y) - 14; j <= static_cast<int>(expected.y) + 14; ++j)
        for (int i = static_cast<int>(expected.x) - 14; i <= static_cast<int>(expected.x) + 14; ++i) {
          ASSERT_TRUE(i >= 0 && j >= 0 && i < kSize.x && j < kSize.y);
          const auto* c = picture.at(i, j);
          if (c[0] > c[1] + 25) x += i + 0.5, y += j + 0.5, ++weight;  // pink on grey glass
        }
      ASSERT_GT(weight, 30) << "eye " << e;
      EXPECT_NEAR(x / weight, expected.x, 0.7);
      EXPECT_NEAR(y / weight, expected.y, 0.7);
    }
  }
}

TEST(Mirror, WithoutAnEyeThatSeesTheGlassThereIsNoSecondPass) {
  Stage stage({160, 128});
  stage.renderer->update(0, tooth_mesh(0, 0.6e-3));
  render::Frame frame = frame_of(desk(0.03, 0.024, 0.35));
  const render::FrameStats without = stage.draw(frame);
  EXPECT_EQ(without.mirror_passes, 0);
  frame.mirror = turned_to_the_eyes();
  frame.mirror.X_WM.R = rotation_between({0, 0, 1}, glm::normalize(dvec3(0, 0.6, -0.8)));  // its back
  const render::FrameStats back = stage.draw(frame);
  EXPECT_TRUE(back.drawn);
  EXPECT_EQ(back.mirror_passes, 0);
  EXPECT_EQ(back.mirror_bricks, 0);
  EXPECT_EQ(back.passes, without.passes - 1);        // the shadow map was there
  EXPECT_EQ(back.pipelines, without.pipelines + 1);  // its metal, no glass
  frame.mirror.X_WM.R = turned_to_the_eyes().X_WM.R;
  const render::FrameStats front = stage.draw(frame);
  EXPECT_GT(front.mirror_passes, 0);
  EXPECT_GT(front.mirror_bricks, 0);
  EXPECT_EQ(front.passes, back.passes + front.mirror_passes);
  EXPECT_FALSE(stage.draw(frame).drawn);
  frame.mirror.fog = 0.5;
  EXPECT_TRUE(stage.draw(frame).drawn);
  EXPECT_EQ(stage.device.validation_messages(), 0);
}

TEST(Mirror, FogHidesTheReflection) {
  Stage stage(kSize);
  const render::MeshUpdate body = ball(1, glm::vec3(kBefore), 0.45e-3f, Tissue::kGingiva, 24);
  stage.renderer->update(0, std::span(&body, 1));
  render::Frame frame = frame_of(desk(0.03, 0.024, 0.35));
  frame.mirror = turned_to_the_eyes();
  const auto redness = [&](double fog) {
    frame.mirror.fog = fog;
    stage.draw(frame);
    const glm::ivec2 at(pixel(render::reflected(frame.eyes[0], frame.mirror.X_WM), kBefore));
    const render::Picture picture = stage.eye(0);
    const auto* c = picture.at(at.x, at.y);
    return c[0] - c[1];
  };
  const int clear = redness(0), half = redness(0.5), full = redness(1);
  EXPECT_GT(clear, half + 15);
  EXPECT_GE(half, full);
  EXPECT_LT(full, 10);
}

}  // namespace
}  // namespace typodont::test
