// Tests the force on shapes with edges, hollows and creases against formulas.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "engine/base/units.h"
#include "tests/support/haptic_bench.h"

namespace typodont {
namespace {

using namespace literals;
using test::HapticBench;

constexpr double kBall = 0.5_mm;  // radius of the probe

haptics::ServoSettings probe() {
  haptics::ServoSettings s;
  s.tool.diameter = s.tool.length = 2 * kBall;
  s.tool.cuts = false;
  s.friction = false;
  s.damping = 0;
  return s;
}

std::string enamel(double voxel_mm, const std::string& solid) {
  return fmt::format(R"({{"voxel_mm": {}, "solids": [{{"tissue": "enamel", "solid": {}}}]}})", voxel_mm, solid);
}

struct Error {
  double direction = 0;  // rad, worst
  double magnitude = 0;  // relative, worst
};

/// Moves the probe from `from` to hand(0) and along hand(s), with s from 0 to 1. `pushed`: returns the displacement of
/// the hand by the shape's formula; at 1 N/mm, it is also the force.
Error slide(const std::string& tissue, const dvec3& from, const std::function<dvec3(double)>& hand,
            const std::function<dvec3(const dvec3&)>& pushed) {
  HapticBench bench(tissue, probe());
  for (int i = 0; i <= 150; ++i) bench.tick({glm::mix(from, hand(0), i / 150.0)});
  Error worst;
  for (int i = 0; i <= 600; ++i) {
    const dvec3 p = hand(i / 600.0), f = bench.tick({p}).f_T_W, wanted = 1000.0 * pushed(p);
    worst.direction =
        std::max(worst.direction, glm::length(glm::cross(f, wanted)) / (glm::length(f) * glm::length(wanted)));
    worst.magnitude = std::max(worst.magnitude, std::abs(glm::length(f) / glm::length(wanted) - 1));
    EXPECT_EQ(bench.last.faults, 0u);
  }
  return worst;
}

/// Moves a ball over one edge of a box of 6 mm, from face to face. The hand is inside the surface by the fraction
/// `deep` of the ball's radius.
Error over_edge(double voxel_mm, double deep) {
  const dvec3 middle(0.13_mm, -0.07_mm, 0.21_mm);
  const double half = 3.0_mm, g = kBall * (1 - deep);
  const auto hand = [&](double s) {
    const double way = -1.0_mm + s * (2.0_mm + g * kPi / 2), a = std::clamp(way / g, 0.0, kPi / 2);
    const dvec3 corner(half + std::min(way, 0.0), 0.4_mm * s, half - std::max(way - g * kPi / 2, 0.0));
    return middle + corner + g * dvec3(std::sin(a), 0, std::cos(a));
  };
  return slide(enamel(voxel_mm, R"({"box": {"center_mm": [0.13, -0.07, 0.21], "size_mm": [6, 6, 6]}})"),
               hand(0) + dvec3(0, 0, 1.0_mm), hand, [&](const dvec3& p) {
                 const dvec3 out = glm::max(glm::abs(p - middle) - half, dvec3(0)) * glm::sign(p - middle);
                 return out * (kBall / glm::length(out) - 1);
               });
}

TEST(Contact, OverABoxsEdgeTheForceErrorIsAtMostTwoHundredthsOfADegreeAtAnyDepth) {
  for (const double deep : {0.25, 0.6, 0.9}) {
    for (const double voxel_mm : {0.1, 0.05}) {
      const Error error = over_edge(voxel_mm, deep);
      EXPECT_LT(error.direction, 0.02_deg) << deep << " " << voxel_mm;
      EXPECT_LT(error.magnitude, 2e-4) << deep << " " << voxel_mm;
    }
  }
}

TEST(Contact, OverABoxsCornerTheForceErrorIsAtMostTwoHundredthsOfADegree) {
  const dvec3 corner(2.93_mm, 3.11_mm, 3.04_mm);
  const auto hand = [&](double s) {
    const double a = 0.15 + 1.2 * s, b = 0.9 - 0.5 * s;
    return corner + 0.3_mm * dvec3(std::cos(a) * std::cos(b), std::sin(a) * std::cos(b), std::sin(b));
  };
  const Error error = slide(enamel(0.1, R"({"box": {"size_mm": [5.86, 6.22, 6.08]}})"), corner + dvec3(1.0_mm), hand,
                            [&](const dvec3& p) { return (p - corner) * (kBall / glm::length(p - corner) - 1); });
  EXPECT_LT(error.direction, 0.02_deg);
  EXPECT_LT(error.magnitude, 2e-4);
}

/// Moves a ball around in a bore and along the bore's axis at the same time.
Error round_in(double voxel_mm, double radius) {
  const dvec3 axis = glm::normalize(dvec3(0.2, -0.1, 1)), u = glm::normalize(glm::cross(axis, dvec3(0, 1, 0))),
              v = glm::cross(axis, u);
  const std::string solid = fmt::format(R"({{"difference": [{{"box": {{"size_mm": [9, 9, 8]}}}},
      {{"cylinder": {{"axis": [0.2, -0.1, 1], "radius_mm": {}, "height_mm": 20}}}}]}})",
                                        radius / 1.0_mm);
  const double held = radius - kBall + 0.25_mm;
  return slide(
      enamel(voxel_mm, solid), dvec3(0),
      [&](double s) { return held * (std::cos(7 * s) * u + std::sin(7 * s) * v) + (s - 0.5) * 1.0_mm * axis; },
      [&](const dvec3& p) {
        const dvec3 aside = p - glm::dot(p, axis) * axis;
        return -aside * (1 - (radius - kBall) / glm::length(aside));
      });
}

TEST(Contact, InABoreTheForceErrorIsAtMostTwoHundredthsOfADegreeAndOfSecondOrder) {
  const Error coarse = round_in(0.2, 1.7_mm), middle = round_in(0.1, 1.7_mm), fine = round_in(0.05, 1.7_mm);
  EXPECT_LT(middle.direction, 0.02_deg);
  EXPECT_LT(middle.magnitude, 2e-4);
  EXPECT_LT(middle.direction, coarse.direction / 4);
  EXPECT_LT(middle.magnitude, coarse.magnitude / 8);
  EXPECT_LT(fine.direction, middle.direction / 4);
  EXPECT_LT(fine.magnitude, middle.magnitude / 8);
  EXPECT_LT(round_in(0.05, 0.9_mm).direction, 0.02_deg);  // hardly wider than the ball
}

TEST(Contact, InAnyVGrooveTheForceErrorIsAtMostTwoHundredthsOfADegree) {
  for (const double degrees : {17.0, 48.0, 61.0, 72.0, 77.0, 81.0, 86.0}) {
    for (const double turn : {0.0, 0.7}) {
      const double half_angle = degrees * kDegree, c = std::cos(half_angle), s = std::sin(half_angle);
      const dquat R = glm::angleAxis(turn, dvec3(0, 0, 1));
      const dvec3 n = R * dvec3(c, 0, -s), m = R * dvec3(-c, 0, -s), along = R * dvec3(0, 1, 0);
      const std::string solid =
          fmt::format(R"({{"difference": [{{"box": {{"center_mm": [0, 0, -1], "size_mm": [9, 9, 9]}}}},
          {{"intersection": [{{"halfspace": {{"normal": [{}, {}, {}], "offset_mm": 0}}}},
                             {{"halfspace": {{"normal": [{}, {}, {}], "offset_mm": 0}}}}]}}]}})",
                      n.x, n.y, n.z, m.x, m.y, m.z);
      const dvec3 seat(0, 0, kBall / s), push(0, 0, 0.2_mm);
      const Error error = slide(
          enamel(0.1, solid), seat - 0.5_mm * along + push,
          [&](double way) { return seat + (way - 0.5) * 1.0_mm * along - push; }, [&](const dvec3&) { return push; });
      EXPECT_LT(error.direction, 0.02_deg) << degrees << " turned by " << turn;
      EXPECT_LT(error.magnitude, 2e-4) << degrees << " turned by " << turn;
    }
  }
}

TEST(Contact, AlongACreaseTheBallStaysSeatedAndHasDynamicFriction) {
  for (const double half_angle : {15.0_deg, 40.0_deg, 65.0_deg, 70.0_deg}) {
    const double c = std::cos(half_angle), s = std::sin(half_angle);
    const std::string solid =
        fmt::format(R"({{"difference": [{{"box": {{"center_mm": [0, 0, -1], "size_mm": [9, 9, 9]}}}},
        {{"intersection": [{{"halfspace": {{"normal": [{0}, 0, {1}], "offset_mm": 0}}}},
                           {{"halfspace": {{"normal": [-{0}, 0, {1}], "offset_mm": 0}}}}]}}]}})",
                    c, -s);
    haptics::ServoSettings settings = probe();
    settings.friction = true;
    HapticBench bench(enamel(0.1, solid), settings);
    const double seat = kBall / s, push = 0.3_mm;
    for (double z = seat + 0.5_mm; z > seat - push; z -= 0.01_mm) bench.tick({{0, -1.0_mm, z}});
    for (double y = -1.0_mm; y < 1.0_mm; y += 0.002_mm) {
      const dvec3 f = bench.tick({{0, y, seat - push}}).f_T_W;
      if (y < 0) continue;
      EXPECT_NEAR(bench.last.X_WG.p.z, seat, 2e-7);
      EXPECT_NEAR(f.z, 0.3, 1e-3);
      EXPECT_NEAR(f.y, -0.15 * 0.3, 1e-3) << half_angle / kDegree;
      EXPECT_LT(std::abs(f.x), 1e-3);
    }
  }
}

TEST(Contact, ATiltedCylinderRestsOnItsRimWithTheWallsForceAndTorque) {
  constexpr double kLength = 4.0_mm;
  for (const double tilt : {10.0_deg, 30.0_deg, 50.0_deg, 80.0_deg}) {
    haptics::ServoSettings s = probe();
    s.tool.shape = haptics::HeadShape::kCylinder;
    s.tool.length = kLength;
    s.gives_torque = false;  // an arm with torque lets the cylinder turn
    HapticBench bench(enamel(0.1, R"({"box": {"center_mm": [0.03, 0, -3], "size_mm": [12, 12, 6]}})"), s);
    const dquat R(std::cos(tilt / 2), 0, std::sin(tilt / 2), 0);
    const double low =
        kLength / 2 * std::cos(tilt) + kBall * std::sin(tilt);  // the rim's lowest point under the middle
    const double aside = kLength / 2 * std::sin(tilt) - kBall * std::cos(tilt);
    for (double z = low + 0.3_mm; z > low - 0.4_mm; z -= 4e-6) bench.tick({{0, 0, z}, R});
    const Pose held{{0, 0, low - 0.4_mm}, R};
    for (int i = 0; i < 50; ++i) bench.tick(held);
    EXPECT_NEAR(bench.last.X_WG.p.x, 0, 2e-7) << tilt / kDegree;
    EXPECT_NEAR(bench.last.X_WG.p.z, low, 2e-7) << tilt / kDegree;
    EXPECT_NEAR(bench.last.f_T_W.z, 0.4, 1e-3) << tilt / kDegree;
    EXPECT_LT(std::abs(bench.last.f_T_W.x), 2e-4) << tilt / kDegree;
    EXPECT_NEAR(bench.last.tau_T_W.y, 0.4 * aside, 0.4 * 5e-6) << tilt / kDegree;
  }
}

}  // namespace
}  // namespace typodont
