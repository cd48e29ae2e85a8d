#include <gtest/gtest.h>

#include <random>

#include "engine/base/units.h"
#include "engine/display/display_rig.h"

namespace typodont::display {
namespace {

/// Generates random rigs of the kind that people build: any position and orientation, with the eyes in front of the
/// panel.
struct Generator {
  std::mt19937_64 engine{20240607};
  double uniform(double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(engine); }
  dvec3 direction() {
    for (;;) {
      const dvec3 v(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1));
      const double l = glm::length(v);
      if (l > 0.1 && l < 1) return v / l;
    }
  }
  struct Case {
    Screen screen;
    dvec3 right, up, normal, middle;
  };
  Case screen() {
    Case c;
    c.normal = direction();
    c.right = glm::normalize(glm::cross(direction(), c.normal));
    c.up = glm::cross(c.normal, c.right);
    const double w = uniform(0.05, 1.2), h = uniform(0.05, 0.8);
    c.screen.lower_left = {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
    c.screen.lower_right = c.screen.lower_left + w * c.right;
    c.screen.upper_left = c.screen.lower_left + h * c.up;
    c.middle = c.screen.lower_left + 0.5 * w * c.right + 0.5 * h * c.up;
    return c;
  }
  dvec3 eye(const Case& c) {
    return c.middle + uniform(0.2, 1.5) * c.normal + uniform(-0.5, 0.5) * c.right + uniform(-0.5, 0.5) * c.up;
  }
};

dvec3 ndc(const EyeView& eye, const dvec3& p) {
  const glm::dvec4 c = eye.projection * eye.view * glm::dvec4(p, 1);
  return dvec3(c) / c.w;
}

TEST(Frusta, PointsOnTheScreenPlaneHaveNoDisparity) {
  Generator g;
  for (int i = 0; i < 500; ++i) {
    const auto c = g.screen();
    const EyeView a = eye_view(c.screen, {}, g.eye(c), {}), b = eye_view(c.screen, {}, g.eye(c), {});
    const dvec3 p = c.middle + g.uniform(-1, 1) * c.right + g.uniform(-1, 1) * c.up;
    EXPECT_NEAR(glm::length(dvec2(ndc(a, p)) - dvec2(ndc(b, p))), 0, 1e-10);
  }
}

TEST(Frusta, ThickGlassKeepsTheRowOfAPointAndMovesItLittle) {
  Generator g;
  for (int i = 0; i < 500; ++i) {
    DisplayRig rig;
    const auto c = g.screen();
    rig.screen = c.screen;
    // An oblique mirror at least 30 cm from the picture. The picture is seen at 10 to 50 degrees to the mirror's
    // normal.
    const dvec3 seen_eye = c.middle + g.uniform(0.35, 0.6) * c.normal + g.uniform(-0.02, 0.02) * c.right;
    const double turn = g.uniform(0, 2 * kPi), tilt = g.uniform(10, 50) * kPi / 180;
    const dvec3 aside = std::cos(turn) * c.right + std::sin(turn) * c.up;
    Mirror mirror{glm::normalize(std::cos(tilt) * c.normal + std::sin(tilt) * aside), 0};
    mirror.offset = glm::dot(mirror.normal, c.middle) + 0.2;
    mirror.glass_thickness = g.uniform(1e-3, 6e-3);
    mirror.glass_index = g.uniform(1.4, 1.7);
    rig.mirror = mirror;
    const Screen behind = reflect(mirror, c.screen);
    rig.head.eye_center = reflect(mirror, seen_eye);
    rig.head.right = glm::normalize(behind.lower_right - behind.lower_left);
    const auto eyes = eye_views(rig);
    const dvec3 middle = 0.5 * (behind.lower_right + behind.upper_left), up = behind.upper_left - behind.lower_left;
    const dvec3 to_eye = glm::dot(mirror.normal, rig.head.eye_center) > mirror.offset ? mirror.normal : -mirror.normal;
    for (int k = 0; k < 10; ++k) {
      const dvec3 p = middle + 0.01 * g.uniform(0, 1) * g.direction();
      EXPECT_NEAR(ndc(eyes[0], p).y, ndc(eyes[1], p).y, 1e-10);
      for (const EyeView& eye : eyes) {
        // Solves for the ray through the glass plate.
        double shift = 0;
        for (int round = 0; round < 60; ++round) {
          const double cosine = std::abs(glm::dot(glm::normalize(p + shift * to_eye - eye.position), mirror.normal));
          shift = mirror.glass_thickness *
                  (1 - cosine / std::sqrt(mirror.glass_index * mirror.glass_index - 1 + cosine * cosine));
        }
        const dvec3 looks = p + shift * to_eye;
        const EyeView thin = eye_view(c.screen, mirror, eye.position, {});
        const dvec2 apart = dvec2(ndc(eye, p)) - dvec2(ndc(thin, looks));
        const dvec2 size{glm::length(behind.lower_right - behind.lower_left), glm::length(up)};
        EXPECT_LT(glm::length(0.5 * apart * size), 0.06 * mirror.glass_thickness);
      }
    }
  }
}

TEST(Frusta, NearAndFarPlanesHaveDepthZeroAndOne) {
  Generator g;
  for (int i = 0; i < 200; ++i) {
    const auto c = g.screen();
    const dvec3 e = g.eye(c);
    const ClipRange range{g.uniform(0.01, 0.15), g.uniform(1.0, 5.0)};
    const EyeView eye = eye_view(c.screen, {}, e, range);
    const dvec3 aside = g.uniform(-0.3, 0.3) * c.right + g.uniform(-0.3, 0.3) * c.up;
    EXPECT_NEAR(ndc(eye, e - range.near * c.normal + aside).z, 0, 1e-12);
    EXPECT_NEAR(ndc(eye, e - range.far * c.normal + aside).z, 1, 1e-12);
    EXPECT_EQ(eye.frustum.near, range.near);
  }
}

TEST(Frusta, RealEyeAndReflectedScreenEqualMirroredEyeAndMirroredWorld) {
  Generator g;
  for (int i = 0; i < 500; ++i) {
    const auto c = g.screen();
    const Mirror mirror{g.direction(), g.uniform(-0.5, 0.5)};
    const dvec3 mirrored_eye = g.eye(c), real_eye = reflect(mirror, mirrored_eye);
    const EyeView seen = eye_view(c.screen, mirror, real_eye, {});
    const EyeView direct = eye_view(c.screen, {}, mirrored_eye, {});
    const dmat4 other = direct.view * reflection(mirror);
    for (int column = 0; column < 4; ++column)
      for (int row = 0; row < 4; ++row) {
        EXPECT_NEAR(seen.view[column][row], other[column][row], 1e-12);
        EXPECT_NEAR(seen.projection[column][row], direct.projection[column][row], 1e-9);
      }
    EXPECT_TRUE(seen.flip);
    EXPECT_NEAR(glm::determinant(seen.view), -1, 1e-12);
    EXPECT_NEAR(glm::determinant(direct.view), 1, 1e-12);
  }
}

TEST(Magnified, EveryPointIsDrawnAtItsMagnifiedDistanceFromTheCentre) {
  Generator g;
  for (int i = 0; i < 500; ++i) {
    const auto c = g.screen();
    DisplayRig rig;
    rig.screen = c.screen;
    rig.head.eye_center = g.eye(c);
    rig.head.ipd = 0.06;
    rig.head.right = c.right;
    if (i % 2) {  // the same rig, seen in a mirror beside the eyes
      Mirror mirror{g.direction(), g.uniform(-0.3, 0.3), g.uniform(0, 0.004), 1.5};
      rig.mirror = mirror;
      rig.head.eye_center = reflect(mirror, rig.head.eye_center);
      rig.head.right = reflect(mirror, c.right) - reflect(mirror, dvec3(0));
    }
    rig.magnify = g.uniform(0.5, 12);
    const dvec3 about = c.middle + 0.05 * g.direction();
    const DisplayRig shrunk = magnified(rig, about);
    EXPECT_EQ(shrunk.magnify, 1);
    const auto life = eye_views(rig), larger = eye_views(shrunk);
    const dvec3 p = about + 0.01 * g.direction();
    for (std::size_t e = 0; e < 2; ++e) {
      const dvec3 a = ndc(larger[e], p), b = ndc(life[e], about + rig.magnify * (p - about));
      ASSERT_NEAR(a.x, b.x, 1e-7);
      ASSERT_NEAR(a.y, b.y, 1e-7);
      // A point at the centre of magnification is seen where it is felt.
      ASSERT_NEAR(ndc(larger[e], about).x, ndc(life[e], about).x, 1e-7);
    }
    EXPECT_EQ(sees(shrunk, shrunk.head), sees(rig, rig.head));
    // A centre that the rig sets has priority over the centre of the work.
    rig.magnify_about = about + dvec3(0.01, 0, 0);
    EXPECT_EQ(magnified(rig, about).head.eye_center, magnified(rig, *rig.magnify_about).head.eye_center);
  }
}

}  // namespace
}  // namespace typodont::display
