// Tests that colours with different meanings look different to people with every kind of colour blindness.
#include "tests/support/color_vision.h"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace typodont::test
