// Tests the exact contact, with which contact models are compared, against analytic results.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "engine/base/units.h"
#include "tests/support/model_tissues.h"

namespace typodont::test {
namespace {

using namespace literals;

ModelTissue tissue_named(const std::string& name) {
  for (ModelTissue& tissue : analytic_tissues())
    if (tissue.name == name) return tissue;
  throw std::logic_error("no tissue " + name);
}

/// Moves the ball from `from` to `to` in `steps` steps. Returns the position at which it rests.
dvec3 led(const ModelTissue& tissue, const dvec3& from, const dvec3& to, int steps) {
  ReferenceContact contact(tissue.shape, kProbeRadius);
  contact.place(from);
  for (int i = 1; i <= steps; ++i) contact.follow(glm::mix(from, to, static_cast<double>(i) / steps));
  return contact.center();
}

TEST(ReferenceContact, OnABallTheCentreLiesOnTheLineToTheHand) {
  const dvec3 way = glm::normalize(dvec3(0.3, -0.2, 0.9));
  const dvec3 rest = led(tissue_named("ball"), 6.0_mm * way, 4.3_mm * way, 20);
  EXPECT_LT(glm::distance(rest, 4.6_mm * way), 1e-12);
}

TEST(ReferenceContact, InAGrooveTheBallTouchesBothWalls) {
  // The groove has a half-angle of 30 degrees. The centre rests at r / sin 30 above the bottom, wherever the hand is
  // below it.
  const dvec3 rest = led(tissue_named("groove"), {0, 0.4_mm, 1.0_mm}, {0.05_mm, 0.4_mm, -1.3_mm}, 100);
  EXPECT_LT(glm::distance(rest, dvec3(0, 0.4_mm, -2.0_mm + kProbeRadius / std::sin(30 * kDegree))), 1e-9);
}

TEST(ReferenceContact, AroundAnEdgeTheCentreStaysOneRadiusAwayFromIt) {
  // The hand is beside and above the edge x = 3, z = 2 of the box. So the nearest point of the surface is on the edge.
  const dvec3 hand(3.2_mm, 0.1_mm, 2.3_mm);
  const dvec3 rest = led(tissue_named("box edges"), {3.6_mm, 0.1_mm, 2.9_mm}, hand, 50);
  const dvec3 edge(3.0_mm, 0.1_mm, 2.0_mm);
  EXPECT_LT(glm::distance(rest, edge + kProbeRadius * glm::normalize(hand - edge)), 1e-9);
}

TEST(ReferenceContact, NoHandPullsTheBallThroughAThinSheet) {
  const dvec3 rest = led(tissue_named("thin sheet"), {0, 0, 1.0_mm}, {0.3_mm, 0.2_mm, -5.0_mm}, 3);
  EXPECT_LT(glm::distance(rest, dvec3(0.3_mm, 0.2_mm, 0.15_mm + kProbeRadius)), 1e-9);
}

TEST(ReferenceContact, AlongEveryPathTheBallStaysOutsideTheTissue) {
  for (const ModelTissue& tissue : analytic_tissues()) {
    const Course course = slide_course(tissue, 1500);
    double deepest = 0, away = 0;
    for (std::size_t i = 0; i < course.truth.size(); ++i) {
      deepest = std::max(deepest, kProbeRadius - tissue.shape.nearest(course.truth[i], 5.0_mm).distance);
      away = std::max(away, glm::distance(course.truth[i], course.hand[i]));
    }
    EXPECT_LT(deepest, 1e-8) << tissue.name;
    EXPECT_GT(away, 0.25_mm) << tissue.name << ": the hand presses";
    EXPECT_LT(away, 0.7_mm) << tissue.name;
  }
}

TEST(SweptVolume, OfACapInABallIsTheFormulaToAPercent) {
  // Two balls whose centres are d apart have a lens in common.
  const double R = 4.0_mm, r = kProbeRadius, d = 4.2_mm;
  const double lens = kPi * std::pow(R + r - d, 2) * (d * d + 2 * d * (R + r) - 3 * std::pow(R - r, 2)) / (12 * d);
  const dvec3 c(0, 0, d);
  EXPECT_NEAR(swept_volume(tissue_named("ball").shape, {{c, c}}, r, 0.02_mm) / lens, 1, 0.01);
}

}  // namespace
}  // namespace typodont::test
