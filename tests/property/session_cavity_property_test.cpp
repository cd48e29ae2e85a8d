// Scores of geometry obey the same laws: the ideal scores full, and whatever is cut too much or left lowers the score,
// the more the lower.
#include <gtest/gtest.h>

#include "engine/base/units.h"
#include "engine/session/score.h"
#include "tests/support/cavity_fixture.h"
#include "tests/support/session_fixture.h"

namespace typodont::session {
namespace {

using namespace test;

/// Every geometric rule, with what the ideal has as target.
std::vector<ScoreRule> all_rules(const ScoreInput& input) {
  const Json block = Json::parse(R"({"rules": [
    {"name": "over_cut_mm3", "target": 0, "tolerance": 1, "weight": 20},
    {"name": "under_cut_mm3", "target": 0, "tolerance": 1, "weight": 20},
    {"name": "over_cut_depth_mm", "target": 0, "tolerance": 0.3, "weight": 10},
    {"name": "under_cut_depth_mm", "target": 0, "tolerance": 0.3, "weight": 10},
    {"name": "contour_rms_um", "target": 0, "tolerance": 100, "weight": 10},
    {"name": "floor_depth_mm", "tolerance": 0.5, "weight": 1},
    {"name": "taper_deg", "tolerance": 10, "weight": 1},
    {"name": "isthmus_mm", "tolerance": 0.5, "weight": 1},
    {"name": "floor_flatness_um", "tolerance": 100, "weight": 1},
    {"name": "margin_roughness_um", "tolerance": 100, "weight": 1}]})", "rules");
  return rules_from(block, input);
}

struct Judged {
  Preparation preparation = a_block();
  ScoreInput input;
  std::vector<ScoreRule> rules;

  template <class Ideal>
  explicit Judged(Ideal ideal) {
    preparation.ideal = preparation.after = without(ideal);
    input.before[2] = 100e-9;
    input.after = input.before;
    input.cavity_ideal = measure_against_ideal(preparation).ideal;
    input.cavity = input.cavity_ideal;
    rules = all_rules(input);
  }
  Score of(DenseField after) {
    preparation.after = std::move(after);
    input.cavity = measure_cavity(preparation);
    return score(input, rules);
  }
};

TEST(CavityLaws, TheIdealScoresFullWhateverItsShape) {
  Random random(11);
  for (int i = 0; i < 4; ++i) {
    const double lean = random.number(8) * kPi / 180, depth = 1.4e-3 + random.number(0.4e-3);
    const dvec3 middle = kMiddle + dvec3(random.number(1e-3), random.number(1e-3), 0);
    const Judged judged(tapered_hole(1.3e-3 + random.number(0.3e-3), depth, lean, middle));
    const Score s = score(judged.input, judged.rules);
    ASSERT_NEAR(s.points, s.full, 1e-9 * s.full);
    ASSERT_EQ(s.completion, 1);
  }
}

TEST(CavityLaws, CuttingMoreThanTheIdealLowersTheScoreTheMoreTheLower) {
  Random random(12);
  const auto ideal = tapered_box({1.4e-3, 1e-3}, 1.5e-3, 3 * kPi / 180);
  Judged judged(ideal);
  const double full = score(judged.input, judged.rules).points;
  for (int i = 0; i < 4; ++i) {
    // A ball somewhere on the cavity's wall or floor, or on sound surface, growing.
    const dvec3 at = kMiddle + dvec3(random.number(2e-3), random.number(2e-3), -1.2e-3 + random.number(0.6e-3));
    double last = full;
    for (const double radius : {0.5e-3, 0.7e-3, 0.9e-3}) {
      if (std::abs(ideal(at)) > radius && ideal(at) < 0) continue;  // wholly inside: nothing more is cut
      const double points = judged.of(without([&](const dvec3& p) { return std::min(ideal(p), ball(at, radius)(p)); })).points;
      ASSERT_LT(points, last) << i << " " << radius;
      last = points;
    }
  }
}

TEST(CavityLaws, LeavingSomeOfTheIdealLowersTheScoreTheMoreTheLower) {
  Random random(13);
  const auto ideal = tapered_box({1.4e-3, 1e-3}, 1.5e-3, 3 * kPi / 180);
  Judged judged(ideal);
  const double full = score(judged.input, judged.rules).points;
  for (int i = 0; i < 4; ++i) {
    const dvec3 at = kMiddle + dvec3(random.number(1.4e-3), random.number(1e-3), -1.5e-3 + std::abs(random.number(0.5e-3)));
    double last = full;
    for (const double radius : {0.3e-3, 0.5e-3, 0.8e-3}) {
      const Score s = judged.of(without([&](const dvec3& p) { return std::max(ideal(p), -ball(at, radius)(p)); }));
      ASSERT_LT(s.points, last) << i << " " << radius;
      last = s.points;
    }
  }
  // Nothing done at all earns nothing, though nothing was cut too much.
  const Score none = judged.of(judged.preparation.before);
  EXPECT_EQ(none.completion, 0);
  EXPECT_EQ(none.points, 0);
  EXPECT_DOUBLE_EQ(none.full, score(judged.input, judged.rules).full);
}

TEST(CavityLaws, AskedForAndNotThereEarnsNothingButCounts) {
  Judged judged(tapered_box({1.4e-3, 1e-3}, 1.5e-3, 0));
  const Score none = judged.of(judged.preparation.before);
  const auto item = std::find_if(none.items.begin(), none.items.end(), [](auto& i) { return i.name == "taper_deg"; });
  ASSERT_NE(item, none.items.end());
  EXPECT_TRUE(std::isnan(item->value));
  EXPECT_EQ(item->points, 0);
  EXPECT_EQ(item->weight, 1);
}

}  // namespace
}  // namespace typodont::session
