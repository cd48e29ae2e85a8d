// Meanings that are told by a colour stay apart for people with every kind of colour blindness.
#include "tests/support/color_vision.h"

#include <gtest/gtest.h>

#include "engine/contract/tissue.h"
#include "engine/session/page/model_colors.h"

namespace typodont::test {
namespace {

glm::dvec3 color(const std::array<int, 3>& c) {
  return {c[0], c[1], c[2]};
}

// Pairs of the published test data (Sharma, Wu & Dalal 2005, table 1).
TEST(ColorDifference, IsCiede2000) {
  EXPECT_NEAR(ciede2000({50, 2.6772, -79.7751}, {50, 0, -82.7485}), 2.0425, 1e-4);
  EXPECT_NEAR(ciede2000({50, 2.5, 0}, {73, 25, -18}), 27.1492, 1e-4);
  EXPECT_NEAR(ciede2000({50, -1, 2}, {50, 0, 0}), 2.3669, 1e-4);
  EXPECT_NEAR(ciede2000({2.0776, 0.0795, -1.1350}, {0.9033, -0.0636, -0.5514}), 0.9082, 1e-4);
}

TEST(ColorBlindness, ConfusesRedAndGreenAndSparesWhiteAndBlack) {
  EXPECT_LT(difference(Vision::kDeutan, {170, 60, 40}, {110, 100, 40}),
            0.6 * difference(Vision::kNormal, {170, 60, 40}, {110, 100, 40}));
  for (const Vision vision : kVisions) EXPECT_GT(difference(vision, {0, 0, 0}, {255, 255, 255}), 95);
}

TEST(ColorBlindness, LeavesTheTissuesOfTheReportApart) {
  constexpr double kLeast = 7;  // CIEDE2000; two colours side by side differ visibly from about 2
  for (std::size_t a = 1; a < kTissueCount; ++a) {
    for (std::size_t b = a + 1; b < kTissueCount; ++b) {
      for (const Vision vision : kVisions) {
        EXPECT_GT(difference(vision, color(session::kTissueColors[a]), color(session::kTissueColors[b])), kLeast)
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
