// Tests that colours with different meanings look different to people with every kind of colour blindness.
#include "tests/support/color_vision.h"

#include <gtest/gtest.h>

#include "engine/app/picture/temperature_picture.h"
#include "engine/contract/tissue.h"
#include "engine/session/page/model_colors.h"

namespace typodont::test {
namespace {

glm::dvec3 color(const std::array<int, 3>& c) {
  return {c[0], c[1], c[2]};
}

TEST(ColorBlindness, ConfusesRedAndGreenAndSparesWhiteAndBlack) {
  EXPECT_LT(difference(Vision::kDeutan, {170, 60, 40}, {110, 100, 40}),
            0.6 * difference(Vision::kNormal, {170, 60, 40}, {110, 100, 40}));
  for (const Vision vision : kVisions) EXPECT_GT(difference(vision, {0, 0, 0}, {255, 255, 255}), 95);
}

TEST(ColorBlindness, LeavesTheTissuesOfTheReportApart) {
  constexpr double kMin = 7;  // CIEDE2000; two colours side by side differ visibly from about 2
  for (std::size_t a = 1; a < kTissueCount; ++a) {
    for (std::size_t b = a + 1; b < kTissueCount; ++b) {
      for (const Vision vision : kVisions) {
        EXPECT_GT(difference(vision, color(session::kTissueColors[a]), color(session::kTissueColors[b])), kMin)
            << name_of(static_cast<Tissue>(a)) << " and " << name_of(static_cast<Tissue>(b));
      }
    }
  }
}

TEST(ColorBlindness, LeavesTooMuchAndTooDeepApartOnTheDifferenceMap) {
  for (const Vision vision : kVisions) {
    for (std::size_t a = 0; a < 3; ++a) {
      for (std::size_t b = a + 1; b < 3; ++b)
        EXPECT_GT(difference(vision, color(session::kDifferenceColors[a]), color(session::kDifferenceColors[b])), 30);
    }
  }
}

TEST(ColorBlindness, LeavesColdNeutralAndWarmTemperaturesApartAndInTheOrderOfTheirLightness) {
  const auto scale = [](double celsius) { return glm::dvec3(255.0f * temperature_color(celsius)); };
  const auto lightness = [](const glm::dvec3& c) { return glm::dot(c, glm::dvec3(0.2126, 0.7152, 0.0722)); };
  for (double away = 0; away < 23; ++away) {
    EXPECT_LT(lightness(scale(37 + away + 1)), lightness(scale(37 + away)));
    EXPECT_LT(lightness(scale(37 - away - 1)), lightness(scale(37 - away)));
  }
  for (const Vision vision : kVisions) {
    for (double away = 3; away <= 23; away += 2) {
      EXPECT_GT(difference(vision, scale(37 + away), scale(37 - away)), 7) << away;
      EXPECT_GT(difference(vision, scale(37 + away), scale(37)), 2) << away;
      EXPECT_GT(difference(vision, scale(37 - away), scale(37)), 2) << away;
    }
  }
}

}  // namespace
}  // namespace typodont::test
