// Compares the plan of a mirror bench with geometry that was computed by hand.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "engine/base/units.h"
#include "engine/display/rig_plan.h"

namespace typodont::display {
namespace {

/// Returns a bench with a panel above a flat mirror. The user looks straight down.
BenchSpec straight_down() {
  BenchSpec spec;
  spec.panel_width = 0.4, spec.panel_height = 0.3;
  spec.eye_distance = 0.6, spec.ipd = 0;
  spec.gaze = kPi / 2;
  spec.glass_above_work = 0.2;
  spec.arm_box = dvec3(2);
  spec.hand_room = 0.02;
  return spec;
}

double distance(const dvec3& a, const dvec3& b) {
  return glm::length(a - b);
}

TEST(RigPlan, ThePanelIsTheMirrorImageOfThePicture) {
  for (const double mirror : {-30.0, 0.0, 20.0, 45.0}) {
    for (const double picture : {0.0, 35.0, 90.0}) {
      BenchSpec spec = straight_down();
      spec.mirror_tilt = mirror * kDegree, spec.picture_tilt = picture * kDegree;
      const BenchPlan plan = plan_bench(spec);
      // p: tilt of the picture, m: tilt of the mirror. The mirror maps the picture's up direction (0, cos p, sin p) to
      // (0, cos(2m - p), sin(2m - p)), and the picture's middle to twice the foot of the glass.
      const double tilt = (2 * mirror - picture) * kDegree, m = mirror * kDegree;
      const dvec3 up(0, std::cos(tilt), std::sin(tilt)), middle = 0.4 * dvec3(0, -std::sin(m), std::cos(m));
      const Screen& panel = plan.rig.screen;
      EXPECT_LT(distance(panel.lower_left, middle - 0.15 * up + dvec3(0.2, 0, 0)), 1e-12) << mirror << " " << picture;
      EXPECT_LT(distance(panel.lower_right, middle - 0.15 * up - dvec3(0.2, 0, 0)), 1e-12) << mirror << " " << picture;
      EXPECT_LT(distance(panel.upper_left, middle + 0.15 * up + dvec3(0.2, 0, 0)), 1e-12) << mirror << " " << picture;
    }
  }
}

TEST(RigPlan, TheRendererPlacesThePictureWhereThePlanDoes) {
  BenchSpec spec = straight_down();
  spec.gaze = 55 * kDegree, spec.mirror_tilt = 5 * kDegree, spec.picture_tilt = 20 * kDegree, spec.ipd = 0.063;
  const BenchPlan plan = plan_bench(spec);
  const Screen seen = reflect(*plan.rig.mirror, plan.rig.screen);
  // Mirrored, left and right change places.
  EXPECT_LT(distance(seen.lower_right, plan.picture.lower_left), 1e-12);
  EXPECT_LT(distance(seen.lower_left, plan.picture.lower_right), 1e-12);
  const EyeView view = eye_view(plan.rig.screen, plan.rig.mirror, plan.rig.head.eye_center, {0.1, 2});
  EXPECT_TRUE(view.flip);
  const glm::dvec4 clip = view.projection * view.view * glm::dvec4(plan.picture.lower_right, 1);
  EXPECT_NEAR(std::abs(clip.x / clip.w), 1, 1e-9);
  EXPECT_NEAR(std::abs(clip.y / clip.w), 1, 1e-9);
}

TEST(RigPlan, TheEyesFollowFromDistanceAndGaze) {
  BenchSpec spec = straight_down();
  spec.gaze = 50 * kDegree, spec.eye_distance = 0.5;
  const dvec3 eye = plan_bench(spec).rig.head.eye_center;
  EXPECT_LT(distance(eye, dvec3(0, -0.5 * std::cos(50 * kDegree), 0.5 * std::sin(50 * kDegree))), 1e-15);
}

TEST(RigPlan, TheGlassCoversTheRaysThroughItAndAMargin) {
  BenchSpec spec = straight_down();
  spec.ipd = 0.06;
  const BenchPlan plan = plan_bench(spec);
  // From an eye at (±0.03, 0, 0.6) to a corner at (±0.2, ±0.15, 0): at a height of 0.2 a third of the way from the
  // picture. Widest: the right eye to the right corner.
  EXPECT_NEAR(plan.glass_width, 2 * (0.2 * 2 / 3 + 0.03 / 3 + 0.01), 1e-12);
  EXPECT_NEAR(plan.glass_length, 2 * (0.15 * 2 / 3 + 0.01), 1e-12);
  for (const dvec3& corner : plan.glass) EXPECT_NEAR(corner.z, 0.2, 1e-12);
}

TEST(RigPlan, TheWorkspaceOfASmallArmIsItsWholeReach) {
  BenchSpec spec = straight_down();
  spec.arm_box = {0.06, 0.05, 0.04};
  spec.gaze = 60 * kDegree;
  const BenchPlan plan = plan_bench(spec);
  EXPECT_LT(distance(plan.low, dvec3(-0.03, -0.025, -0.02)), 1e-9);
  EXPECT_LT(distance(plan.high, dvec3(0.03, 0.025, 0.02)), 1e-9);
  for (const Face& face : plan.faces) EXPECT_EQ(face.limit, "the arm's reach");
}

TEST(RigPlan, TheWorkspaceOfOneEyeAboveThePictureIsTheLargestBoxOfThePyramid) {
  // The workspace reaches by a above the picture and by b below it. At the height a, only a width of w(1 - a/d) is seen
  // through the picture (d: distance of the eye). The volume is proportional to (1 - a/d)² (a + b), and is the largest
  // for a = (d - 2b)/3, if comfort allows this height.
  BenchSpec spec = straight_down();
  spec.glass_above_work = 0.5;
  spec.arm_box = {2, 2, 0.5};  // down to 0.25 below
  // 1/m; the farthest point is at infinity, the nearest at 1/(1/0.6 + 3) = 0.214 m, which is 0.386 m above
  spec.comfort = 3;
  const BenchPlan plan = plan_bench(spec);
  const double d = 0.6, b = 0.25, a = (d - 2 * b) / 3;
  EXPECT_NEAR(plan.low.z, -b, 1e-6);
  EXPECT_NEAR(plan.high.z, a, 1e-5);
  EXPECT_NEAR(plan.high.x, 0.2 * (1 - a / d), 1e-5);
  EXPECT_NEAR(plan.low.y, -0.15 * (1 - a / d), 1e-5);
  EXPECT_TRUE(std::isinf(plan.farthest));
  EXPECT_EQ(plan.faces[1].limit, "the picture's right edge");
  EXPECT_EQ(plan.faces[4].limit, "the arm's reach");
}

TEST(RigPlan, ComfortableDepthIsCountedInDioptresFromThePicture) {
  BenchSpec spec = straight_down();
  spec.eye_distance = 0.5, spec.comfort = 0.5;
  spec.arm_box = {0.02, 0.02, 1};
  const BenchPlan plan = plan_bench(spec);
  EXPECT_NEAR(plan.nearest, 1 / 2.5, 1e-12);
  EXPECT_NEAR(plan.farthest, 1 / 1.5, 1e-12);
  EXPECT_NEAR(plan.high.z, 0.1, 1e-6);
  EXPECT_NEAR(plan.low.z, 0.5 - 1 / 1.5, 1e-6);
  EXPECT_EQ(plan.faces[5].limit, "comfortable depth in front of the picture");
  EXPECT_EQ(plan.faces[4].limit, "comfortable depth behind the picture");
}

TEST(RigPlan, EveryCornerOfTheWorkspaceIsSeenByBothEyesThroughThePicture) {
  for (const double gaze : {40.0, 52.0, 65.0}) {
    for (const double tilt : {0.0, 20.0, 38.0}) {
      BenchSpec spec = straight_down();
      spec.gaze = gaze * kDegree, spec.picture_tilt = tilt * kDegree, spec.ipd = 0.063, spec.eye_distance = 0.52;
      spec.panel_width = 0.2, spec.panel_height = 0.12;
      const BenchPlan plan = plan_bench(spec);
      if (plan.low == plan.high) continue;
      const dvec3 along = plan.picture.upper_left - plan.picture.lower_left;
      const dvec3 normal = glm::normalize(glm::cross(dvec3(1, 0, 0), along));
      for (int corner = 0; corner < 8; ++corner) {
        const dvec3 p(corner & 1 ? plan.low.x : plan.high.x, corner & 2 ? plan.low.y : plan.high.y,
                      corner & 4 ? plan.low.z : plan.high.z);
        for (const double side : {-0.5, 0.5}) {
          const dvec3 eye = plan.rig.head.eye_center + dvec3(side * spec.ipd, 0, 0);
          const double s = glm::dot(normal, eye) / glm::dot(normal, eye - p);
          const dvec3 at = eye + s * (p - eye);  // in the picture's plane
          EXPECT_LE(std::abs(at.x), 0.1 + 1e-7) << gaze << " " << tilt;
          EXPECT_LE(std::abs(glm::dot(at, glm::normalize(along))), 0.06 + 1e-7) << gaze << " " << tilt;
        }
        EXPECT_LE(glm::dot(plan.rig.mirror->normal, p), plan.rig.mirror->offset - spec.hand_room + 1e-7);
      }
    }
  }
}

TEST(RigPlan, CollisionsAreReportedByName) {
  const auto conflicts = [](const BenchSpec& spec) {
    std::string all;
    for (const std::string& conflict : plan_bench(spec).conflicts) all += conflict + "; ";
    return all;
  };
  EXPECT_EQ(conflicts([] {
              BenchSpec spec = straight_down();
              spec.gaze = 50 * kDegree;
              return spec;
            }()),
            "");
  BenchSpec spec = straight_down();
  EXPECT_NE(conflicts(spec).find("the panel stands between the eyes and the glass"), std::string::npos)
      << "straight down, the panel is before the face: " << conflicts(spec);
  spec.glass_above_work = 0.7;
  EXPECT_NE(conflicts(spec).find("the eyes are 100 mm behind the glass"), std::string::npos) << conflicts(spec);
  spec = straight_down();
  spec.picture_tilt = 90 * kDegree, spec.glass_above_work = 0.1;
  EXPECT_NE(conflicts(spec).find("the picture reaches through the glass"), std::string::npos) << conflicts(spec);
  spec = straight_down();
  spec.gaze = 0;
  EXPECT_NE(conflicts(spec).find("from its edge or its back"), std::string::npos) << conflicts(spec);
  spec = straight_down();
  spec.gaze = 50 * kDegree, spec.hand_room = 0.25;
  EXPECT_NE(conflicts(spec).find("room for the hand below the glass (-50 mm)"), std::string::npos) << conflicts(spec);
}

}  // namespace
}  // namespace typodont::display
